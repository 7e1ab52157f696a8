"""What a controller reports of a program by `abb-socket/2`, checked against the plan."""

import re
from collections.abc import Mapping

from workbench.devices.abb_socket.frames import MessageFrame
from workbench.devices.abb_socket.messages import angles_of
from workbench.devices.abb_socket.program import SocketProgram
from workbench.devices.abb_socket.states import PHASES
from workbench.model.cell import Cell
from workbench.model.errors import ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.plan import Plan
from workbench.model.release import PartReport
from workbench.plugins.report_checks import bounds_of

BEFORE = ("greeted", "ready", "loading", "loaded")
"""Phases before the program runs; nothing moves in them."""

POINT = re.compile(r"([A-Z])([0-9]{2})")


class ProgramReports:
    """Where the robot is in a program, as far as it has reported.

    Lifetime: one connection.  `step` is the one that it reported last, `may` the last one that may
    run.
    """

    def __init__(self, cell: Cell, plan: Plan, program: SocketProgram) -> None:
        self._cell, self._plan, self._program = cell, plan, program
        self._letters = {arm.controller_id: arm for arm in cell.arms}
        self._bounds = {arm.name: bounds_of(cell, arm) for arm in cell.arms}
        self.step = 0
        self.may = 0 if program.is_stepped else len(program.steps)
        self._parts: dict[str, PartReport] = {}

    def state(self, frame: MessageFrame) -> tuple[str, int, dict[str, int]]:
        """Phase, step, and the waypoint of each arm in it.

        Raises:
            ProtocolError: the report is none.
        """
        phase, number, *arms = (*frame.words, "", "")
        found = [POINT.fullmatch(word) for word in arms if word]
        if not re.fullmatch(r"[0-9]{2}", number) or not all(found):
            raise ProtocolError(f"{frame.text!r} is no report of a state")
        if phase not in PHASES:
            raise ProtocolError(f"{frame.text!r}: {phase!r} is no state")
        arms_at = [match.groups() for match in found if match]
        if sorted(letter for letter, _ in arms_at) != sorted(self._letters):
            raise ProtocolError(f"{frame.text!r} does not tell of every arm")
        points = {self._letters[letter].name: int(point) for letter, point in arms_at}
        return phase, int(number), points

    def check_before(
        self, frame: MessageFrame, phase: str, step: int, points: Mapping[str, int]
    ) -> None:
        """Check that the robot does not move before we send `run`.

        Raises:
            ProtocolError: it does.
        """
        if phase not in BEFORE or step or any(points.values()):
            raise ProtocolError(f"the controller says {frame.text!r} before we sent run")

    def check_motion(self, step: int, points: Mapping[str, int]) -> None:
        """Check that steps come in their order, and that arms and waypoints are those of the plan.

        Raises:
            ProtocolError: it is not.
        """
        steps = self._program.steps
        if not self.step <= step <= len(steps):
            raise ProtocolError(f"the controller is in step {step} after step {self.step}")
        if step > self.may:
            raise ProtocolError(f"the controller runs step {step}, which nobody has let run")
        self.step = step
        waypoints = {leg.arm: len(leg.seconds) for leg in steps[step - 1].legs} if step else {}
        for arm, point in points.items():
            if not 0 <= point <= waypoints.get(arm, 0):
                only = " and ".join(waypoints) or "none"
                raise ProtocolError(
                    f"arm {arm} goes to waypoint {point} in step {step}; the plan moves {only}"
                )

    def check_wait(self, frame: MessageFrame, step: int, points: Mapping[str, int]) -> None:
        """Check that the robot stands, before the step after the last one that may run.

        Raises:
            ProtocolError: it does not.
        """
        if step != self.may + 1 or step > len(self._program.steps) or any(points.values()):
            raise ProtocolError(
                f"the controller says {frame.text!r}, after step {self.may} of "
                f"{len(self._program.steps)} may run"
            )

    def joints(self, frame: MessageFrame) -> tuple[str, Floats]:
        """An arm, and where it is (n,) [rad], chain order.

        Raises:
            ProtocolError: it is none of the cell's, or cannot be there.
        """
        letter, *words = frame.words or [""]
        arm = self._letters.get(letter)
        if arm is None:
            raise ProtocolError(f"{frame.text!r} is about no arm of cell {self._cell.name}")
        return arm.name, self._bounds[arm.name].take(angles_of(arm, words))

    def is_dropped(self, frame: MessageFrame) -> bool:
        """Whether a hand reports what it held before its plan, which only drops that back."""
        letters = [self._cell.arm(arm.arm).controller_id for arm in self._plan.arms if arm.held]
        return frame.words[:1] == letters

    def part(self, frame: MessageFrame) -> PartReport:
        """What became of a part.

        Raises:
            ProtocolError: it is none of the plan, or comes twice.
        """
        letter, _, said = frame.rest.partition(" ")
        result, _, why = said.partition(" ")
        for arm in self._plan.picks:
            is_it = self._cell.arm(arm.arm).controller_id == letter
            if is_it and arm.arm not in self._parts and result in ("picked", "failed", "missed"):
                report = PartReport(
                    arm.arm, arm.detection, result == "picked", why, result == "missed"
                )
                self._parts[arm.arm] = report
                return report
        raise ProtocolError(f"{frame.text!r} is about no part of the plan, or comes twice")

    def check_done(self, frame: MessageFrame, where: Message) -> None:
        """Check that all steps were allowed to run, and that all parts were reported.

        Raises:
            ProtocolError: they were not.
        """
        steps, is_complete = len(self._program.steps), len(self._parts) == len(self._plan.picks)
        if self.may < steps or frame.words != [f"{steps:02d}"] or not is_complete:
            raise ProtocolError(
                f"the controller said {frame.text!r} at {where}, with {len(self._parts)} of "
                f"{len(self._plan.picks)} parts reported"
            )
