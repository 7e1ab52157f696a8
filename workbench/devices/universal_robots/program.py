"""A plan as a program in URScript: `movej` from waypoint to waypoint, or `servoj` along each leg.

The whole program goes out at once and the controller runs it once: the program leaves its ticket in
an output register, and ends where it finds it there.  It writes into another one which leg it is
in; it is stopped by the controller when the input register that we keep writing falls silent.

Source: Universal Robots, "The URScript Programming Language", e-Series.
"""

import math
from dataclasses import dataclass

import numpy as np

from workbench.devices.universal_robots.blends import blend_lines
from workbench.devices.universal_robots.flange import Flange
from workbench.devices.universal_robots.rtde import ALIVE, BEGUN, PROGRESS, REFUSED, TICKETS
from workbench.devices.universal_robots.servo import Servo, references_of, stream_of
from workbench.devices.universal_robots.urscript import FLANGE, Line, seconds_of
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import by_taking, current_tcp
from workbench.model.derived.point_speeds import PointSpeeds, speeds_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.load import Load
from workbench.model.plan import Leg, Plan
from workbench.model.release import Approval

ANGLE_DIGITS = 6
"""Decimals of angles, speeds and accelerations [rad]."""

SHORTEST_WAY = 1e-9
"""[rad] A shorter way is none."""

STANDING = 4.0
"""[rad/s2] After a stream, whose last reference is repeated until the arm stands there."""


@dataclass(frozen=True, slots=True, eq=False)
class UrProgram:
    """The text, and the names of its legs in their order.

    `PROGRESS` holds `ticket` plus the number of the leg that runs, counted from 1: a controller
    that has run this program shows it.  `q_start`, `q_end` (6,) [rad] are in chain order; `seconds`
    is what each leg takes as it was planned, and sent: no less.
    """

    text: str
    legs: tuple[str, ...]
    ticket: int
    q_start: Floats
    q_end: Floats
    seconds: tuple[float, ...]
    references: tuple[Floats, ...] = ()

    @property
    def end(self) -> int:
        """What the register holds when all has been done."""
        return self.ticket + len(self.legs) + 1


@dataclass(frozen=True, slots=True)
class ProgramSettings:
    """What a program takes from the link's options.

    Digital output `output`, unless the TCP has its own, closes the gripper, or turns on the
    suction, which needs `grip_seconds` [s].  The controller stops when nobody writes `ALIVE` for
    `silence` [s].  `blend` [m] is the largest blend radius; at 0 the robot stops at each waypoint.
    `servo` says how references along each leg are followed, where they are streamed.
    `sends_inertia` goes by `set_target_payload`; older controllers have `set_payload` alone.
    """

    output: int
    grip_seconds: float
    silence: float
    blend: float = 0.0
    servo: Servo | None = None
    sends_inertia: bool = True


def program_of(cell: Cell, plan: Plan, approval: Approval, settings: ProgramSettings) -> UrProgram:
    """The program of a plan.

    Args:
        cell: with one arm of six joints.
        plan: made for it.
        approval: names the program.
        settings: of the gripper, the corners and the controller.

    Raises:
        InputError: a joint of the plan is beyond the cell's limits, or there are too many legs.
    """
    arm, blend, servo = cell.arms[0], settings.blend, settings.servo
    lower, upper, velocity = cell.robot.limits(arm.joints)
    # 0 is what a register holds that nobody has written.
    ticket = (int(approval.digest[:6], 16) + 1) * TICKETS
    lines = [
        "def workbench_plan():",
        *_begun_once(ticket),
        f"  write_output_integer_register({PROGRESS}, {ticket})",
        f'  rtde_set_watchdog("input_int_register_{ALIVE}", {1 / settings.silence:.3f}, "stop")',
    ]
    tcp = current_tcp(by_taking(cell, plan.arm(arm.name)).arm(arm.name).tool)
    output = settings.output if tcp.output is None else tcp.output
    flange = Flange(cell, arm) if blend and cell.zone else None
    if flange is not None:
        lines.append(f"  set_tcp({FLANGE})")
    legs: list[Leg] = []
    references: list[Floats] = []
    holding: bool | None = None
    for step in plan.sequence:
        for _, name in step.runs:
            leg = plan.arm(arm.name).leg(name)
            if np.any(leg.q < lower - 1e-6) or np.any(leg.q > upper + 1e-6):
                raise InputError(f"leg {name} goes beyond the limits of arm {arm.name}")
            legs.append(leg)
            lines.append(f"  write_output_integer_register({PROGRESS}, {ticket + len(legs)})")
            if leg.holding is not holding:
                holding = leg.holding
                lines.append(f"  set_standard_digital_out({output}, {holding})")
                lines.append(f"  sleep({settings.grip_seconds:.3f})")
                if (loads := plan.arm(arm.name).loads) is not None:
                    lines.append(_payload(loads.carried(holding), settings.sends_inertia))
            if servo is not None:
                references.append(references_of(cell, plan, arm, leg, servo))
                axes = [arm.to_axes(q).tolist() for q in references[-1]]
                lines += [_write_line(line) for line in stream_of(axes, servo)]
                lines.append(f"  stopj({STANDING:.1f})")
                continue
            points = speeds_of(cell, plan, plan.arm(arm.name), leg)
            moves = _moves(arm, leg, velocity * cell.policy.speed, points)
            if flange is not None and len(moves) > 1:
                start = arm.to_axes(leg.q[0]).tolist()
                acceleration = np.abs(arm.to_axes(arm.acceleration))
                moves = blend_lines(start, moves, flange, acceleration, cell.zone, blend)
            lines += [_write_line(line) for line in moves]
    if len(legs) + 1 >= REFUSED:
        raise InputError(f"{len(legs)} legs are more than one program has; plan fewer parts")
    lines.append(f"  write_output_integer_register({PROGRESS}, {ticket + len(legs) + 1})")
    lines.append("end")
    names = tuple(leg.name for leg in legs)
    ends = legs[0].q[0], legs[-1].q[-1]
    seconds = tuple(leg.seconds / approval.speed_share for leg in legs)
    return UrProgram("\n".join(lines) + "\n", names, ticket, *ends, seconds, tuple(references))


