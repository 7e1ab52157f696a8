"""What `abb-socket/2` loads into a controller before anything moves: a plan as a program.

A program is a sequence of steps.  In each step one arm runs a leg while the other stands
(`alone`), or both run one: each at its own speed (`free`), or waypoint by waypoint together
(`sync`).  Before a step begins both arms stand; hands open and close then, and after that the
legs run.  That is what the proof of the plan presumes.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from workbench.devices.abb_loads import LoadData, load_data
from workbench.devices.abb_socket.messages import check_limits, in_degrees
from workbench.devices.legs import HandAction, hand_before, segment_seconds
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, frozen, put
from workbench.model.plan import Guarantee, Leg, LegName, Plan, Step, are_in_step
from workbench.model.release import Approval

Mode = Literal["alone", "free", "sync"]
Hand = Literal[HandAction, "uncouple", "couple"]
LoadOf = Literal["tool", "part", "next"]
"""Of the tool, the part that it takes, or the tool that it is changed for."""

COUPLING: Mapping[str, Hand] = {"retract": "uncouple", "undock": "couple"}
"""What happens to the tool before a leg."""

MOST_POINTS = 400
"""Waypoints of one arm that a controller has room for."""

MOST_LEGS = 24
"""Legs of one arm that a controller has room for."""

LONGEST_WAY = 99.999
"""[s] From one waypoint to the next, in whole milliseconds of five digits."""

MOST_LOAD = (999.999, 999.9, 99.99999)
"""[kg, mm, kg m2] Of a load: its mass, how far its centre of gravity is, its moments of inertia."""

TICKET = 16
"""Digits of the approval's digest that travel."""


@dataclass(frozen=True, slots=True, eq=False)
class ProgramLeg:
    """One motion of one arm.

    `q` (m + 1, n) [rad], chain order, first where the arm stands; `seconds` (m,) [s] from each
    waypoint to the next; `zone` rounds the corners, as a fraction of the neighbouring segments;
    `hand` happens before: fingers move to `opening` [m], or the tool is uncoupled or coupled.
    """

    arm: str
    name: LegName
    zone: float
    hand: Hand
    opening: float
    q: Floats
    seconds: Floats

    def __post_init__(self) -> None:
        put(self, q=frozen(self.q), seconds=frozen(self.seconds))


@dataclass(frozen=True, slots=True, eq=False)
class ProgramStep:
    """Legs that run at the same time, one of each arm at most."""

    mode: Mode
    legs: tuple[ProgramLeg, ...]


@dataclass(frozen=True, slots=True, eq=False)
class SocketProgram:
    """A plan as a controller runs it.

    `digest` is the plan's, `ticket` the beginning of the approval's: a controller runs each
    ticket once.  `starts` (arm -> (n,) [rad]) is where every arm has to stand before.
    `is_stepped`: it waits before each step until that one may run.  `loads` are those of the tool
    of an arm, of the part that it takes, and of the tool that comes next.
    """

    digest: str
    ticket: str
    starts: Mapping[str, Floats]
    steps: tuple[ProgramStep, ...]
    is_stepped: bool = False
    loads: Mapping[tuple[str, LoadOf], LoadData] = field(default_factory=dict[Any, LoadData])

    @property
    def legs(self) -> list[ProgramLeg]:
        """All legs, step after step."""
        return [leg for step in self.steps for leg in step.legs]


@dataclass(frozen=True, slots=True)
class ProgramLine:
    """One message of a program, still without its number; `arm` is empty where none is meant."""

    arm: str
    word: str
    rest: str


def program_of(cell: Cell, plan: Plan, approval: Approval) -> SocketProgram:
    """A plan as a program, slower than planned where the approval says so.

    Raises:
        InputError: it is too long or too slow for a controller, outside the limits of a joint, or
            moves more than two arms at once.
    """
    starts = {arm.name: np.asarray(arm.home) for arm in cell.arms}
    starts |= {arm_plan.arm: np.asarray(arm_plan.legs[0].q[0]) for arm_plan in plan.arms}
    before: dict[str, Leg] = {}
    share, ticket = approval.speed_share, approval.digest[:TICKET]
    steps = tuple(_step(cell, plan, step, before, share) for step in plan.sequence)
    loads: dict[tuple[str, LoadOf], LoadData] = {}
    for arm_plan in plan.arms:
        if arm_plan.loads is not None:
            loads[arm_plan.arm, "tool"] = load_data(arm_plan.loads.tool)
            if arm_plan.loads.part is not None:
                loads[arm_plan.arm, "part"] = load_data(arm_plan.loads.part)
            if arm_plan.loads.new_tool is not None:
                loads[arm_plan.arm, "next"] = load_data(arm_plan.loads.new_tool)
    program = SocketProgram(plan.digest, ticket, starts, steps, approval.is_stepped, loads)
    for arm in cell.arms:
        legs = [leg for leg in program.legs if leg.arm == arm.name]
        points = sum(len(leg.seconds) for leg in legs)
        if points > MOST_POINTS or len(legs) > MOST_LEGS:
            raise InputError(
                f"arm {arm.name} has {points} waypoints on {len(legs)} legs; a controller has "
                f"room for {MOST_POINTS} on {MOST_LEGS}"
            )
        for leg in legs:
            if np.any(np.asarray(leg.seconds) > LONGEST_WAY):
                raise InputError(
                    f"leg {leg.name} of arm {arm.name} takes {np.max(leg.seconds):.0f} s from one "
                    f"waypoint to the next; {LONGEST_WAY} s can be said"
                )
        for q in (starts[arm.name], *(leg.q for leg in legs)):
            check_limits(cell, arm, np.asarray(q))
    return program


