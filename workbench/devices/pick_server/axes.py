"""An arm's configurations in the words of its controller, and back."""

from dataclasses import dataclass

import numpy as np

from workbench.devices.pick_server.lines import BadLine, Form, read_number
from workbench.model.cell import Cell
from workbench.model.derived.controller_axes import from_controller, to_controller
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.plugins.report_checks import JointBounds, bounds_of

START_TOLERANCE = np.deg2rad(0.5)
"""[rad] A joint may stand this far from where a leg begins or ends."""

NEAR_M = 0.001
"""[m] The same for a sliding joint."""

MILLIMETRE_DIGITS = 3

READ_BACK_WITHIN = 1e-5
"""[rad, m] What is read back of a line differs by less from what was proven: 0.0006 degrees."""


@dataclass(frozen=True, slots=True, eq=False)
class AxisWords:
    """How one arm's axes are written.

    `slides` (n,) in the controller's order; `near` (n,) [rad, m] of each joint of the chain.
    """

    cell: Cell
    form: Form
    slides: tuple[bool, ...]
    near: Floats
    bounds: JointBounds

    def words(self, q: Floats) -> list[str]:
        """A configuration (n,) [rad, m], chain order, as the controller's numbers, exactly.

        Raises:
            InputError: the digits of the form do not hold it.
        """
        words = self.format(q)
        if not np.abs(self._read(words) - q).max() <= READ_BACK_WITHIN:
            raise InputError("a line of these digits cannot hold what was proven")
        return words

    def format(self, q: Floats) -> list[str]:
        """A configuration (n,) [rad, m], chain order, rounded to the digits of the form."""
        return self.format_shown(to_controller(self.cell.arms[0], q))

    def format_shown(self, shown: Floats) -> list[str]:
        """What a controller shows (n,) [rad, m], as words of the form's digits."""
        values = np.round(shown / self._units, 9)
        words = [f"{v:.{d}f}" for v, d in zip(values, self._digits, strict=True)]
        return [word.removeprefix("-") if float(word) == 0 else word for word in words]

    def read(self, words: tuple[str, ...], *, in_motion: bool) -> Floats:
        """The configuration (n,) [rad, m], chain order, that a controller reports.

        Raises:
            ProtocolError: there are too few or too many words, or a joint cannot be there.
        """
        if len(words) != len(self.slides):
            raise BadLine("count")
        return self.bounds.take(self._read(words), in_motion=in_motion)

    def _read(self, words: tuple[str, ...] | list[str]) -> Floats:
        shown = np.array([read_number(word) for word in words]) * self._units
        return from_controller(self.cell.arms[0], shown)

    @property
    def _units(self) -> Floats:
        """[rad, m] of 1, of each axis."""
        turn = np.pi / 180 if self.form.unit == "deg" else 1.0
        return np.where(self.slides, 0.001, turn)

    @property
    def _digits(self) -> list[int]:
        return [MILLIMETRE_DIGITS if slide else self.form.digits for slide in self.slides]

    def far_from(self, q: Floats, there: Floats) -> str:
        """Which joint stands farthest from `there` (n,) [rad, m], and how far; empty: none does."""
        off = np.abs(np.asarray(q) - there)
        joint = int((off / self.near).argmax())
        if off[joint] <= self.near[joint]:
            return ""
        is_slide = self.near[joint] == NEAR_M
        far = off[joint] * 1000 if is_slide else np.rad2deg(off[joint])
        return f"{self.cell.arms[0].joints[joint]} {far:.1f} {'mm' if is_slide else 'degrees'}"


def axis_words(cell: Cell, form: Form) -> AxisWords:
    """How the axes of a cell's arm are written."""
    arm = cell.arms[0]
    kinds = [cell.robot.joint(name).kind for name in arm.joints]
    slides = tuple(kinds[k] == "prismatic" for k in arm.axis_order)
    near = np.array([NEAR_M if kind == "prismatic" else START_TOLERANCE for kind in kinds])
    return AxisWords(cell, form, slides, near, bounds_of(cell, arm))
