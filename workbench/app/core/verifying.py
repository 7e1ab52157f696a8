"""Checks of the calibrated scanner: balls scanned where parts lie, and touched by an arm's tool."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.arm_scanner import standing_joints, view_problem
from workbench.app.core.people import Role
from workbench.app.core.state import State
from workbench.app.core.tasks import begin_task
from workbench.app.core.value_checks import (
    MOST_CHECKS,
    SEED_LIMIT,
    check_configuration,
    check_integer,
    check_number,
    check_text,
)
from workbench.model.calibration import BallArtefact, BallScan, Touch
from workbench.model.derived.touches import touch_problem, touched_ball
from workbench.model.errors import CommandRefused
from workbench.model.geometry import Floats, frozen, put
from workbench.model.messages.calibration import VerifyText
from workbench.model.messages.commands import CommandText

LEAST_LIMIT, MOST_LIMIT = 1e-5, 0.1
"""[m]"""

SAME_TOUCH_WITHIN = 1e-4
"""[rad, m] Joints nearer to each other than this are those of one touch."""


@dataclass(frozen=True, slots=True, eq=False)
class ScanBalls(Command):
    """Scan an artefact of balls that lies where parts lie; `seed` is that of a simulated scan."""

    right: ClassVar[Right] = Right(CommandText.SCAN_BALLS, SAFE, role=Role.ENGINEER)

    artefact: BallArtefact
    seed: int = 0

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        refuse(view_problem(state.cell, standing_joints(state.cell, asked.joints)))
        _check_room(len(state.ball_scans))

    def apply(self, state: State, entry: Entry) -> Decision:
        arguments = {
            "name": _next_name("scan", state.ball_scans),
            "artefact": self.artefact,
            "seed": self.seed,
            "joints": standing_joints(state.cell, entry.joints),
        }
        return begin_task(state, entry, "balls", arguments, VerifyText.SCANNING())


@dataclass(frozen=True, slots=True, eq=False)
class RecordTouch(Command):
    """Record that an arm's tool touches a ball of a scan at `q` (n,) [rad], chain order.

    Nothing moves: a person has brought the tool there.  `seat` [m] is as `Touch` has it.
    """

    right: ClassVar[Right] = Right(CommandText.RECORD_TOUCH, SAFE, role=Role.ENGINEER)

    scan: str
    arm: str
    q: Floats
    seat: float = 0.0

    def __post_init__(self) -> None:
        put(self, q=frozen(self.q))

    def check(self, state: State, asked: Asked) -> None:
        check_text("scan", self.scan)
        check_configuration(state.cell, self.arm, self.q)
        _check_room(len(state.touches))
        touch = self._touch(state)
        refuse(touch_problem(state.cell, _scan_named(state, self.scan), touch))
        for other in state.touches:
            is_alike = other.arm == touch.arm and other.q.shape == touch.q.shape
            if is_alike and np.abs(other.q - touch.q).max() < SAME_TOUCH_WITHIN:
                raise CommandRefused(VerifyText.SAME_TOUCH(touch=other.name))

    def apply(self, state: State, entry: Entry) -> Decision:
        touch = self._touch(state)
        touched = touched_ball(state.cell, _scan_named(state, self.scan), touch)
        says = VerifyText.TOUCHED(
            touch=touch.name,
            ball=touched.ball,
            scan=touch.scan,
            away=float(np.linalg.norm(touched.offset)),
        )
        return replace(state, touches=(*state.touches, touch), message=says), ()

    def _touch(self, state: State) -> Touch:
        name = _next_name("touch", state.touches)
        return Touch(name, self.scan, self.arm, self.q, self.seat)


@dataclass(frozen=True, slots=True, eq=False)
class RemoveCheck(Command):
    """Remove the touch of that name, or the scan of balls with all of its touches."""

    right: ClassVar[Right] = Right(CommandText.REMOVE_CHECK, SAFE, role=Role.ENGINEER)

    name: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("name", self.name)
        if all(self.name != known.name for known in (*state.ball_scans, *state.touches)):
            raise CommandRefused(VerifyText.NO_SUCH(name=repr(self.name)))

    def apply(self, state: State, entry: Entry) -> Decision:
        scans = tuple(scan for scan in state.ball_scans if scan.name != self.name)
        touches = tuple(
            touch for touch in state.touches if self.name not in (touch.name, touch.scan)
        )
        says = VerifyText.REMOVED(name=self.name)
        return replace(state, ball_scans=scans, touches=touches, message=says), ()


@dataclass(frozen=True, slots=True, eq=False)
class LimitChecks(Command):
    """State up to which error [m] scanner and robot are good: of spacings, and of touches.

    `touches` 0: as the calibration predicts.
    """

    right: ClassVar[Right] = Right(CommandText.LIMIT_CHECKS, SAFE, role=Role.ENGINEER)

    spacings: float
    touches: float = 0.0

    def check(self, state: State, asked: Asked) -> None:
        check_number("spacings", self.spacings, LEAST_LIMIT, MOST_LIMIT, "m")
        check_number("touches", self.touches, 0, MOST_LIMIT, "m")

    def apply(self, state: State, entry: Entry) -> Decision:
        return replace(state, check_limits=(self.spacings, self.touches)), ()


def _check_room(count: int) -> None:
    if count >= MOST_CHECKS:
        raise CommandRefused(VerifyText.MOST_SCANS(most=MOST_CHECKS))


def _scan_named(state: State, name: str) -> BallScan:
    for scan in state.ball_scans:
        if scan.name == name:
            return scan
    raise CommandRefused(VerifyText.NO_SUCH_SCAN(scan=repr(name)))


def _next_name(kind: str, known: tuple[BallScan | Touch, ...]) -> str:
    """The name of the next one: `scan 3` after `scan 2`, even if that alone is left."""
    numbers = [int(each.name.rpartition(" ")[2]) for each in known]
    return f"{kind} {max(numbers, default=0) + 1}"
