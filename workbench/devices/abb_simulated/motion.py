"""How the simulated controller runs a program: step by step, the arms apart or together."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from workbench.devices.abb_simulated.body import SimulatedBody
from workbench.devices.abb_simulated.faults import STOPS
from workbench.devices.abb_socket.program import ProgramLeg, ProgramStep, SocketProgram
from workbench.model.errors import LinkError
from workbench.model.geometry import Floats

MOMENT = 0.004
"""[s] Of the robot's time, between two states."""

HAND_SECONDS = 0.2
"""How long hands take to open or close; the arms stand meanwhile."""


def _configuration_at(leg: ProgramLeg, t: float) -> tuple[Floats, int]:
    """Where an arm is, (n,) [rad], `t` [s] after a leg began, and the waypoint it is going to.

    All joints go linearly from waypoint to waypoint; around each within the zone they follow a
    parabola that touches both lines.
    """
    path, times = np.asarray(leg.q), np.concatenate([[0.0], np.cumsum(leg.seconds)])
    last = len(path) - 1
    if t >= times[-1]:
        return path[-1], last
    k = min(int(np.searchsorted(times, t, side="right")) - 1, last - 1)
    share = (t - times[k]) / (times[k + 1] - times[k])
    corner = k + 1 if share > 0.5 else k
    off = share - (corner - k)
    zone = leg.zone
    if 0 < corner < last and abs(off) < zone:
        before, after = path[corner] - path[corner - 1], path[corner + 1] - path[corner]
        bend = (off + zone) ** 2 / (4 * zone) * (after - before)
        return path[corner] + off * before + bend, k + 1
    return path[k] + share * (path[k + 1] - path[k]), k + 1


class Motion:
    """One program on its way through.

    Lifetime: from `run` until it is done or dropped.  Concurrency: one thread.
    """

    def __init__(
        self, program: SocketProgram, body: SimulatedBody, paces: Mapping[str, float]
    ) -> None:
        """Begin with the first step.

        Args:
            program: the program to run.
            body: the body that moves.
            paces: speed of each arm relative to the command; 1 for arms not named.

        `waits` is the step of a stepped program that it stands before, 0 while none waits.
        """
        self._program, self._body, self._paces = program, body, paces
        self._letters = {arm.name: arm.controller_id for arm in body.cell.arms}
        self._time = self._due = self._began = 0.0
        self._step = self._let = 0
        self._wrong = ""
        self.waits = 0
        self._points = dict.fromkeys(self._letters, 0)

    @property
    def report(self) -> str:
        """Step and waypoints, as they are reported; the step before which it waits, if it does."""
        if self.waits:
            return f"{self.waits:02d} " + " ".join(
                f"{letter}00" for letter in self._letters.values()
            )
        points = " ".join(f"{self._letters[arm]}{k:02d}" for arm, k in self._points.items())
        return f"{self._step:02d} {points}"

    def let(self) -> None:
        """Run the step that it waits before."""
        self._let, self.waits = self.waits, 0

    def advance(self, seconds: float) -> Iterator[str]:
        """Go on for this many seconds of the robot's time; what there is to tell.

        Raises:
            LinkError: a fault that stops the robot.
        """
        # Moments seldom end when a call does; what is over counts for the next one.
        self._due += seconds
        steps = self._program.steps
        states: list[dict[str, Any]] = []
        while self._time <= self._due:
            if self._step == 0 or self._has_ended(steps[self._step - 1]):
                self._body.trace(states)
                states = []
                if self._step == len(steps):
                    self._body.put({}, "")
                    yield f"done {self._step:02d}"
                    return
                if self._program.is_stepped and self._let == self._step:
                    # While it waits its clock stands.
                    self._due = self._time
                    if not self.waits:
                        self.waits = self._step + 1
                        self._body.put({}, "")
                        yield "wait"
                    return
                yield from self._begin()
            self._time += MOMENT
            self._move(steps[self._step - 1])
            if self._body.is_traced:
                states.append(self._state())
        self._body.trace(states)

    def _begin(self) -> Iterator[str]:
        self._step += 1
        self._began = self._time
        faults, step = self._body.faults, self._program.steps[self._step - 1]
        for name, fault in STOPS.items():
            if faults.is_due(name, self._step):
                raise LinkError(fault)
        self._points = dict.fromkeys(self._letters, 0)
        for leg in step.legs:
            if leg.hand == "grip":
                self._body.grip(leg.arm, leg.opening)
            elif leg.hand == "uncouple":
                self._body.uncouple(leg.arm)
            elif leg.hand == "couple":
                self._body.couple(leg.arm, leg.opening)
            elif leg.hand == "open" and (result := self._body.open(leg.arm, leg.opening)):
                yield f"part {self._letters[leg.arm]} {result}"
        if any(leg.hand != "keep" for leg in step.legs):
            self._began += HAND_SECONDS
        others = [arm for arm in self._letters if arm != step.legs[0].arm]
        is_alone = len(step.legs) == 1 and len(others) > 0
        self._wrong = others[0] if is_alone and faults.is_due("wrong-arm", self._step) else ""

    def _elapsed_time(self, step: ProgramStep, leg: ProgramLeg) -> float:
        """How long [s] a leg has run on the arm's own clock."""
        arms = [program_leg.arm for program_leg in step.legs] if step.mode == "sync" else [leg.arm]
        pace = min(self._paces.get(arm, 1.0) for arm in arms)
        return max(0.0, self._time - self._began) * pace

    def _has_ended(self, step: ProgramStep) -> bool:
        """All arms wait for each other at the end of a step."""
        return all(self._elapsed_time(step, leg) >= float(leg.seconds.sum()) for leg in step.legs)

    def _move(self, step: ProgramStep) -> None:
        where: dict[str, Floats] = {}
        for leg in step.legs:
            q, point = _configuration_at(leg, self._elapsed_time(step, leg))
            arm = self._wrong or leg.arm
            if self._time > self._began:
                self._points[arm] = point
            if self._wrong:
                q = self._program.starts[arm] + 0.01 * point
            where[arm] = q
        self._body.put(where, " and ".join(where))

    def _state(self) -> dict[str, Any]:
        q = {
            arm: np.asarray(positions).tolist() for arm, positions in self._body.standing().items()
        }
        return {
            "time": round(self._time, 6),
            "step": self._step,
            "q": q,
            "openings": self._body.openings(),
        }
