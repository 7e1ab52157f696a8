"""Poses as the pendants of robot makers show them: read, and written.

The order of rotations of each maker: rc_visard manual, appendix "Pose formats" (Roboception); of
Staubli: RoboDK's documentation of `Pose`.  Denso's is that of the RC8 user manual's figure of
RX, RY and RZ; nobody has compared it with a pendant.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.errors import InputError
from workbench.model.geometry import Floats

POLE_WITHIN = 1e-9
"""[rad] Two turns about one axis nearer than this to a pole are reported as one."""

UNIT = 0.01
"""By how much the length of a typed quaternion may differ from 1: pendants show few digits."""

Turn = Callable[[Floats], Floats]


@dataclass(frozen=True, slots=True)
class PoseConvention:
    """How a maker writes an orientation.

    `labels` name the numbers behind X, Y and Z [mm]; `matrix` makes of these numbers, as shown, a
    rotation (3, 3), `numbers` the other way.
    """

    maker: str
    labels: tuple[str, ...]
    matrix: Turn
    numbers: Turn

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all numbers with their units, in the order of the pendant."""
        return tuple(f"{name} [mm]" for name in "XYZ") + self.labels

    def pose(self, numbers: Sequence[float]) -> pin.SE3:
        """The pose of numbers as the pendant shows them.

        Raises:
            InputError: there are too few or too many, one is no number, or a quaternion is none.
        """
        if len(numbers) != len(self.names) or not np.all(np.isfinite(numbers)):
            raise InputError(
                f"a pose as {self.maker} shows it has the {len(self.names)} numbers "
                f"{', '.join(self.names)}, not {list(numbers)}"
            )
        values = np.asarray(numbers, np.float64)
        return pin.SE3(self.matrix(values[3:]), values[:3] / 1000)

    def show(self, T: pin.SE3) -> tuple[float, ...]:
        """The numbers of a pose, as the pendant shows them."""
        return tuple(float(x) for x in (*(T.translation * 1000), *self.numbers(T.rotation)))


def _about(axis: str, degrees: float) -> Floats:
    return pin.exp3(np.deg2rad(degrees) * np.eye(3)["xyz".index(axis)])


def _zyx_matrix(degrees: Floats) -> Floats:
    """Turns about the fixed axes x, y and z, in this order."""
    x, y, z = degrees
    return _about("z", z) @ _about("y", y) @ _about("x", x)


def _zyx_degrees(R: Floats) -> Floats:
    """Where y is 90 degrees, x and z are one turn: all of it is reported as z."""
    y = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) < POLE_WITHIN:
        return np.rad2deg([0.0, y, np.arctan2(-R[0, 1], R[1, 1])])
    return np.rad2deg([np.arctan2(R[2, 1], R[2, 2]), y, np.arctan2(R[1, 0], R[0, 0])])


def _xyz_matrix(degrees: Floats) -> Floats:
    """Turns about the turned axes x, y and z, in this order."""
    x, y, z = degrees
    return _about("x", x) @ _about("y", y) @ _about("z", z)


def _xyz_degrees(R: Floats) -> Floats:
    # The other way round, the turns are those about fixed axes.
    return -_zyx_degrees(R.T)


def _zyz_matrix(degrees: Floats) -> Floats:
    """Turns about the turned axes z, y and z, in this order."""
    first, y, last = degrees
    return _about("z", first) @ _about("y", y) @ _about("z", last)


def _zyz_degrees(R: Floats) -> Floats:
    """Where y is 0 or 180 degrees both other turns are one: all of it is reported as the first."""
    across = np.hypot(R[0, 2], R[1, 2])
    y = np.arctan2(across, R[2, 2])
    if across < POLE_WITHIN:
        return np.rad2deg([np.arctan2(-R[0, 1], R[1, 1]), y, 0.0])
    return np.rad2deg([np.arctan2(R[1, 2], R[0, 2]), y, np.arctan2(R[2, 1], -R[2, 0])])


def _quaternion_matrix(wxyz: Floats) -> Floats:
    length = float(np.linalg.norm(wxyz))
    if abs(length - 1) > UNIT:
        raise InputError(
            f"the quaternion {', '.join(f'{q:g}' for q in wxyz)} has the length {length:.3f}; "
            "that of an orientation has 1"
        )
    w, x, y, z = wxyz / length
    return pin.Quaternion(w, x, y, z).matrix()


def _quaternion(R: Floats) -> Floats:
    x, y, z, w = pin.Quaternion(R).normalized().coeffs()
    return np.array([w, x, y, z]) * (1.0 if w >= 0 else -1.0)


def _reverse(turn: Turn, *, first: bool) -> Turn:
    """With the numbers the other way round, as they come or as they go."""
    return (lambda given: turn(given[::-1])) if first else (lambda given: turn(given)[::-1])


def _euler(maker: str, names: str, matrix: Turn, numbers: Turn) -> PoseConvention:
    return PoseConvention(maker, tuple(f"{n} [deg]" for n in names.split()), matrix, numbers)


CONVENTIONS: Mapping[str, PoseConvention] = {
    "abb": PoseConvention("ABB", ("q1", "q2", "q3", "q4"), _quaternion_matrix, _quaternion),
    "denso": _euler("Denso", "RX RY RZ", _zyx_matrix, _zyx_degrees),
    "fanuc": _euler("FANUC", "W P R", _zyx_matrix, _zyx_degrees),
    "kawasaki": _euler("Kawasaki", "O A T", _zyz_matrix, _zyz_degrees),
    "kuka": _euler(
        "KUKA",
        "A B C",
        _reverse(_zyx_matrix, first=True),
        _reverse(_zyx_degrees, first=False),
    ),
    "mitsubishi": _euler("Mitsubishi", "A B C", _zyx_matrix, _zyx_degrees),
    "staubli": _euler("Staubli", "Rx Ry Rz", _xyz_matrix, _xyz_degrees),
    "ur": PoseConvention(
        "Universal Robots",
        ("RX [rad]", "RY [rad]", "RZ [rad]"),
        lambda turn: pin.exp3(np.asarray(turn, np.float64)),
        lambda R: pin.log3(np.asarray(R)),
    ),
    "yaskawa": _euler("Yaskawa", "Rx Ry Rz", _zyx_matrix, _zyx_degrees),
}
"""By the names under which a convention is asked for."""


def convention(name: str) -> PoseConvention:
    """A convention by its name.

    Raises:
        InputError: there is none of that name; the message has those that there are.
    """
    try:
        return CONVENTIONS[name]
    except KeyError:
        raise InputError(
            f"the pose format {name!r:.60} is not one of {', '.join(CONVENTIONS)}"
        ) from None
