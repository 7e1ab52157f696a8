"""A part that goes over a station: seen, named, approved and sent, in Chromium."""

import functools
import re
from dataclasses import replace

import numpy as np
import pytest
from hands import typed
from patient import PATIENT
from playwright.sync_api import expect
from test_page import approve, watch

from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared.playback import timeline
from workbench.journal.journal import Journal

SEED = 3
"""Of a pile of two cylinders, none of which any grasp brings to its place."""

LEGS = ("reach", "approach", "extract", "return", "put on station", "home")
AFTER = ("reach", "OVER", "OVER", "return", "place", "home")
"""Legs of the two plans on the page; OVER: as the part is taken anew."""


@pytest.fixture
def bench(robot, tmp_path):
    cell = read_cell("robots/yumi/regrasp.toml")
    cell = replace(cell, controller=robot.controller(cell.controller))
    effects = functools.partial(EffectRunner, patience=PATIENT)
    bench = Bench(cell, Journal(tmp_path / "session"), effects=effects)
    yield bench
    bench.close()


def shown(served, name):
    """What all browsers see of that name; None where there is nothing."""
    return served._renderer._server.scene.get_handle_by_name(name)


def is_drawn_at(served, time):
    return abs(served._renderer._drawn.look.time - time) < 0.01


# The film waits for each drawing, which the processor makes here.
@pytest.mark.timeout(1200)
def test_a_part_goes_over_a_station_before_the_eyes_of_who_approves_it(
    served, screen, bench, reaches, wait
):
    station = bench.cell.stations[0]
    T_world_station = bench.cell.T_world_station(station)
    at = np.array(shown(served, f"/stations/{station.name}").position)
    np.testing.assert_allclose(at, T_world_station.translation)
    assert shown(served, f"/stations/{station.name}/label").text == "station post"
    assert tuple(shown(served, f"/stations/{station.name}/surface").dimensions)[:2] == (0.05, 0.05)

    typed(screen, "Parts", 2)
    typed(screen, "Seed", SEED)
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.press("Plan")
    state = reaches("planned")
    first, second = state.plans
    screen.wait_for("2 picks in a row, two of them for a part that goes over a station")
    part = f"part-{first.arms[0].detection + 1}"
    screen.wait_for(f"{part} {first.arms[0].arm}, to station post")
    screen.shoot("s1-planned")

    is_over = first.arms[0].arm != second.arms[0].arm
    again = "hand over" if is_over else "regrasp"
    screen.tab("Plan")
    blocks = screen.page.locator(".wb-lanes .wb-block")
    expect(blocks).to_have_count(len(LEGS) + len(AFTER))
    by_time = sorted(
        blocks.all(),
        key=lambda one: float(re.findall(r"left: ?([\d.]+)%", one.get_attribute("style"))[0]),
    )
    names = [one.get_attribute("title").split(":")[0] for one in by_time]
    assert names == [*LEGS, *(again if one == "OVER" else one for one in AFTER)]
    legend = screen.page.locator(".wb-legend").first
    assert [word in legend.inner_text() for word in ("put on station", again)] == [True, True]

    runs = timeline(*state.plans)
    put = next(run for run in runs if run.words == "put on station")
    stands = np.array(second.detections[second.arms[0].detection].T_world_part.translation)
    ways = {
        "carried": ((put.start + put.end) / 2, f"{put.arm}: put on station"),
        "stands": ((put.end + next(r.start for r in runs if r.plan == 1)) / 2, f"{put.arm}: home"),
        "taken anew": (runs[-3].start - 0.05, f"{second.arms[0].arm}: {again}"),
    }
    seen = {}
    for what, (time, doing) in ways.items():
        typed(screen, "Time [s]", f"{time:.2f}")
        screen.page.locator(".wb-now", has_text=doing).wait_for()
        wait(functools.partial(is_drawn_at, served, time), what)
        screen.shoot(f"s2-{what.replace(' ', '-')}")
        seen[what] = np.array(shown(served, f"/parts/{part}").position)
        assert shown(served, "/placed/0") is None
    np.testing.assert_allclose(seen["stands"], stands, atol=1e-6)
    assert seen["carried"][2] > stands[2] + 0.01 and seen["taken anew"][2] > stands[2] + 0.01

    typed(screen, "Time [s]", 0)
    screen.tab("Cycle")
    watch(screen, bench, wait)
    approve(screen, "Anna")
    reaches("approved")
    screen.press("Send")
    wait(lambda: len(bench.state.sent_before) == 1, "the second plan to follow")
    assert bench.state.placed, "the bench knows that a part may be on the station"
    wait(lambda: served._renderer._drawn.state.sent_before, "that to be drawn")
    assert shown(served, "/placed/0") is None, "it is the part of the plan that stands there"
    done = reaches("done")
    assert done.parts_placed == 1 and not done.placed
    screen.wait_for("1 of 1 part reported placed")
    shall = bench.cell.arm(second.arms[0].arm).part_places[0].T_world_part.translation
    wait(
        lambda: np.linalg.norm(np.array(shown(served, f"/parts/{part}").position) - shall) < 0.002,
        "the part at its place",
    )
    screen.shoot("s3-done")
    assert [one for one in screen.errors if not re.search("favicon", one)] == []
