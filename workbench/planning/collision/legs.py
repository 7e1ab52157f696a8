"""What holds for each leg and grip of an arm, in planning; the proof states the same anew."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate
from workbench.model.cell import Arm, Tool
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.part import Grasp
from workbench.model.plan import ArmPlan, Leg, LegName, Plan
from workbench.planning.collision.pairing import LegPhase

STRAIGHT: frozenset[LegName] = frozenset({"approach", "extract"})
"""Legs on which tool and held part may come as near as the policy's `near_margin`."""

HOLDING: frozenset[LegName] = frozenset({"extract", "return", "place", "lift", "carry"})
"""Legs with something in the hand; after `place` and `carry` it is released."""

FREE_STEP, TILT_STEP, SLIDE_STEP = math.radians(30.0), math.radians(15.0), 0.01
"""[rad, rad, m] What a grasp leaves free is tried this far apart, or closer."""

LEAVING: frozenset[LegName] = frozenset({"extract", "home"})
"""Legs on which a part comes away from what it lies on, or the arm from the part it has placed."""

TARGETED: frozenset[LegName] = frozenset({"approach"})
"""Legs on which the tool goes around the part that it takes."""


def hand_turns(tool: Tool) -> list[pin.SE3]:
    """Turns of the hand that change nothing, none at all first: two fingers can change places."""
    halves = (0.0, math.pi) if len(tool.fingers) == 2 else (0.0,)
    return [pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, half)) for half in halves]


@lru_cache(maxsize=1024)
def grips(tool: Tool, grasp: Grasp) -> tuple[pin.SE3, ...]:
    """Poses of the hand that are the same grip, in the authored TCP frame, that one first.

    What is left free is covered in steps, the least of it first.  Every stage asks for them again,
    so they are kept; they must not be changed.
    """
    ways = product(
        _steps(grasp.free_rotation, FREE_STEP),
        _steps(grasp.tilt, TILT_STEP),
        _steps(grasp.slide, SLIDE_STEP),
    )
    return tuple(
        pose_from_rpy((slide, 0.0, 0.0), (0.0, tilt, 0.0))
        * pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, turn))
        * T_hand_turned
        for (_, turn), (_, tilt), (_, slide) in sorted(ways, key=lambda way: sum(n for n, _ in way))
        for T_hand_turned in hand_turns(tool)
    )


MOST_OPENINGS = 3
"""Openings that are tried, from that of the grasp to the least."""


def openings(tool: Tool, grasp: Grasp, least_air: float | None) -> tuple[float, ...]:
    """How far open [m] fingers may arrive, the widest first: that of the grasp.

    `least_air` [m] is that of the policy.
    """
    least = _least_opening(tool, grasp, least_air)
    if least >= grasp.opening:
        return (grasp.opening,)
    return tuple(np.linspace(grasp.opening, least, MOST_OPENINGS).tolist())


def _least_opening(tool: Tool, grasp: Grasp, least_air: float | None) -> float:
    if least_air is None or not tool.fingers:
        return grasp.opening
    return min(max(grasp.grip + 2 * least_air, tool.stroke[0]), grasp.opening)


def turn_steps(most: float, step: float) -> list[float]:
    """0, and values up to `most` either way no more than `step` apart, the least first."""
    return [value for _, value in _steps(most, step)]


def _steps(most: float, step: float) -> list[tuple[int, float]]:
    """0, and values up to `most` either way no more than `step` apart, each with its rank."""
    count = math.ceil(most / step - 1e-9)
    values = [(k, sign * most * k / count) for k in range(1, count + 1) for sign in (1, -1)]
    return [(0, 0.0), *values]


def lead_of(leg: Leg, points: int) -> Floats:
    """The waypoints (k, n) [rad] that a leg begins with however it goes on.

    On the way home these are the `points` of the hand's linear motion out of the place.
    """
    return np.asarray(leg.q[: points if leg.name == "home" else 1])


