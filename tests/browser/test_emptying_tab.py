"""A full bin emptied in simulation, in a real browser: asked for, counted, and seen as a film."""

import numpy as np
import pytest
from hands import field, settle
from playwright.sync_api import expect

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.cycle.scanning import UseScan
from workbench.gui.page.server import serve
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture
def page(bench):
    page = serve(bench, port=0, most_points=4000)
    yield page
    page.close()


@pytest.fixture
def url(page):
    return page.url


def fill(screen, label: str, value: int) -> None:
    box = screen.page.get_by_label(label, exact=True).locator("visible=true")
    box.fill(str(value))
    box.press("Tab")
    settle(screen.page, 120)


def places(page) -> dict[str, np.ndarray]:
    """Where the parts of the film are, in the only browser that is there."""
    (visitor,) = page._renderer._visitors.values()
    scene = visitor.client.scene
    names = [f"part-{number}" for number in range(1, 8)]
    nodes = {name: scene.get_handle_by_name(f"/film/{name}") for name in names}
    return {name: np.array(node.position) for name, node in nodes.items() if node is not None}


def test_a_pile_is_emptied_counted_and_shown_as_a_film(screen, page, bench, wait):
    # By the library alone something stays.
    bench.do(EditPart("keyed_cylinder", searches=False), "Ada")
    screen.tab("Emptying")
    screen.wait_for("is shown here, and what stays, once piles were emptied")
    fill(screen, "Parts", 7)
    fill(screen, "Piles", 1)
    fill(screen, "Seed", 13)
    screen.press("Empty piles")
    wait(lambda: bench.state.emptying is not None, "the pile to be empty")
    pile = bench.state.emptying.plain[0]
    assert (pile.task.count, pile.task.seed, pile.task.seen) == (7, 13, "truth")
    assert 0 < pile.taken < 7, "this seed is for a pile of which something stays"
    row = screen.page.locator(".wb-piles tbody tr")
    expect(row).to_have_count(1)
    expect(row).to_contain_text(f"{pile.taken} of 7")
    expect(screen.page.locator(".wb-left tbody tr")).to_have_count(len(pile.left))
    kind = str(pile.left[0].kind_message)
    expect(screen.page.locator(".wb-left tbody tr").first).to_contain_text(kind)
    screen.shoot("emptying")

    screen.press("Play film")
    # Looked at before anything that takes a browser on a busy machine as long as the first pick.
    wait(lambda: len(places(page)) == 7, "the pile as it fell")
    began = places(page)
    screen.page.locator('.wb-mode[data-mode="film"]').wait_for()
    expect(screen.page.locator(".wb-mode")).to_contain_text("Simulation")
    expect(screen.page.locator(".wb-mode")).to_contain_text("nothing is sent")
    wait(
        lambda: any(
            name not in places(page) or np.linalg.norm(places(page)[name] - at) > 0.05
            for name, at in began.items()
        ),
        "a part that is taken",
    )
    screen.shoot("emptying_film")
    # A moment that is typed while it plays is shown by the slider, too.  The film may write its own
    # over it before the key is pressed: then one types again, as a person does.
    box = field(screen, "Film [s]")
    (visitor,) = page._renderer._visitors.values()

    def typed() -> bool:
        box.fill("1")
        box.press("Enter")
        screen.page.wait_for_timeout(1000)
        return visitor.own.now.film.time == 1.0 and not visitor.own.now.film.is_playing

    wait(typed, "the moment that is typed")
    expect(box).to_have_value("1")
    screen.press("What stays")
    wait(lambda: len(places(page)) == len(pile.left), "what stays")
    screen.wait_for(f"The end: {pile.taken} of 7 taken, {len(pile.left)} left")
    screen.page.locator(".wb-left tbody tr").first.click()
    expect(screen.page.locator(".wb-left tbody tr").first).to_have_attribute(
        "style", "background:var(--wb-chosen)"
    )
    screen.shoot("emptying_stays")

    # Nobody goes on looking at a simulation while something real comes in.
    bench.do(UseScan(synthesize(bench.state.cell, (), seed=1)), "ada")
    screen.page.locator('.wb-mode[data-mode="film"]').wait_for(state="detached")
    wait(lambda: not places(page), "the end of the film")
    assert screen.errors == []


def test_progress_is_told_and_the_task_can_be_cancelled(screen, bench, wait):
    screen.tab("Emptying")
    fill(screen, "Piles", 20)
    screen.press("Empty piles")
    wait(lambda: bench.state.job is not None, "the task")
    wait(lambda: "of 15 taken" in str(bench.live.note), "its progress")
    expect(screen.page.locator(".wb-status")).to_contain_text("Pile 1 of 20")
    screen.press("Cancel task")
    wait(lambda: bench.state.job is None, "the end of the task")
    assert bench.state.emptying is None
    screen.wait_for("The emptying was cancelled")
