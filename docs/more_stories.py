"""More stories: what is set up once, and what is looked at afterwards."""

import math
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from hands import Camera, field, first_look, settle
from page_stories import cycle, fault, plan, show_time
from picture_tools import ROOT, SIZE, Desk, desk, save, settled, window
from playwright.sync_api import Browser

from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.review.history import History
from workbench.cli.serving.demo import Cycle
from workbench.formats.cells.reading import read_cell
from workbench.gui.cell.panel import GIZMO
from workbench.gui.page.server import serve
from workbench.gui.scene.stage import T_WORLD_STAGE, view_of
from workbench.gui.shared.movable_frames import BIN, move_frame
from workbench.gui.shared.playback import OVER, timeline
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.part import GraspPattern
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.kinematics.chain import chain_of, is_solution

PART = "keyed_cylinder"
SIDE = math.radians(-100)
"""From where the hand comes to the part, so that it is seen from its side."""

ROW_SEED = 6
"""Of a pile of four parts that lie apart."""

REGRASP = "robots/yumi/regrasp.toml"
STATION_SEED = 3
"""Of a pile of two parts, one of which goes from one arm over the post to the other."""

CYCLES = 6
MOMENT = 30
"""Which entry of the recorded session is shown."""

FILM = "5"
"""[s] Which moment of the film is shown."""

PLOTS = {
    "threshold": "study threshold --cycles 60",
    "planners": "bench planners --targets 60 --iterations 5 20 100 500",
}
"""Picture and the command that draws it."""


def grasps(chrome: Browser, folder: Path) -> None:
    """A grasp put on the part with the mouse, and repeated around it."""
    with desk(chrome, folder, speed=20) as at:
        screen, page = at.screen, at.page
        screen.tab("Grasps")
        screen.press("Edit grasps")
        page.wait_for_timeout(3000)
        camera = Camera(page, *view_of(at.bench.state.cell.part(PART)))
        aim = np.array([math.cos(SIDE), math.sin(SIDE), 0.0])
        point = np.array([0.0, 0.0, -0.012]) + 0.015 * aim
        screen.press("Add grasp")
        page.wait_for_timeout(500)
        page.mouse.click(*camera.pixel(T_WORLD_STAGE.act(point)))
        at.wait(lambda: len(entries(at)) == 2, "the grasp that was clicked")
        page.mouse.move(400, 780)
        at.shoot("grasps")
        unfold(at, "Copies and patterns")
        for label, typed in (("Around [deg]", "5 x 72"), ("Along [mm]", "3 x 6 from -6")):
            box = field(screen, label)
            box.fill(typed)
            box.press("Tab")
            page.wait_for_timeout(300)
        screen.press("Repeat")
        at.wait(lambda: isinstance(entries(at)[1], GraspPattern), "the pattern")
        at.shoot("grasp_pattern")


def entries(at: Desk):
    """Of the part's library, as it is now."""
    return at.bench.state.cell.part(PART).library.entries


def unfold(at: Desk, title: str) -> None:
    """Open a folder of controls."""
    at.page.get_by_text(title, exact=True).click()
    at.page.wait_for_timeout(500)


def cell(chrome: Browser, folder: Path) -> None:
    """An arm jogged into the wall of the bin."""
    with desk(chrome, folder, speed=20) as at:
        now = at.bench.state.cell
        arm, q = now.arms[0], in_the_wall(now)
        at.screen.tab("Cell")
        at.screen.press("Jog")
        at.screen.wait_for("Clear; nearest: ")
        for axis, (k, sign) in enumerate(zip(arm.axis_order, arm.axis_signs, strict=True)):
            box = field(at.screen, f"Axis {axis + 1} [deg]")
            box.fill(f"{sign * math.degrees(q[k]):.1f}")
            box.press("Enter")
            at.page.wait_for_timeout(150)
        at.page.locator(".wb-contacts tr", has_text="bin_wall_back").first.wait_for()
        at.page.get_by_text("Go home").last.scroll_into_view_if_needed()
        at.shoot("cell")


