"""Where everything is at a moment of a plan: the pure half of the scrubber."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin

from workbench.app.picking.stations import stands_on_station
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import by_plan, by_taking, from_current_tcp
from workbench.model.derived.row_parts import parts_taken
from workbench.model.geometry import Floats
from workbench.model.plan import ArmPlan, Leg, Plan
from workbench.model.tools.legs import carried_on
from workbench.planning.kinematics.robot import Kinematics
from workbench.proof.claims.stages import NEAR_MARGIN_LEGS

AHEAD = 2.0
"""How far ahead on the plan's clock the robot is searched for [s]."""

AHEAD_STEP = 0.02
"""In which steps [s]."""

ARRIVED_WITHIN = 0.05
"""The robot is surely there [rad]."""

NOWHERE = 0.3
"""The robot is elsewhere [rad]."""

ON_STATION, AGAIN, OVER = "put on station", "regrasp", "hand over"
"""Names of the legs that put a part on a station, and that take it from there with the same arm or
with the other."""


@dataclass(frozen=True, slots=True, eq=False)
class Run:
    """One leg of one arm on the clock of a plan, or of a row; `start`, `end` [s].

    `plan` is the place of its plan in the row, `does` what people call the leg there; empty: by its
    name.  `tcp` is that of the arm's plan.  `tool`: what the arm carries on a change of its tool,
    empty: a bare flange; None: the mounted tool.
    """

    arm: str
    leg: Leg
    start: float
    end: float
    plan: int = 0
    does: str = ""
    tcp: str = ""
    tool: str | None = None

    @property
    def words(self) -> str:
        """What the leg is called on the page."""
        return self.does or self.leg.name


