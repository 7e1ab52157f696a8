"""A joint of an assembly: what it tolerates, and how far a part that was placed may be off."""

from dataclasses import dataclass, field

from workbench.model.digest import LATER
from workbench.model.geometry import Floats, own


@dataclass(frozen=True, slots=True)
class Joint:
    """A round joint of two parts: what it tolerates of their poses.

    `mouth` (3,) [m] is the middle of its mouth in the base's frame, where the part's leading end
    meets it; from there that goes on along the insertion by `depth` [m].  What fits is
    `part_length` [m] long from the leading end of the part, and `base_length` [m] from the mouth.
    `clearance` [m] is radial, half the difference of both diameters; `chamfer` [m] the radial width
    of the chamfers of peg and hole together.  `compliance` [m] is the part's
    sideways compliance in the hand.  Plans warn if less than the `share` (0..1) of picks will mate.
    """

    mouth: tuple[float, float, float]
    depth: float
    part_length: float
    base_length: float
    clearance: float
    chamfer: float = 0.0
    compliance: float = 0.0
    share: float = 0.95

    @property
    def takes(self) -> float:
        """The largest offset [m] of the axes as the parts meet: what the chamfer catches, too."""
        return self.clearance + min(self.chamfer, self.compliance)


@dataclass(frozen=True, slots=True, eq=False)
class PlacingError:
    """How far a part that was placed may be off, as shifts of its origin, then turns about it.

    Both are along the part's axes.  `by_scanner` (6, 6) [m, rad] is what a shift and a turn of the
    scanner bring about, which parts by one calibration share; `covariance` (6, 6) [m, rad] is that
    of all else.  `believed` is the error of a part before a scan has shown it again, if one has.
    """

    by_scanner: Floats
    covariance: Floats
    believed: "PlacingError | None" = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "by_scanner", "covariance")