def live_verdicts(chrome: Browser, folder: Path) -> None:
    """The bin is dragged to the side: how many grasps would still work, before anybody lets go."""
    with desk(chrome, folder, speed=20) as at:
        for button, phase in (("Scan", "scanned"), ("Find parts", "localized")):
            at.screen.press(button)
            at.wait(lambda phase=phase: at.bench.state.phase == phase, phase)
        at.screen.tab("Cell")
        at.screen.press("Show gizmo")
        settle(at.page, 2000)
        now = at.bench.state.cell
        camera, p = first_look(at.page, now), now.bin.T_world_bin.translation
        tip = p + [0.0, 0.9 * GIZMO, 0.0]
        at.page.mouse.move(*camera.pixel(tip))
        settle(at.page, 500)
        at.page.mouse.down()
        settle(at.page, 200)
        at.page.mouse.move(*camera.pixel(tip + [0.0, 0.015, 0.0]), steps=8)
        at.screen.wait_for("while you drag: ")
        settle(at.page, 2000)
        at.shoot("live_verdicts")
        at.page.mouse.up()


def in_the_wall(now: Cell) -> Floats:
    """A configuration of the right arm with the tool in a wall of the bin."""
    arm, chain = now.arms[0], chain_of(now, now.arms[0])
    length, _, height = now.bin.size
    starts = np.random.default_rng(0).uniform(chain.lower, chain.upper, (60, len(arm.home)))
    for turn in (0.0, math.pi / 2, -math.pi / 2):
        p_bin = (-(length + now.bin.wall) / 2, -0.05, height - 0.02)
        T = now.bin.T_world_bin * pose_from_rpy(p_bin, (math.pi, 0, turn))
        answers, residuals = chain.solve(T, np.vstack([arm.home, starts]))
        found = answers[is_solution(residuals)]
        if len(found):
            return found[0]
    raise RuntimeError("the arm does not reach the wall")


def calibration(chrome: Browser, folder: Path) -> None:
    """Five poses of the plate, one of them looked at."""
    with desk(chrome, folder, speed=20) as at:
        screen = at.screen
        screen.tab("Calibration")
        for count in range(1, 6):
            screen.press("Suggest a pose")
            at.page.wait_for_timeout(1500)
            screen.wait_for("as it is jogged on the page")
            screen.press("Scan the plate")
            at.wait(lambda count=count: len(at.bench.state.observations) == count, f"pose {count}")
        at.page.locator(".wb-poses:visible tbody tr").nth(1).click()
        screen.wait_for("Points near the robot")
        at.page.wait_for_timeout(1500)
        at.shoot("calibration")


def bin_moved(chrome: Browser, folder: Path) -> None:
    """A scan of the bin 15 mm from where the cell has it."""
    with desk(chrome, folder, speed=20) as at:
        now = at.bench.state.cell
        T = now.bin.T_world_bin * pose_from_rpy((0.015, 0.0, 0.0), (0.0, 0.0, math.radians(3)))
        at.bench.do(UseScan(synthesize(move_frame(now, BIN, T), (), seed=0)), "Ada")
        at.screen.wait_for("it was moved, or the scanner is not calibrated")
        at.shoot("bin_moved")


def statistics(chrome: Browser, folder: Path) -> None:
    """Some cycles, counted; then a recorded session."""
    with desk(chrome, folder, speed=8) as at:
        for number in range(CYCLES):
            Cycle(at.bench, number + 1, [], lambda done, note: None).run(number)
            if number == 3:
                taken = at.bench.state.plan.arms[0].detection
                at.bench.do(ReportPick(taken, False, "slipped"), "Ada")
        at.screen.tab("Statistics")
        at.page.wait_for_timeout(2000)
        at.shoot("statistics")
    # A copy, since whoever opens a journal writes beside it.
    journal = Journal(shutil.copytree(ROOT / "sessions" / "example", folder / "example"))
    page = serve(History(journal), port=0)
    try:
        with window(chrome, page.url) as screen:
            box = field(screen, "Entry")
            box.fill(str(MOMENT))
            box.press("Enter")
            save(settled(screen.page), "recorded")
    finally:
        page.close()
        journal.close()