def _step(cell: Cell, plan: Plan, step: Step, before: dict[str, Leg], share: float) -> ProgramStep:
    if len(step.runs) > 2:
        raise InputError(f"the protocol abb-socket/2 moves one arm or two, not {len(step.runs)}")
    legs = [plan.arm(name).leg(leg_name) for name, leg_name in step.runs]
    is_sync = plan.guarantee is Guarantee.SYNCHRONISED and len(legs) == 2 and are_in_step(legs)
    times = [
        segment_seconds(cell, name, leg, share)
        for (name, _), leg in zip(step.runs, legs, strict=True)
    ]
    if is_sync:
        times = [np.maximum(*times)] * 2
    said: list[ProgramLeg] = []
    for (name, leg_name), leg, seconds in zip(step.runs, legs, times, strict=True):
        hand = COUPLING.get(leg_name) or hand_before(leg, before.get(name))
        said.append(ProgramLeg(name, leg_name, cell.zone, hand, leg.opening, leg.q, seconds))
        before[name] = leg
    mode: Mode = "alone" if len(said) == 1 else "sync" if is_sync else "free"
    return ProgramStep(mode, tuple(said))


def lines_of(cell: Cell, program: SocketProgram) -> tuple[ProgramLine, ...]:
    """The messages that load a program, in their order, without the last two, `end` and `run`.

    Raises:
        InputError: the zone has more decimals than can be said.
    """
    return tuple(_lines(cell, program))


def _lines(cell: Cell, program: SocketProgram) -> Iterator[ProgramLine]:
    letters = {arm.name: arm.controller_id for arm in cell.arms}
    points = sum(len(leg.seconds) for leg in program.legs)
    yield ProgramLine("", "plan", program.digest)
    # A controller that cannot wait refuses a ticket of four words, and nothing has moved.
    stepped = " stepped" if program.is_stepped else ""
    yield ProgramLine(
        "", "ticket", f"{program.ticket} {len(program.legs):03d} {points:03d}{stepped}"
    )
    for arm in cell.arms:
        where = " ".join(in_degrees(arm, program.starts[arm.name]))
        yield ProgramLine(arm.name, "start", f"{arm.controller_id} {where}")
    # Controllers that know no loads refuse the first one, and nothing has moved.
    for (name, what), load in program.loads.items():
        mass, *cog = load.numbers[:4]
        if mass > MOST_LOAD[0] or max(map(abs, cog)) > MOST_LOAD[1]:
            raise InputError(f"the load of the {what} of arm {name} is more than can be said")
        if max(load.moments) > MOST_LOAD[2]:
            raise InputError(f"the inertia of the {what} of arm {name} is more than can be said")
        said = " ".join(f"{value:.1f}" for value in cog)
        yield ProgramLine(name, "load", f"{letters[name]} {what} {mass:.3f} {said}")
        turn = " ".join(f"{value:.4f}" for value in load.aom)
        moments = " ".join(f"{value:.5f}" for value in load.moments)
        yield ProgramLine(name, "axes", f"{letters[name]} {what} {turn} {moments}")
    for number, step in enumerate(program.steps, start=1):
        for leg in step.legs:
            if abs(leg.zone - round(leg.zone, 3)) > 1e-9:
                raise InputError(f"a zone of {leg.zone!r} has more than three decimals")
            yield ProgramLine(
                leg.arm,
                "leg",
                f"{number:02d} {letters[leg.arm]} {leg.name} {len(leg.seconds):03d} "
                f"{leg.zone:.3f} {leg.hand} {leg.opening * 1000:.1f} {step.mode}",
            )
            arm = cell.arm(leg.arm)
            for k, seconds in enumerate(leg.seconds.tolist(), start=1):
                where = " ".join(in_degrees(arm, np.asarray(leg.q[k])))
                yield ProgramLine(leg.arm, "to", f"{k:03d} {where} {seconds * 1000:05.0f}")
