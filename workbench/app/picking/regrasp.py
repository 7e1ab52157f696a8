"""A part that no grasp brings to its place, put on a station and taken anew from there."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.picking.pipeline import AS_THE_CELL, NOTHING, plan_pick
from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.cell import Cell, PlanOverrides, Policy, Station
from workbench.model.errors import JobCancelled
from workbench.model.part import PartPlace
from workbench.model.plan import Plan, PlanResult, Proven, Strategy
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.world import World
from workbench.planning.grasps.resting import resting_poses
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import Cancelled, Report, never, silent
from workbench.proof.prove import prove, scene_after

ABOVE = 0.0005
"""[m] So much more than the margin a part is above a station when it is let go of."""

FLAT = 2e-4
"""[m] Points of a part no higher than this are what it stands on."""

MOST_PARTS = 4
"""Parts that are tried, in the order of their candidates."""

MOST_STANDS = 6
"""Ways to stand on a station that are looked at for each part, the soonest left ones first."""

MOST_PLANNED = 4
"""Pairs of picks that are planned, the soonest done ones first."""

ENOUGH = 3
"""Picks of a part at a pose that are found before the soonest is taken."""


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """A part's pose on a station, and the time [s] of the quickest pick from there to a place."""

    station: Station
    T_world_part: pin.SE3
    seconds: float


def regrasped(
    cell: Cell,
    scene: Scene,
    refused: PlanResult,
    *,
    strategy: str = "auto",
    overrides: PlanOverrides = AS_THE_CELL,
    avoided: Mapping[int, str] = NOTHING,
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = never,
    **asked: Any,
) -> PlanResult:
    """A plan that puts a part on a station, with one in a row that takes it from there to a place.

    Looked for are the pose on the station, and for each plan the grasp and the arm, by the least
    time of both together.  Another arm may take the part than has put it there.

    Args:
        cell: with stations.
        scene: what is in the bin.
        refused: what planning has brought without stations.
        strategy: see `plan_pick`; one arm is at work at a time, so one for two brings nothing.
        overrides: see there, like all that follows.
        avoided: see there.
        seed: see there.
        report: progress.
        cancelled: asked between looks; True ends the work.
        asked: else as `plan_pick`.

    Returns:
        The two plans; where there are none, `refused` with a verdict that says so.

    Raises:
        JobCancelled: `cancelled` said so.
    """
    arms = [arm.name for arm in cell.arms if strategy in ("auto", "single", arm.name)]
    numbers = _that_have_no_place(scene, refused, avoided)[:MOST_PARTS]
    if not arms or not numbers:
        return refused
    began, policy = working_time(), overrides.on(cell.policy)
    search = _Search(cell, scene, policy, arms, seed, began + policy.seconds, cancelled)
    picks = dict(strategy=strategy, overrides=overrides, seed=seed, cancelled=cancelled, **asked)
    stands: dict[str, list[Stand]] = {}
    words = "no pose on a station from which it can be taken to a place"
    for count, number in enumerate(numbers):
        kind = scene.detections[number].part
        told = _within(report, count / len(numbers), (count + 1) / len(numbers))
        if kind not in stands:
            stands[kind] = search.stands(kind, told)
        pairs = search.pairs(number, stands[kind][:MOST_STANDS], told) if stands[kind] else []
        if stands[kind]:
            words = "the station cannot be reached with any grasp that takes it from the bin"
        for stand in pairs[:MOST_PLANNED]:
            told(0.8, "planning over a station")
            row, words = _planned(cell, scene, number, stand, policy, picks)
            if row is not None:
                first, second = row
                took = {**refused.seconds, "regrasp": working_time() - began}
                return replace(
                    refused,
                    plan=first.plan,
                    proof=first.proof,
                    verdict=Verdict(Reason.OK, Stage.ROUTE, note=first.plan.note),
                    seconds=took,
                    row=(second,),
                )
    note = "; ".join(filter(None, (refused.verdict.note, f"over a station: {words}")))
    return replace(refused, verdict=replace(refused.verdict, note=note))