def plan_pile(at: Desk, parts: int, seed: int) -> None:
    """A pile of so many parts, scanned, found and planned."""
    for label, value in (("Parts", parts), ("Seed", seed)):
        box = field(at.screen, label)
        box.fill(str(value))
        box.press("Tab")
        at.page.wait_for_timeout(300)
    at.screen.press("Scan")
    at.reach("scanned")
    at.screen.press("Find parts")
    at.reach("localized")
    plan(at)


def row(chrome: Browser, folder: Path) -> None:
    """Plans in a row for four parts that lie apart."""
    with desk(chrome, folder, speed=20, changed=with_rows) as at:
        plan_pile(at, 4, ROW_SEED)
        # What lets a robot move stays over the end of the tab: to the middle, not just into view.
        length = at.page.get_by_text("Length of the row:")
        length.evaluate("one => one.scrollIntoView({block: 'center'})")
        at.page.mouse.move(400, 780)
        at.shoot("row")


def with_rows(now: Cell) -> Cell:
    """Parts are taken away at once where they are put, and others 10 mm off stay as they lie."""
    arms = tuple(replace(arm, passes_parts_on=True) for arm in now.arms)
    return replace(now, arms=arms, policy=replace(now.policy, pair_gap=0.01, picks=3))


def station(chrome: Browser, folder: Path) -> None:
    """A part that goes over a station, as the other arm is about to take it."""
    with desk(chrome, folder, speed=20, changed=lambda _: read_cell(REGRASP)) as at:
        plan_pile(at, 2, STATION_SEED)
        at.screen.tab("Plan")
        taken = next(run for run in timeline(*at.bench.state.plans) if run.words == OVER)
        show_time(at, taken.end)
        at.page.mouse.move(400, 780)
        at.shoot("station")


def emptying(chrome: Browser, folder: Path) -> None:
    """Piles emptied in simulation, and the film of one of them, half way."""
    with desk(chrome, folder, speed=20) as at:
        screen, page = at.screen, at.page
        screen.tab("Emptying")
        for label, value in (("Parts", 5), ("Piles", 3)):
            box = page.get_by_label(label, exact=True).locator("visible=true")
            box.fill(str(value))
            box.press("Tab")
            page.wait_for_timeout(300)
        screen.press("Empty piles")
        at.wait(lambda: at.bench.state.emptying is not None, "the piles to be empty")
        screen.press("Play film")
        box = field(screen, "Film [s]")
        box.fill(FILM)
        box.press("Enter")
        page.mouse.move(400, 780)
        at.shoot("emptying")


def plots(chrome: Browser, folder: Path) -> None:
    """What the quick measurements draw."""
    for name, typed in PLOTS.items():
        file = folder / f"{name}.html"
        words = [sys.executable, "-m", "workbench", *typed.split(), "--plot", str(file)]
        subprocess.run(words, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
        page = chrome.new_page(viewport=SIZE)
        page.goto(file.as_uri())
        page.locator(".main-svg").first.wait_for()
        save(settled(page), name)
        page.close()


STORIES: dict[str, Callable[[Browser, Path], None]] = {
    "cycle": cycle,
    "fault": fault,
    "grasps": grasps,
    "cell": cell,
    "live_verdicts": live_verdicts,
    "calibration": calibration,
    "bin_moved": bin_moved,
    "row": row,
    "station": station,
    "statistics": statistics,
    "emptying": emptying,
    "plots": plots,
}
