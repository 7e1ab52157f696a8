"""Where the scanner hangs, measured: the reference, what was seen of it, and what came of it.

And whether the bin is where the cell has it, which is how a calibration shows that it is old.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.digest import LATER
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, frozen, own, put
from workbench.model.messages.calibration import BinText, PlateText, VerifyText
from workbench.model.messages.message import Message, all_of

Light = Literal["good", "warning", "bad"]
"""A traffic light: green, amber, red."""

LEAST_DIFFERENCE = 0.008
"""Smallest difference of a plate's sides [m], so that each ball can be identified."""

LEAST_RADIUS, MOST_RADIUS = 0.002, 0.2
"""[m]"""

SPACING_LIMIT = 0.0003
"""[m] Of a sphere-spacing error, where nobody states another."""

LONGEST_BAR = 5.0
"""[m] Of a ball bar."""


@dataclass(frozen=True, slots=True, eq=False)
class BallPlate:
    """Three equal balls that stay where they are relative to each other: the reference object.

    `radius` [m]; `sides` (3,) [m] the distances of the centres: of the first ball to the second,
    of the second to the third, of the third to the first.  A ball looks alike from everywhere, and
    its centre is found more exactly than any point on it.
    """

    radius: float = 0.015
    sides: Floats = field(default_factory=lambda: np.array([0.08, 0.1, 0.12]))

    def __post_init__(self) -> None:
        sides = frozen(self.sides)
        if not (LEAST_RADIUS <= self.radius <= MOST_RADIUS and sides.shape == (3,)):
            raise InputError(PlateText.BALLS())
        if not np.all(np.isfinite(sides)) or sides.min() <= 2 * self.radius or sides.max() > 2.0:
            raise InputError(PlateText.DISTANCES())
        if np.diff(np.sort(sides)).min() < LEAST_DIFFERENCE:
            raise InputError(PlateText.TOO_ALIKE(least=LEAST_DIFFERENCE))
        if sides.max() > 0.95 * (sides.sum() - sides.max()):
            raise InputError(PlateText.ON_LINE())
        put(self, sides=sides)

    @property
    def centres(self) -> Floats:
        """The centres (3, 3) [m] in the plate's frame: the first at 0, the second along x."""
        first, second, third = self.sides
        x = (first**2 + third**2 - second**2) / (2 * first)
        return np.array([[0, 0, 0], [first, 0, 0], [x, np.sqrt(third**2 - x**2), 0]])


@dataclass(frozen=True, slots=True, eq=False)
class BallArtefact:
    """Two or three equal balls at known distances: a ball bar, or a plate as `BallPlate`.

    `radius` [m]; `lengths` (1,) or (3,) [m] between the centres: of a plate as `BallPlate.sides`.
    """

    radius: float = 0.015
    lengths: Floats = field(default_factory=lambda: BallPlate().sides)

    def __post_init__(self) -> None:
        lengths = frozen(self.lengths)
        if lengths.shape not in ((1,), (3,)):
            raise InputError(VerifyText.LENGTHS(count=lengths.size))
        if len(lengths) == 3:
            BallPlate(self.radius, lengths)
        elif not LEAST_RADIUS <= self.radius <= MOST_RADIUS:
            raise InputError(PlateText.BALLS())
        elif not 2 * self.radius < lengths[0] <= LONGEST_BAR:
            raise InputError(VerifyText.BAR_LENGTH(longest=f"{LONGEST_BAR:g}"))
        put(self, lengths=lengths)

    @property
    def centres(self) -> Floats:
        """The centres (2, 3) or (3, 3) [m], the first at 0, the second along x."""
        if len(self.lengths) == 3:
            return BallPlate(self.radius, self.lengths).centres
        return np.array([[0.0, 0.0, 0.0], [self.lengths[0], 0.0, 0.0]])


@dataclass(frozen=True, slots=True, eq=False)
class PlateObservation:
    """The plate as one scan shows it; the arm holds the plate, or carries the scanner.

    `q` (n,) [rad] of that arm, chain order; `balls` (3, 3) [m] their centres in the scanner's
    frame, in the plate's order; `spread` [m] how far the points lie from the balls, RMS.  `points`
    (m, 3) [m] are some of the scan, in the scanner's frame, to be checked.  `is_used` False: a
    person has left it out.
    """

    name: str
    arm: str
    q: Floats
    plate: BallPlate
    balls: Floats
    spread: float
    points: Floats
    is_used: bool = True

    def __post_init__(self) -> None:
        own(self, "q", "balls", "points")
        if self.balls.shape != (3, 3) or not np.all(np.isfinite(self.balls)):
            raise InputError(PlateText.CENTRES(name=self.name))
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise InputError(PlateText.POINTS(name=self.name))