def _that_have_no_place(
    scene: Scene, refused: PlanResult, avoided: Mapping[int, str]
) -> list[int]:
    """Parts that can be taken and not put down, in the order of their candidates."""
    numbers = [
        one.detection for one in refused.candidates if one.verdict.reason is Reason.NO_PLACE
    ]
    return [
        number
        for number in dict.fromkeys(numbers)
        if number not in avoided and scene.detections[number].roll_known
    ]


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """What both halves of the search are asked with; `until` [s] of working time they give up."""

    cell: Cell
    scene: Scene
    policy: Policy
    arms: list[str]
    seed: int
    until: float
    cancelled: Cancelled

    def stands(self, kind: str, report: Report) -> list[Stand]:
        """How a part of that kind can stand so that it can be taken to a place, soonest first."""
        part, found = self.cell.part(kind), list[Stand]()
        every = [(station, T) for station in self.cell.stations for T in resting_poses(part)]
        for count, (station, T) in enumerate(every):
            report(0.5 * count / len(every), f"pose {count + 1} of {len(every)} on a station")
            if not _is_on(part.mesh.points @ T.rotation.T + T.translation, station):
                continue
            T_world_part = self.cell.T_world_station(station) * T
            there = Detection(kind, T_world_part)
            picks = list(self._picks(self.cell, (there,), 0, self.scene.obstacles))
            if picks:
                found.append(Stand(station, T_world_part, min(one.seconds for one in picks)))
        return sorted(found, key=lambda one: one.seconds)

    def pairs(self, number: int, stands: list[Stand], report: Report) -> list[Stand]:
        """Those of some ways to stand into which a part found can be brought, soonest done first.

        Their time is that of both picks.
        """
        found: list[Stand] = []
        for count, stand in enumerate(stands):
            report(0.5 + 0.3 * count / len(stands), f"way to a station {count + 1}")
            at = _cell_with(self.cell, self.scene.detections[number].part, stand, self.policy)
            picks = list(self._picks(at, self.scene.detections, number, self.scene.obstacles))
            if picks:
                seconds = stand.seconds + min(one.seconds for one in picks)
                found.append(replace(stand, seconds=seconds))
        return sorted(found, key=lambda one: one.seconds)

    def _picks(
        self,
        cell: Cell,
        detections: tuple[Detection, ...],
        number: int,
        obstacles: tuple[Obstacle, ...],
    ) -> Iterator[Pick]:
        """The first picks of a part that work."""
        world, count = World(cell, detections, obstacles, self.policy), 0
        world.deadline = self.until
        for candidate in propose(world):
            if self.cancelled():
                raise JobCancelled("planning was cancelled")
            if working_time() > self.until or count == ENOUGH:
                return
            is_asked = candidate.detection == number and candidate.arm in self.arms
            if is_asked and candidate.verdict.is_ok:
                result = resolve(world, candidate, seed=self.seed)
                if isinstance(result, Pick):
                    count += 1
                    yield result


def _is_on(points: np.ndarray, station: Station) -> bool:
    """Whether what a part stands on is within a station; its points (n, 3) [m] are seen from it."""
    stands_on = points[points[:, 2] <= points[:, 2].min() + FLAT, :2]
    return bool((np.abs(stands_on) <= station.size / 2 - FLAT).all())


def _cell_with(cell: Cell, kind: str, stand: Stand, policy: Policy) -> Cell:
    """A cell in which a part has one place: that to stand on a station."""
    up = np.asarray(cell.T_world_station(stand.station).rotation[:, 2])
    T = stand.T_world_part
    above = pin.SE3(T.rotation, T.translation + (policy.margin + ABOVE) * up)
    place = (PartPlace(above, kind),)
    return replace(
        cell,
        arms=tuple(replace(arm, Ts_world_place=(), part_places=place) for arm in cell.arms),
    )


def _planned(
    cell: Cell,
    scene: Scene,
    number: int,
    stand: Stand,
    policy: Policy,
    picks: Mapping[str, Any],
) -> tuple[tuple[Proven, Proven] | None, str]:
    """The two plans over a way to stand, each proven; or why they are not to be had."""
    kind, name = scene.detections[number].part, stand.station.name
    at = _cell_with(cell, kind, stand, policy)
    result = plan_pick(
        at,
        scene.detections,
        scene.scan_digest,
        obstacles=scene.obstacles,
        avoided=_all_but(number, scene),
        **picks,
    )
    if result.plan is None:
        return None, f"no way to the station: {result.verdict}"
    plan = _as_in(cell, result.plan, name, f"regrasp: put on station {name}, taken anew")
    first = Proven(plan, prove(cell, scene, plan))
    if not first.proof.holds:
        return None, f"the proof refuses the way to the station: {first.proof.violations[0]}"
    after = scene_after(cell, plan)
    result = plan_pick(
        cell,
        after.detections,
        after.scan_digest,
        obstacles=after.obstacles,
        avoided=_all_but(len(after.detections) - 1, after),
        **picks,
    )
    if result.plan is None:
        return None, f"no way from the station: {result.verdict}"
    plan = _as_in(cell, result.plan, "", f"regrasp: taken from station {name}")
    second = Proven(plan, prove(cell, after, plan))
    if not second.proof.holds:
        return None, f"the proof refuses the way from the station: {second.proof.violations[0]}"
    return (first, second), ""


def _as_in(cell: Cell, plan: Plan, station: str, note: str) -> Plan:
    """The plan as one of this cell, with where it puts its part."""
    return replace(
        plan,
        cell_digest=cell.digest,
        arms=tuple(replace(one, station=station) for one in plan.arms),
        note="; ".join(filter(None, (note, plan.note))),
    )


def _all_but(number: int, scene: Scene) -> dict[int, str]:
    """Parts that are left alone while one is taken over a station."""
    why = "another part is brought to its place over a station"
    return {other: why for other in range(len(scene.detections)) if other != number}


def _within(report: Report, begin: float, end: float) -> Report:
    """Progress of a part of the work."""
    return lambda done, note: report(begin + (end - begin) * done, note)
