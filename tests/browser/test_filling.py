"""A part that nobody prepared, in a real browser: from a STEP file to an emptied pile."""

from pathlib import Path

import pytest
from hands import settle, typed, unfold
from playwright.sync_api import expect

from workbench.app.filling import fill_process
from workbench.app.filling.fill import filled

ROOT = Path(__file__).resolve().parents[2]

WORK = 14_000.0
"""A quarter of what the button takes: piles are few."""


@pytest.fixture
def bench(own_bench):
    return own_bench


@pytest.fixture
def url(own_url):
    return own_url


@pytest.fixture
def small(monkeypatch):
    def fill(cell, part, report, given_up):
        return filled(cell, part, most=WORK, report=report, cancelled=given_up.is_set)

    monkeypatch.setattr(fill_process, "fill_apart", fill)


def entries(bench):
    parts = {part.name: part for part in bench.state.cell.parts}
    return parts["angle"].library.entries if "angle" in parts else ()


def test_a_step_file_becomes_a_part_whose_library_is_filled_and_whose_pile_is_emptied(
    screen, bench, wait, small
):
    screen.tab("Grasps")
    unfold(screen, "New part from a CAD file")
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Choose a CAD file")
    chooser.value.set_files(ROOT / "docs" / "bracket.step")
    screen.wait_for("closed")
    screen.shoot("filling_1_file")
    typed(screen, "Name", "angle")
    screen.press("Make the part")
    wait(lambda: any(part.name == "angle" for part in bench.state.cell.parts), "the new part")
    settle(screen.page, 500)
    screen.shoot("filling_2_made")
    unfold(screen, "Suggestions")
    screen.press("Fill the library")
    screen.wait_for("parts taken in simulated piles")
    screen.shoot("filling_3_under_way")
    wait(lambda: len(entries(bench)) > 0, "families of grasps")
    screen.wait_for("come out")
    settle(screen.page, 500)
    screen.shoot("filling_4_filled")
    screen.tab("Emptying")
    typed(screen, "Parts", 4)
    typed(screen, "Piles", 1)
    settle(screen.page, 300)
    screen.press("Empty piles")
    wait(lambda: bench.state.emptying is not None, "the piles to be empty")
    settle(screen.page, 500)
    screen.shoot("filling_5_emptied")
    pile = bench.state.emptying.plain[0]
    assert (pile.task.part, pile.task.count) == ("angle", 4) and pile.taken >= 3
    screen.tab("Grasps")
    screen.press("Undo")
    wait(lambda: not entries(bench), "the library as it was")
    expect(screen.page.get_by_text("Internal error")).to_have_count(0)
