"""Checks of a calibrated scanner: balls at known distances in scans, and touches of balls."""

from dataclasses import dataclass, field

import numpy as np

from workbench.model.calibration import BallPlate
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, frozen, put
from workbench.model.messages.calibration import PlateText
from workbench.model.messages.verification import VerifyText

LEAST_RADIUS, MOST_RADIUS = 0.002, 0.2
"""[m]"""

SPACING_LIMIT = 0.0003
"""[m] Of a sphere-spacing error, where nobody states another."""

LONGEST = 5.0
"""[m] Of a ball bar."""


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
        elif not 2 * self.radius < lengths[0] <= LONGEST:
            raise InputError(VerifyText.BAR_LENGTH(longest=f"{LONGEST:g}"))
        put(self, lengths=lengths)

    @property
    def centres(self) -> Floats:
        """The centres (2, 3) or (3, 3) [m], the first at 0, the second along x."""
        if len(self.lengths) == 3:
            return BallPlate(self.radius, self.lengths).centres
        return np.array([[0.0, 0.0, 0.0], [self.lengths[0], 0.0, 0.0]])


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
        put(self, balls=frozen(self.balls), q=frozen(self.q))
        put(self, diameters=frozen(self.diameters), forms=frozen(self.forms))
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
        put(self, q=frozen(self.q))
