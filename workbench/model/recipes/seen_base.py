"""What a scan shows of a part of an assembly, onto which another one comes."""

import enum
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.errors import InputError
from workbench.model.geometry import Floats, own, put
from workbench.model.messages.cells import SeenBaseText
from workbench.model.messages.message import Message

MOST_SHIFT, MOST_TURN = 0.010, float(np.deg2rad(5.0))
"""[m, rad] A part that stands farther from where it is believed is not taken for the same."""

MOST_RISE = 0.002
"""[m] The same straight up or down: a part slides on what it stands on, and does not rise from it.
Dirt beneath it, or a nest that it has not sunk into, leaves more."""


class SightProblem(enum.StrEnum):
    """Why a scan does not state where a part stands."""

    NO_SCAN = "no-scan"
    NOT_IN_VIEW = "not-in-view"
    GONE = "gone"
    TOO_LITTLE = "too-little"
    OTHER = "other"
    TOO_FAR = "too-far"
    OFF_HEIGHT = "off-height"
    MOVED = "moved"


@dataclass(frozen=True, slots=True, eq=False)
class SeenBase:
    """Where a scan shows a part that stands in an assembly; or why it does not.

    `scan` is the digest of the scan, empty where there is none.  `T_world_part` and `covariance`
    (6, 6) [m, rad] are as those of a `Detection`, None with a `problem`.  The part stands off the
    believed pose by `shift` [m], its middle, and by `turn` [rad].  `visible` 0..1 is the share of
    the surface facing the scanner that is seen.
    """

    scan: str
    T_world_part: pin.SE3 | None = None
    covariance: Floats | None = None
    shift: float = 0.0
    turn: float = 0.0
    visible: float = 0.0
    problem: SightProblem | None = field(default=None)

    def __post_init__(self) -> None:
        is_whole = self.T_world_part is not None and self.covariance is not None
        if is_whole == (self.problem is not None) or (is_whole and not self.scan):
            raise InputError(SeenBaseText.EITHER())
        if self.covariance is not None and np.shape(self.covariance) != (6, 6):
            raise InputError(SeenBaseText.COVARIANCE())
        own(self, "T_world_part", "covariance")
        put(self, shift=float(self.shift), turn=float(self.turn), visible=float(self.visible))

    def message(self, base: str) -> Message:
        """Where a part of that name was seen, or why it was not, in one sentence."""
        if self.problem is None:
            return SeenBaseText.SEEN(base=base, shift=self.shift, turn=self.turn)
        text = SeenBaseText[self.problem.name]
        match self.problem:
            case SightProblem.TOO_LITTLE:
                return text(base=base, visible=self.visible)
            case SightProblem.TOO_FAR:
                limits = {"most": MOST_SHIFT, "most_turn": MOST_TURN}
                return text(base=base, shift=self.shift, turn=self.turn, **limits)
            case SightProblem.OFF_HEIGHT:
                return text(base=base, shift=self.shift, most=MOST_RISE)
            case _:
                return text(base=base)