@dataclass(frozen=True, slots=True, eq=False)
class PoseResidual:
    """How well one pose fits the calibration: RMS of the balls [m], and the plate's turn [rad].

    `left_out` says why the pose was not used; None when it was.  `predicted` are distance [m] and
    angle [rad] from where the other poses alone predict this one, which its light goes by; None
    where they leave it open.
    """

    name: str
    distance: float
    angle: float
    light: Light
    left_out: Message | None = None
    predicted: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationRecord:
    """What a cell remembers of its calibration.

    `at` in whole seconds since the epoch, `by` the person who took it over, the number of `poses`
    used, `rms` [m] of the balls; `position_error` [m], `angle_error` [rad] and
    `covariance` (6, 6) are those of `Calibration`, None where nobody has kept them; that of a
    scanner on an arm is along the axes of the flange (`derived.scanner_poses`).
    """

    at: float
    by: str
    poses: int
    rms: float
    position_error: float | None = field(default=None, metadata=LATER)
    angle_error: float | None = field(default=None, metadata=LATER)
    covariance: Floats | None = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "covariance")


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """The scanner's pose in the world, and what speaks for it.

    `T_flange_plate` is how the plate was held.  `rms` [m] over the balls of the poses used.
    `covariance` (6, 6) [m, rad] is of shifts of the scanner's origin, then of turns about it, along
    the world's axes, as `Detection` has it.  Of a scanner on an arm, all three are so while the arm
    stands at the view; the plate stands.
    """

    T_world_scanner: pin.SE3
    T_flange_plate: pin.SE3
    residuals: tuple[PoseResidual, ...]
    rms: float
    covariance: Floats

    def __post_init__(self) -> None:
        own(self, "covariance", "T_world_scanner", "T_flange_plate")

    @property
    def used(self) -> int:
        """How many poses were used."""
        return sum(not residual.left_out for residual in self.residuals)

    @property
    def position_error(self) -> float:
        """Standard error [m] of the scanner's position, in the direction that is known least."""
        return float(np.sqrt(max(np.linalg.eigvalsh(self.covariance[:3, :3])[-1], 0.0)))

    @property
    def angle_error(self) -> float:
        """Standard error [rad] of its direction, about the axis that is known least."""
        return float(np.sqrt(max(np.linalg.eigvalsh(self.covariance[3:, 3:])[-1], 0.0)))

    @property
    def predicted_rms(self) -> tuple[float, float] | None:
        """RMS [m, rad] of what the others predict of each pose used; None where one is open."""
        used = [residual.predicted for residual in self.residuals if not residual.left_out]
        if not used or any(predicted is None for predicted in used):
            return None
        distance, angle = np.sqrt(np.mean(np.array(used) ** 2, axis=0))
        return float(distance), float(angle)

    @property
    def worst_predicted(self) -> PoseResidual | None:
        """The pose used that the others predict worst; None where they leave all open."""
        used = [
            residual
            for residual in self.residuals
            if not residual.left_out and residual.predicted is not None
        ]
        return max(
            used, key=lambda pose_residual: pose_residual.predicted or (0.0, 0.0), default=None
        )

    def record(self, at: float, by: str) -> CalibrationRecord:
        """What the cell remembers of it, taken over by a person `at` [s since the epoch]."""
        errors = (self.position_error, self.angle_error, self.covariance)
        return CalibrationRecord(float(round(at)), by, self.used, self.rms, *errors)


@dataclass(frozen=True, slots=True, eq=False)
class BallScan:
    """The balls of an artefact that lies before the scanner, as one scan shows them.

    `balls` (k, 3) [m] are their centres in the scanner's frame, in the artefact's order;
    `diameters` (k,) [m] are fitted without knowing them; `forms` (k,) [m] are the widths of the
    radial band with 95 % of a ball's points.  `q` (n,) [rad] is where the arm with the scanner
    stood, empty where the scanner stands; `seed` that of a simulated scan.
    """

    name: str
    artefact: BallArtefact
    balls: Floats
    diameters: Floats
    forms: Floats
    q: Floats = field(default_factory=lambda: np.empty(0))
    seed: int = 0

    def __post_init__(self) -> None:
        own(self, "balls", "q", "diameters", "forms")
        count = len(self.artefact.centres)
        if self.balls.shape != (count, 3) or not np.all(np.isfinite(self.balls)):
            raise InputError(VerifyText.CENTRES(scan=self.name, count=count))

    @property
    def measured(self) -> Floats:
        """The distances of the centres [m], in the order of the artefact's lengths."""
        apart = np.linalg.norm(self.balls - np.roll(self.balls, -1, axis=0), axis=1)
        return apart[: len(self.artefact.lengths)]


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """An arm's tool tip on a ball of the scan of that name.

    `q` (n,) [rad] of the arm, chain order.  `seat` [m] is the inner diameter of a hollow tip, which
    centres itself on the ball; 0 is a point on the ball, with the tool's axis through its centre.
    """

    name: str
    scan: str
    arm: str
    q: Floats
    seat: float = 0.0

    def __post_init__(self) -> None:
        own(self, "q")


@dataclass(frozen=True, slots=True, eq=False)
class NextPose:
    """A pose that the arm reaches and the scanner sees: `q` (n,) [rad], chain order.

    `error` [m] is the largest error at the bin's corners now, `error_with` what it would be with
    this pose; `steps` say how plate or scanner gets there from the pose `after`.
    """

    q: Floats
    error: float
    error_with: float
    after: str
    steps: tuple[Message, ...]

    def __post_init__(self) -> None:
        own(self, "q")


@dataclass(frozen=True, slots=True, eq=False)
class BinCheck:
    """The bin as a scan shows it.

    `T_world_bin` is where its rim, or its floor where it `has_walls` not, is seen, None when it is
    not; `shift` [m] and `turn` [rad] by how
    much that differs from the cell.  `fill` 0..1 is the share of its room that is taken as seen
    from above, None when the inside is not seen; `above` [m] how far something sticks out of it,
    which may be one part that stands.
    `findings` say in words what is not as it should be, the worst first.
    """

    T_world_bin: pin.SE3 | None
    shift: float
    turn: float
    fill: float | None
    above: float
    light: Light
    findings: tuple[Message, ...]
    is_elsewhere: bool = False
    is_empty: bool = False
    has_walls: bool = True

    def __post_init__(self) -> None:
        own(self, "T_world_bin")

    @property
    def says(self) -> Message:
        """All of it in one sentence."""
        said = all_of(self.findings)
        if said is None:
            said = (BinText.IN_PLACE if self.has_walls else BinText.AT_HEIGHT)(off=self.shift)
        if self.fill is None or self.is_empty:
            return said
        return BinText.FULL(bin=said, fill=self.fill)
