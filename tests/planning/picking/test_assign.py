"""Which picks are planned one after the other, and what is reported where none has a plan."""

from collections.abc import Iterator

import numpy as np
import pytest
from shipped import shipped

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import Plan
from workbench.model.scan import Detection
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.world import World
from workbench.planning.picking import assign, put_down
from workbench.planning.picking.assign import plan_first_feasible
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve
from workbench.planning.picking.route import phase_of
from workbench.plugins.progress import never

CELL = shipped("yumi")
FLOOR = CELL.bin.T_world_bin.translation
DETECTIONS = tuple(
    Detection("keyed_cylinder", pose_from_rpy(FLOOR + (0.0, y, 0.0191), (np.pi / 2, 0.0, 0.2)))
    for y in (-0.08, 0.08)
)
LATE = Verdict(Reason.OUT_OF_TIME, Stage.ROUTE)


@pytest.fixture(scope="module")
def world() -> World:
    return World(CELL, DETECTIONS)


@pytest.fixture(scope="module")
def picks(world) -> list[Pick]:
    found = [resolve(world, candidate, seed=0) for candidate in propose(world)]
    return [pick for pick in found if isinstance(pick, Pick)]


def test_out_of_time_is_reported_though_an_earlier_grasp_has_no_path(world, picks, monkeypatch):
    answers = iter([Verdict(Reason.NO_PATH, Stage.ROUTE), LATE])
    monkeypatch.setattr(assign, "_similar_picks", lambda *_, **names: [picks[:1], picks[1:2]])
    monkeypatch.setattr(assign, "_route", lambda *arguments, **names: next(answers))
    plans, verdict = plan_first_feasible(
        world, picks, "alternated", threshold=0.1, scan_digest="s", seed=0, cancelled=never
    )
    assert plans == () and verdict.reason is Reason.OUT_OF_TIME


def test_out_of_time_is_reported_though_an_earlier_place_is_refused(world, picks, monkeypatch):
    def descents(*arguments: object) -> Iterator[Verdict]:
        yield Verdict(Reason.NO_PLACE, Stage.PLACE)
        yield LATE

    monkeypatch.setattr(put_down, "plan_straight_descents", descents)
    met = Contact(("part-1", "part-2"), 0.0, 0.005), picks[0].place[-1]
    monkeypatch.setattr(put_down, "along_placed", lambda *arguments: met)
    found = put_down.put_down(world, picks[0], phase_of([], []))
    assert isinstance(found, Verdict) and found.reason is Reason.OUT_OF_TIME


def test_first_legs_that_meet_what_the_other_arm_has_placed_are_planned_anew(
    world, picks, monkeypatch
):
    since: list[int] = []
    route = assign.route

    def counting(*arguments, **names):
        since.append(names["since"])
        return route(*arguments, **names)

    def interleave(world: World, plan: Plan, *, freely: bool) -> tuple[Plan, ...]:
        return () if freely else (plan,)

    monkeypatch.setattr(assign, "route", counting)
    monkeypatch.setattr(assign, "interleave", interleave)
    plans, verdict = plan_first_feasible(
        world, picks, "auto", threshold=0.0, scan_digest="s", seed=0, cancelled=never
    )
    assert verdict.is_ok and len(plans[0].arms) == 2
    assert since[:2] == [assign.CARRYING, 0]