Run = tuple[ArmPlan, LegName, float]
"""A leg of an arm, with the opening of its fingers [m]."""


def phase_of(runs: Sequence[Run], waiting: Sequence[Run] = ()) -> LegPhase:
    """What is true while some legs run.

    Args:
        runs: legs that run now, each of another arm.
        waiting: the last legs of arms that stand where these ended.
    """
    # A part is in the hand from the lift on, and lies where it was put once it has been placed.
    holding = [plan for plan, name, _ in runs if name in HOLDING and plan.takes_part]
    holding += [plan for plan, name, _ in waiting if name in HOLDING - {"place"}]
    placed = [plan for plan, name, _ in runs if name == "home"]
    placed += [plan for plan, name, _ in waiting if name in ("place", "home")]
    # An arm that stirs goes home, too, but has placed nothing.
    placed = [plan for plan in placed if plan.takes_part]
    return LegPhase(
        moving=frozenset(plan.arm for plan, _, _ in runs),
        openings={plan.arm: opening for plan, _, opening in (*runs, *waiting)},
        held={plan.arm: (plan.detection, plan.T_tcp_part) for plan in holding},
        placed={
            plan.arm: (plan.detection, plan.T_tcp_part, np.asarray(plan.leg("place").q[-1]))
            for plan in placed
        },
        targets={plan.arm: plan.detection for plan, name, _ in runs if name in TARGETED},
        straight=frozenset(plan.arm for plan, name, _ in runs if name in STRAIGHT),
        inserts=frozenset(plan.arm for plan, name, _ in runs if name == "place"),
    )


def approach_phase(candidate: Candidate, arm: Arm) -> LegPhase:
    """The phase in which an arm comes to the candidate's part with its fingers open."""
    return LegPhase(
        moving=frozenset({arm.name}),
        openings={arm.name: candidate.grasp.opening},
        targets={arm.name: candidate.detection},
        straight=frozenset({arm.name}),
    )


def holding_phase(
    candidate: Candidate, arm: Arm, T_tcp_part: pin.SE3, *, straight: bool
) -> LegPhase:
    """The phase of a leg with the candidate's part in the hand."""
    moving, held = frozenset({arm.name}), {arm.name: (candidate.detection, T_tcp_part)}
    line = moving if straight else frozenset[str]()
    return LegPhase(moving, {arm.name: candidate.grasp.grip}, held=held, straight=line)


def placing_phase(candidate: Candidate, arm: Arm, T_tcp_part: pin.SE3) -> LegPhase:
    """The phase of the last linear motion of the candidate's part to its place."""
    phase = holding_phase(candidate, arm, T_tcp_part, straight=False)
    return replace(phase, inserts=phase.moving)


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A step of a plan: which legs run, what is true meanwhile, and how the other arms stand.

    `standing` gives the configuration (n,) of each arm that waits; arms that are not named
    stand at home.
    """

    runs: tuple[tuple[ArmPlan, Leg], ...]
    phase: LegPhase
    standing: Mapping[str, Floats]


def stretches(plan: Plan) -> Iterator[Stretch]:
    """The steps of a plan in their order."""
    last: dict[str, tuple[ArmPlan, Leg]] = {}
    for step in plan.sequence:
        runs = tuple((plan.arm(arm), plan.arm(arm).leg(name)) for arm, name in step.runs)
        moving = {arm_plan.arm for arm_plan, _ in runs}
        waiting = [run for arm, run in last.items() if arm not in moving]
        phase = phase_of(_short(runs), _short(waiting))
        yield Stretch(runs, phase, {p.arm: np.asarray(leg.q[-1]) for p, leg in waiting})
        last.update({arm_plan.arm: (arm_plan, leg) for arm_plan, leg in runs})


def _short(runs: Iterable[tuple[ArmPlan, Leg]]) -> list[Run]:
    return [(arm_plan, leg.name, leg.opening) for arm_plan, leg in runs]
