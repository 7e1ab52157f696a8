"""A bench on the YuMi cell whose machines answer at once, with results made beforehand."""

import queue
import threading
from dataclasses import dataclass, replace

import numpy as np

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.effects import Send, StartJob, StopSending
from workbench.app.core.people import ROBOT_LINK, WORKER
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.row import plan_row
from workbench.app.runtime.live import Live
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import PlanResult
from workbench.model.recipes.kit import KitItem
from workbench.model.recipes.recipe import Recipe
from workbench.model.release import PartReport
from workbench.model.scan import Detection, Scan


@dataclass(frozen=True)
class Results:
    """What each stage brings, all of the same cycle.

    `tells`: the robot says where it stands, and what became of each part.
    """

    cell: Cell
    scan: Scan
    detections: tuple[Detection, ...]
    planned: PlanResult
    tells: bool = False


def make_results() -> Results:
    cell = read_cell("yumi")
    floor = cell.bin.T_world_bin.translation
    grid = np.stack(np.meshgrid([-0.1, 0.0, 0.1], [-0.1, 0.0, 0.1], [0.0]), axis=-1).reshape(-1, 3)
    T = cell.scanner.T_world_scanner.inverse()
    scan = Scan((grid + floor) @ T.rotation.T + T.translation, T.inverse(), "a drawn floor")
    detections = tuple(
        Detection(
            "keyed_cylinder",
            pose_from_rpy(floor + np.array([x, y, 0.0191]), (np.pi / 2, 0.0, yaw)),
            0.9,
        )
        for x, y, yaw in ((-0.01, -0.07, 0.4), (0.01, 0.07, -0.6))
    )
    return Results(cell, scan, detections, plan_pick(cell, detections, scan.digest, seed=0))


def results_with_recipes() -> Results:
    """The same by a cell with the recipes 4 and 12."""
    usual = make_results()
    recipes = (Recipe(4, "left", strategy="left", threshold=0.05), Recipe(12, "slow", speed=0.1))
    return replace(usual, cell=replace(usual.cell, recipes=recipes))


def results_with_kit() -> Results:
    """The same by a recipe 7 whose kit is the two parts."""
    usual = make_results()
    pair = Recipe(7, "pairs", items=(KitItem("keyed_cylinder", 2),))
    cell = with_recipe(replace(usual.cell, recipes=(pair,)), pair.number)
    planned = plan_pick(cell, usual.detections, usual.scan.digest, seed=0)
    return replace(usual, cell=cell, planned=planned)


def results_with_bins() -> Results:
    """The same by a cell with the bins right and left, from the first of which parts are taken."""
    usual = make_results()
    box = replace(usual.cell.bin, name="right", number=1)
    away = pose_from_rpy((0, 3.0, 0)) * box.T_world_bin
    other = replace(box, name="left", number=2, T_world_bin=away)
    return replace(usual, cell=replace(usual.cell, bin=box, other_bins=(other,)))


def make_row(picks: int) -> Results:
    """Four parts that lie apart, all of which are taken in a row of so many plans at most."""
    usual = make_results()
    arms = tuple(replace(arm, passes_parts_on=True) for arm in usual.cell.arms)
    policy = replace(usual.cell.policy, pair_gap=0.01)
    cell = replace(usual.cell, arms=arms, policy=policy)
    floor = cell.bin.T_world_bin.translation
    places = ((-0.05, -0.08, 0.4), (0.05, 0.08, -0.6), (-0.05, 0.04, 1.2), (0.05, -0.05, 0.0))
    parts = tuple(
        Detection(
            "keyed_cylinder", pose_from_rpy(floor + [x, y, 0.0191], (np.pi / 2, 0.0, yaw)), 0.9
        )
        for x, y, yaw in places
    )
    planned = plan_row(cell, parts, usual.scan.digest, picks=picks)
    assert len(planned.plans) > 1
    return replace(usual, cell=cell, detections=parts, planned=planned, tells=True)


class Canned:
    """Effects whose results come at once; while `hold` is set, no job ends.

    `sent` are the digests of all plans that went out to a robot.
    """

    def __init__(self, results: Results, do) -> None:
        home = results.cell.joint_values({arm.name: arm.home for arm in results.cell.arms})
        self.live = Live(joints=home) if results.tells else Live()
        self.sent: list[str] = []
        self.hold = threading.Event()
        self._results, self._do = results, do
        self._wanted: queue.SimpleQueue = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def run(self, effect) -> None:
        if isinstance(effect, Send):
            self.sent.append(effect.plan.digest)
        self._wanted.put(effect)

    def close(self) -> None:
        self._wanted.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (effect := self._wanted.get()) is not None:
            try:
                self._answer(effect)
            except CommandRefused:
                continue  # somebody was quicker: the sending has ended, say

    def _answer(self, effect) -> None:
        results = self._results
        match effect:
            case StartJob(number=number, name=name) if not self.hold.is_set():
                found = {"scan": results.scan, "localize": results.detections}
                self._do(JobEnded(number, found.get(name, results.planned)), WORKER)
            case Send(plan=plan) if not self.hold.is_set():
                told = plan.arms if results.tells else ()
                parts = tuple(PartReport(one.arm, one.detection, True) for one in told)
                self._do(LinkEnded("", len(plan.arms), parts), ROBOT_LINK)
            case StopSending():
                self._do(LinkEnded("stopped", 0), ROBOT_LINK)
            case _:
                return
