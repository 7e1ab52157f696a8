"""Where parts stand: on stations, from which they are taken to their places, and after a plan."""

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.app.picking.pallets import boxes_around
from workbench.model.candidate import Candidate, Pick, Reason, Verdict
from workbench.model.cell import Cell, Policy
from workbench.model.derived.assembling import assembled_kinds, assembled_pose, rest_pose
from workbench.model.derived.by_recipe import kit_of, with_recipe
from workbench.model.derived.by_tcp import by_each_tcp, by_plan
from workbench.model.errors import JobCancelled
from workbench.model.geometry import Floats, transform
from workbench.model.messages.message import Message
from workbench.model.messages.parts import StationText
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.part import PartPlace, Station
from workbench.model.plan import ArmPlan, Plan
from workbench.model.recipes.recipe import NO_RECIPE
from workbench.model.recipes.seen_base import SeenBase
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.world import World
from workbench.planning.grasps.resting import resting_poses
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve
from workbench.planning.placing.assembling import placing_error
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import Cancelled, Report, never
from workbench.proof.claims.places.standing import standing_after
from workbench.proof.engine.robot import tree_of

ABOVE_STATION = 0.0005
"""[m] Height of a part above a station at the release, beyond the margin."""

STANDS_WITHIN = 2e-4
"""[m] Points of a part no higher than this are its contact points."""

BENEATH = 0.001
"""[m] Largest distance of a part from its support below."""

MOST_PAIRS = 6
"""Number of poses on a station to find, of which the quickest are planned."""

CHECKED = "check"
"""Names the scan of a check, which has none."""

FAR = 10.0
"""[m] Nothing in a cell is farther away."""

PICKS_COMPARED = 3
"""Picks of a part at a pose that are found before the soonest is taken."""


@dataclass(frozen=True, slots=True, eq=False)
class Stand:
    """A part's pose on a station, and the time [s] of the quickest pick from there to a place."""

    station: Station
    T_world_part: pin.SE3
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class StationSearch:
    """The request of both halves of the search; they end at `until` [s] of processor time."""

    cell: Cell
    scene: Scene
    policy: Policy
    arms: Sequence[str]
    seed: int
    until: float
    cancelled: Cancelled

    def stands(self, kind: str, report: Report) -> list[Stand]:
        """Poses on the station from which a part can be taken to a place, quickest first."""
        poses = resting_poses(self.cell.part(kind))
        every = [(station, T) for station in self.cell.stations for T in poses]
        found: list[Stand] = []
        for count, (station, T) in enumerate(every):
            note = ProgressText.STATION_POSES(number=count + 1, count=len(every))
            report(0.5 * count / len(every), note)
            looked = self.stand(kind, station, T)
            if isinstance(looked, Stand):
                found.append(looked)
        return sorted(found, key=lambda stand: stand.seconds)

    def stand(self, kind: str, station: Station, T: pin.SE3) -> Stand | Message:
        """A pose on a station with its quickest pick to a place, or why it is not possible."""
        points = transform(T, self.cell.part(kind).mesh.points)
        if not _is_on(points, station):
            return StationText.TOO_SMALL()
        T_world_part = self.cell.T_world_station(station) * T
        there, margin = Detection(kind, T_world_part), self.policy.margin
        world = World(self.cell, (there,), self.scene.obstacles, self.policy)
        above = _above(self.cell, station, T_world_part, margin)
        label = world.part_ways.standing_in(0, above, margin)
        if label is not None:
            return StationText.TOO_CLOSE(margin=margin, body=label)
        stands_on, around = (
            world.part_ways.standing_in(0, T_world_part, far) for far in (BENEATH, FAR)
        )
        # Where not all shapes are compared so, the proof will tell.
        if stands_on is None and around is not None:
            return StationText.NOT_CARRIED()
        refusals: list[Verdict] = []
        picks = list(self._picks(world, 0, refusals))
        if picks:
            return Stand(station, T_world_part, min(pick.seconds for pick in picks))
        if all(refusal.reason is Reason.OUT_OF_REACH for refusal in refusals) and refusals:
            return StationText.UNREACHABLE()
        return StationText.NO_GRASP()

    def pairs(
        self, number: int, stands: list[Stand], refusals: list[Verdict], report: Report
    ) -> list[Stand]:
        """Poses on the station to which a detected part can be brought, quickest first.

        The time is that of both picks.  The search ends at `MOST_PAIRS`.  Verdicts on infeasible
        picks are added to `refusals`.
        """
        found: list[Stand] = []
        for count, stand in enumerate(stands):
            report(0.5 + 0.3 * count / len(stands), ProgressText.STATION_PATHS(number=count + 1))
            at = cell_with(self.cell, self.scene.detections[number].part, stand, self.policy)
            world = World(at, self.scene.detections, self.scene.obstacles, self.policy)
            picks = list(self._picks(world, number, refusals))
            if picks:
                seconds = stand.seconds + min(pick.seconds for pick in picks)
                found.append(replace(stand, seconds=seconds))
            if len(found) == MOST_PAIRS:
                break
        return sorted(found, key=lambda pair: pair.seconds)

    def _picks(self, world: World, number: int, refusals: list[Verdict]) -> Iterator[Pick]:
        """The first feasible picks of a part; verdicts on the others are added."""
        count = 0
        for candidate, at in self._proposed(world):
            if self.cancelled():
                raise JobCancelled(CancelText.PLANNING())
            if processor_time() > self.until or count == PICKS_COMPARED:
                return
            is_asked = candidate.detection == number and candidate.arm in self.arms
            if is_asked and candidate.verdict.is_ok:
                result = resolve(at, candidate, seed=self.seed)
                if isinstance(result, Pick):
                    count += 1
                    yield result
                else:
                    refusals.append(result)

    def _proposed(self, world: World) -> Iterator[tuple[Candidate, World]]:
        """The candidates by one TCP of the tools after the other, each with its world."""
        for cell in by_each_tcp(world.cell):
            if cell is not world.cell:
                world = World(cell, world.detections, world.obstacles, self.policy)
            world.deadline = self.until
            yield from ((candidate, world) for candidate in propose(world))