@dataclass(frozen=True, slots=True, eq=False)
class SyncPoint:
    """Where arms wait for each other: at `time` [s] all of `before` have ended, and `after` begins.

    Named by its number along the whole row, from 1 on: `S1`.
    """

    name: str
    time: float
    before: tuple[Run, ...]
    after: tuple[Run, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ArmMoment:
    """What one arm does at one time: its joints `q` (n,) [rad], its fingers' `opening` [m].

    `leg` is the leg under way, or the last one that was; None before the first.  `tool`: see `Run`.
    """

    q: Floats
    opening: float
    leg: Leg | None
    tool: str | None = None


def timeline(*row: Plan) -> tuple[Run, ...]:
    """Every leg with its start on one clock, that of a plan or of all plans of a row.

    The steps run one after the other, the legs within a step at the same time; a step lasts
    as long as the longest of its legs.
    """
    runs: list[Run] = []
    clock = 0.0
    for place, plan in enumerate(row):
        for step in plan.sequence:
            legs = [(plan.arm(arm), plan.arm(arm).leg(name)) for arm, name in step.runs]
            for arm_plan, leg in legs:
                does = _does(row, place, arm_plan, leg)
                tcp, tool = arm_plan.tcp, carried_on(arm_plan, leg.name)
                end = clock + leg.seconds
                runs.append(Run(arm_plan.arm, leg, clock, end, place, does, tcp, tool))
            clock += max((leg.seconds for _, leg in legs), default=0.0)
    return tuple(runs)


def sync_points(runs: tuple[Run, ...]) -> tuple[SyncPoint, ...]:
    """The points of a plan, or of all plans of a row, that arms reach together before they go on.

    A step begins when the last leg of the one before has ended.  Where one and the same arm does
    both, and no other anything, nobody waits.  Each plan of a row begins anew.
    """
    steps: dict[tuple[int, float], list[Run]] = {}
    for run in runs:
        steps.setdefault((run.plan, run.start), []).append(run)
    found: list[SyncPoint] = []
    for ((plan, _), before), ((next_plan, time), after) in pairwise(steps.items()):
        if plan == next_plan and len({run.arm for run in (*before, *after)}) > 1:
            name = f"S{len(found) + 1}"
            found.append(SyncPoint(name, time, tuple(before), tuple(after)))
    return tuple(found)


def _does(row: Sequence[Plan], place: int, arm_plan: ArmPlan, leg: Leg) -> str:
    """What a leg does with a part that goes over a station; empty where that is nothing special.

    Straight to the part on the station and straight up with it is one thing for people.
    """
    if not arm_plan.takes_part:
        return ""
    if arm_plan.station:
        return ON_STATION if leg.name == "place" else ""
    stands = row[place].detections[arm_plan.detection].T_world_found is not None
    if not stands or leg.name not in NEAR_MARGIN_LEGS:
        return ""
    before = (
        [other.arm for other in row[place - 1].arms if other.station] if place else [arm_plan.arm]
    )
    return AGAIN if arm_plan.arm in before else OVER


def moments(cell: Cell, runs: tuple[Run, ...], time: float) -> dict[str, ArmMoment]:
    """What every arm of the cell does at `time` [s], by name.

    Between two waypoints the joints move in proportion to the time.  Arms that do not move
    stand where they were: at home with closed fingers before their first leg, at the end of
    their latest leg after it.

    Args:
        cell: whose arms.
        runs: from `timeline`.
        time: on the plan's clock; before 0 counts as 0, after the end as the end.
    """
    found: dict[str, ArmMoment] = {}
    for arm in cell.arms:
        run = latest(runs, arm.name, time)
        if run is None:
            found[arm.name] = ArmMoment(arm.home, arm.tool.stroke[0], None)
        else:
            q = interpolate(run.leg.q, run.leg.t, time - run.start)
            found[arm.name] = ArmMoment(q, run.leg.opening, run.leg, run.tool)
    return found


def latest(runs: tuple[Run, ...], arm: str, time: float) -> Run | None:
    """The leg of an arm that is under way at `time` [s], or the last one before."""
    begun = [run for run in runs if run.arm == arm and run.start <= max(time, 0.0)]
    return begun[-1] if begun else None


def interpolate(q: Floats, t: Floats, time: float) -> Floats:
    """The row of `q` (n, dof) at `time` [s], passed at times `t` (n,), linear in between."""
    return np.array([np.interp(time, t, column) for column in q.T])


def arm_path(arm: Arm, runs: tuple[Run, ...], times: Floats) -> Floats:
    """The configurations (k, n) of one arm at `times` (k,) [s]; see `moments`."""
    path = np.tile(arm.home, (len(times), 1))
    for run in runs:
        if run.arm != arm.name:
            continue
        begun = times >= run.start
        for column, values in enumerate(run.leg.q.T):
            path[begun, column] = np.interp(times[begun] - run.start, run.leg.t, values)
    return path


def follow_plan(
    cell: Cell, runs: tuple[Run, ...], joints: Mapping[str, float], since: float
) -> float:
    """How far the robot has come: when on the plan's clock all arms stand as `joints` say.

    The robot may be slower or faster than planned, but keeps to the path.  So the answer is the
    first time after `since` from which on the path leads away from where the robot is; where
    that is not close, the best within reach.

    Args:
        cell: whose arms.
        runs: from `timeline`.
        joints: values that the controller reports [rad or m]; arms not in it are not compared.
        since: the answer before, 0 at first.

    Returns:
        Seconds on the plan's clock, `since` when the robot is nowhere near the plan.
    """
    arms = [arm for arm in cell.arms if all(joint in joints for joint in arm.joints)]
    if not arms or not runs:
        return since
    times = since + np.arange(0.0, AHEAD, AHEAD_STEP)
    away = np.zeros(len(times))
    for arm in arms:
        reported = np.array([joints[joint] for joint in arm.joints])
        away = np.maximum(away, np.abs(arm_path(arm, runs, times) - reported).max(axis=1))
    leads_away = np.flatnonzero(np.diff(away) >= 0)
    best = int(leads_away[0]) if len(leads_away) else len(times) - 1
    if away[best] > ARRIVED_WITHIN:
        best = int(np.argmin(away))
    if away[best] > NOWHERE:
        return since
    return float(min(times[best], max(run.end for run in runs)))


def joint_values(cell: Cell, now: Mapping[str, ArmMoment]) -> dict[str, float]:
    """The value of every joint of the moving arms, by name [rad or m]."""
    return cell.joint_values({arm: moment.q for arm, moment in now.items()})


def part_poses(
    cell: Cell, kinematics: Kinematics, row: Sequence[Plan], runs: tuple[Run, ...], time: float
) -> tuple[pin.SE3, ...]:
    """`T_world_part` of every detection of the first plan of a row at `time` [s].

    A part lies where it was found until its arm extracts it, then moves with the hand, and
    stays where the hand left it; one that was put on a station stands there.
    """
    poses = [detection.T_world_part for detection in row[0].detections]
    for place, plan in enumerate(row):
        for number, arm_plan in zip(parts_taken(row[0], plan), plan.picks, strict=True):
            carried = [
                run
                for run in runs
                if (run.plan, run.arm) == (place, arm_plan.arm)
                and run.leg.holding
                and run.start <= time
            ]
            if carried:
                arm, run = by_plan(cell, plan).arm(arm_plan.arm), carried[-1]
                q = interpolate(run.leg.q, run.leg.t, min(time, run.end) - run.start)
                poses[number] = kinematics.tcp_pose(arm, q) * arm_plan.T_tcp_part
                if arm_plan.station and run.leg.name == "place" and time >= run.end:
                    poses[number] = stands_on_station(cell, plan, arm_plan) or poses[number]
    return tuple(poses)


def in_hands(
    cell: Cell, row: Sequence[Plan], runs: tuple[Run, ...], time: float
) -> dict[str, tuple[str, pin.SE3]]:
    """What each arm holds at `time` [s], by its name: the kind of part, and `T_tcp_part`.

    The TCP is the first one of the tool, whatever the plan takes the part with.
    """
    found: dict[str, tuple[str, pin.SE3]] = {}
    for arm in cell.arms:
        run = latest(runs, arm.name, time)
        plan = None if run is None else row[run.plan]
        if run is not None and plan is not None and plan.picks and run.leg.holding:
            arm_plan = plan.arm(arm.name)
            T_first_tcp = from_current_tcp(arm.tool, arm_plan.tcp)
            part = plan.detections[arm_plan.detection].part
            found[arm.name] = part, T_first_tcp * arm_plan.T_tcp_part
    return found


def tcp_path(kinematics: Kinematics, cell: Cell, run: Run, *, points: int) -> Floats:
    """The way of the tool centre point along one leg, shape (points, 3) [m], world frame."""
    arm = by_taking(cell, run).arm(run.arm)
    times = np.linspace(run.start, run.end, points)
    path = arm_path(arm, (run,), times)
    return np.array([kinematics.tcp_pose(arm, q).translation for q in path])