def _payload(load: Load, sends_inertia: bool) -> str:
    """What the arm carries from now on, in the flange's frame."""
    centre = ", ".join(f"{value + 0.0:.6f}" for value in load.centre)
    if not sends_inertia:
        return f"  set_payload({load.mass:.6f}, [{centre}])"
    six = load.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    inertia = ", ".join(f"{value + 0.0:.9f}" for value in six)
    return f"  set_target_payload({load.mass:.6f}, [{centre}], [{inertia}])"


def _begun_once(ticket: int) -> list[str]:
    """A program whose ticket is remembered ends; else its ticket is remembered from now on.

    Registers stay from program to program.  Programs that came twice would move the robot twice, or
    once more from where the first of them was broken off.
    """
    lines: list[str] = []
    for register in BEGUN:
        lines += [
            f"  if read_output_integer_register({register}) == {ticket}:",
            f"    write_output_integer_register({PROGRESS}, {ticket + REFUSED})",
            "    halt",
            "  end",
        ]
    for older, newer in zip(BEGUN[:0:-1], BEGUN[-2::-1], strict=True):
        lines.append(
            f"  write_output_integer_register({older}, read_output_integer_register({newer}))"
        )
    return [*lines, f"  write_output_integer_register({BEGUN[0]}, {ticket})"]


def _moves(arm: Arm, leg: Leg, velocity: Floats, points: PointSpeeds | None) -> tuple[Line, ...]:
    """One `movej` to each waypoint, stopping there.

    All axes of `movej` move in the same time, `v` and `a` are those of the one that goes farthest:
    they are so low that no axis, and none of the `points`, exceeds what the cell allows it.
    """
    moves: list[Line] = []
    for before, after, seconds in zip(leg.q[:-1], leg.q[1:], np.diff(leg.t), strict=True):
        way = np.abs(after - before)
        far = float(way.max())
        if far < SHORTEST_WAY:
            continue
        share = way / far
        moving = share > SHORTEST_WAY
        v = float((velocity[moving] / share[moving]).min())
        a = float((arm.acceleration[moving] / share[moving]).min())
        if points is not None:
            v = min(v, far / max(points.share_along(before, after), SHORTEST_WAY))
        # No faster than the plan was timed: half the speed and a quarter of `a` take twice as long.
        slower = min(seconds_of(far, v, a) / seconds, 1.0)
        axes = tuple(round(float(value), ANGLE_DIGITS) + 0.0 for value in arm.to_axes(after))
        moves.append(Line("movej", (), axes, _below(a * slower**2), _below(v * slower)))
    return tuple(moves)


def _write_line(line: Line) -> str:
    axes = ", ".join(f"{value + 0.0:.{ANGLE_DIGITS}f}" for value in line.q)
    if line.name == "servoj":
        how = f"lookahead_time={line.lookahead:.3f}, gain={line.gain:.0f}"
        return f"  servoj([{axes}], t={line.t:.3f}, {how})"
    speeds = f"a={line.a:.{ANGLE_DIGITS}f}, v={_below(line.v):.{ANGLE_DIGITS}f}"
    return f"  movej([{axes}], {speeds}{f', r={line.r:.4f}' if line.r else ''})"


def _below(value: float) -> float:
    """Rounded down to what is written, and above zero."""
    return max(math.floor(value * 10**ANGLE_DIGITS + 1e-6), 1) / 10**ANGLE_DIGITS