def station_problems(cell: Cell) -> Iterator[Message]:
    """Problems of a cell's stations: those from which no part can be regrasped.

    If the cell has recipes, it is enough that one of them can regrasp a part.
    """
    cells = [with_recipe(cell, recipe.number) for recipe in cell.recipes] or [cell]
    for station in cell.stations:
        for part in cell.parts:
            by = [each for each in cells if part.name in [known.name for known in each.parts]]
            found = [_station_problem(each, station, part.name) for each in by]
            problems = [problem for problem in found if problem is not None]
            if problems and len(problems) == len(found):
                yield StationText.PROBLEM(station=station.name, part=part.name, problem=problems[0])


def _station_problem(cell: Cell, station: Station, kind: str) -> Message | None:
    """Why no part of a kind can be regrasped from a station; None when it can."""
    arms, around = [arm.name for arm in cell.arms], standing_before(cell, kind)
    search = StationSearch(cell, Scene("", (), around), cell.policy, arms, 0, math.inf, never)
    poses = resting_poses(cell.part(kind))
    if not poses:
        return StationText.UNSTABLE()
    looked = [search.stand(kind, station, T) for T in poses]
    problems = [found for found in looked if isinstance(found, Message)]
    return max(problems, key=problems.count) if len(problems) == len(looked) else None


def standing_before(cell: Cell, kind: str) -> tuple[Obstacle, ...]:
    """The parts of the assembly that stand before one of a kind comes, at the first places.

    They are in view there: whether a scan shows them is no matter of the station.
    """
    placed: list[Detection] = []
    for item in kit_of(cell):
        if item.part == kind:
            break
        if item.part not in assembled_kinds(cell):
            continue
        places = [place for arm in cell.arms for place in arm.places_for(item.part)]
        T = places[0].T_world_part if places and item.insertion is None else None
        if item.insertion is not None:
            T_base = assembled_pose(cell, boxes_around(cell, placed), item.insertion.base)
            T = None if T_base is None else T_base * item.insertion.T_base_part
        if T is not None:
            placed.append(Detection(item.part, T))
    return tuple(
        replace(box, seen=SeenBase(CHECKED, rest_pose(cell, box), np.zeros((6, 6)), visible=1.0))
        for box in boxes_around(cell, placed)
    )


def _is_on(points: Floats, station: Station) -> bool:
    """Whether a part's contact points are on a station; points (n, 3) [m] in its frame."""
    stands_on = points[points[:, 2] <= points[:, 2].min() + STANDS_WITHIN, :2]
    return bool((np.abs(stands_on) <= station.size / 2 - STANDS_WITHIN).all())


def _above(cell: Cell, station: Station, T_world_part: pin.SE3, margin: float) -> pin.SE3:
    """Release pose of a part above a station, at which it still keeps its margin."""
    up = np.asarray(cell.T_world_station(station).rotation[:, 2])
    return pin.SE3(T_world_part.rotation, T_world_part.translation + (margin + ABOVE_STATION) * up)


def cell_with(cell: Cell, kind: str, stand: Stand, policy: Policy) -> Cell:
    """A cell in which a part's only place is a pose on a station."""
    above = _above(cell, stand.station, stand.T_world_part, policy.margin)
    place = (PartPlace(above, kind),)
    return replace(
        cell,
        arms=tuple(replace(arm, Ts_world_place=(), part_places=place) for arm in cell.arms),
        recipe=NO_RECIPE,
    )


# The robot is built for it, and a film asks at every drawing.
@functools.lru_cache(maxsize=16)
def stands_on_station(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> pin.SE3 | None:
    """`T_world_part` of a part after its release over a station.

    None if the arm uses no station, or one that the cell does not have any more.
    """
    if arm_plan.station not in [station.name for station in cell.stations]:
        return None
    return standing_after(cell, tree_of(cell), plan, arm_plan).T_world_part


def put_down(cell: Cell, plan: Plan) -> tuple[Detection, ...]:
    """The parts of a plan at the poses where they stay.

    These are parts at places that keep them, in an assembly, and on stations until a later plan
    takes them.
    """
    kinematics, assembled = Kinematics(cell), assembled_kinds(cell)
    by = by_plan(cell, plan)
    placed: list[Detection] = []
    for arm_plan in plan.picks:
        arm, found = by.arm(arm_plan.arm), plan.detections[arm_plan.detection]
        if arm.keeps_parts or arm_plan.station or found.part in assembled:
            T = stands_on_station(cell, plan, arm_plan)
            if T is None:
                T = (
                    kinematics.tcp_pose(arm, np.asarray(arm_plan.leg("place").q[-1]))
                    * arm_plan.T_tcp_part
                )
            # A roll that the scan did not show is not known on the pallet, either.
            kept = Detection(found.part, T, roll_known=found.roll_known, roll_axis=found.roll_axis)
            if found.part in assembled and not arm_plan.station:
                kept = replace(kept, placing=placing_error(cell, found, arm_plan, T))
            placed.append(replace(kept, T_world_found=found.T_world_found or found.T_world_part))
    return tuple(placed)
