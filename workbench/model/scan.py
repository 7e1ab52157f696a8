"""What the scanner saw, and the parts found in it."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.digest import LATER, FactsRepr, digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, frozen, own, put, transform
from workbench.model.messages.calibration import ObjectionText, ScaleText, ScanText
from workbench.model.messages.message import FoundPart, Message
from workbench.model.recipes.joint import PlacingError
from workbench.model.recipes.seen_base import SeenBase
from workbench.model.robot import ScannedView

ALL_KINDS = "all"
"""Instead of a part's name: every kind that the cell picks, one of each in turn."""


Option = bool | int | float | str
"""A value of a key that a plug-in has of its own."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Scan(FactsRepr):
    """A point cloud in the scanner's frame.

    `points` (n, 3) [m] are finite.  In an organised cloud, `pixels` (n,) holds the index
    row * columns + column of each point in an image of `resolution` (columns, rows); otherwise both
    are None.  `at` [s since the epoch] is for people and not part of the digest: the same points
    are the same scan.  `colours` (n, 3) are sRGB values, 0..255, None without colours.
    `joints` (name -> rad, m) are the joints at the time of the scan if an arm carries the scanner;
    `T_world_scanner` follows from them.  They are None for a fixed scanner, or when unknown.
    `views` are the scans that were merged; `joints` belong to the last (`derived.by_view`).
    """

    points: Floats
    T_world_scanner: pin.SE3
    source: str
    pixels: np.ndarray | None = None
    resolution: tuple[int, int] | None = None
    at: float = 0.0
    colours: np.ndarray | None = field(default=None, metadata=LATER)
    joints: Mapping[str, float] | None = field(default=None, metadata=LATER)
    views: tuple[ScannedView, ...] = field(default=(), metadata=LATER)
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        points = frozen(self.points)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
            raise InputError(ScanText.SHAPE(shape=str(points.shape)))
        if not np.all(np.isfinite(points)):
            raise InputError(ScanText.NOT_FINITE())
        if self.pixels is not None and len(self.pixels) != len(points):
            raise InputError(ScanText.PIXELS(points=len(points), pixels=len(self.pixels)))
        if self.colours is not None and np.shape(self.colours) != points.shape:
            raise InputError(
                ScanText.COLOURS(points=len(points), shape=str(np.shape(self.colours)))
            )
        if self.views and sum(view.count for view in self.views) != len(points):
            raise InputError(ScanText.VIEWS(points=len(points)))
        own(self, "T_world_scanner")
        put(
            self,
            points=points,
            pixels=None if self.pixels is None else frozen(self.pixels, np.int32),
            colours=None if self.colours is None else frozen(self.colours, np.uint8),
            joints=None if self.joints is None else dict(self.joints),
        )
        put(self, digest=digest_of(self, without=frozenset({"at", "source"})))

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        of = "" if self.resolution is None else f" of {self.resolution[0]} x {self.resolution[1]}"
        points, source = f"{len(self.points):,}{of}", self.source
        colours = {} if self.colours is None else {"colours": "one for each point"}
        return {"points": points, **colours, "source": source, "digest": self.digest[:12]}

    @property
    def points_world(self) -> Floats:
        """The points (n, 3) [m] in the world frame."""
        T = self.T_world_scanner
        return transform(T, self.points)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Detection(FactsRepr):
    """One part found: its pose, and how reliable it is.

    `score` is 0..1; `visible` 0..1 is the seen share of the surface that faces the scanner.  `gap`
    is the lead in score over the second-best pose of the same object, None without one.
    `roll_known` False: the scan does not show the angle about the near-symmetry axis.  This is
    `roll_axis` (2, 3), a point [m] and a unit direction in the part's frame; None: that of the
    part's symmetry.  `covariance` (6, 6) [m, rad] is that of shifts of the part's origin, then of
    rotations about it, along the world's axes.  `probability` is the chance that the pose is right.
    For poses from outside `gap`, `covariance` and `probability` are None.  `by_colour` True: colour
    decides kind or rotation, which shape leaves open; False: colour should decide and does not;
    None: shape decides.  For a part that an earlier plan has moved, `T_world_found` is its pose in
    the scan; otherwise None.  For a part in an assembly or on a station, `placing` is its possible
    error, and `T_world_seen` its pose in the latest scan since; None: not seen since.
    """

    part: str
    T_world_part: pin.SE3
    score: float = 1.0
    visible: float = 1.0
    gap: float | None = None
    residual: float | None = None
    roll_known: bool = True
    covariance: Floats | None = field(default=None, metadata=LATER)
    probability: float | None = field(default=None, metadata=LATER)
    roll_axis: Floats | None = field(default=None, metadata=LATER)
    T_world_found: pin.SE3 | None = field(default=None, metadata=LATER)
    by_colour: bool | None = field(default=None, metadata=LATER)
    placing: PlacingError | None = field(default=None, metadata=LATER)
    T_world_seen: pin.SE3 | None = field(default=None, metadata=LATER)

    @property
    def is_by_hand(self) -> bool:
        """Whether a person placed it: neither a search nor a file states how well it fits."""
        return self.residual is None and self.gap is None and (self.score, self.visible) == (1, 1)

    def __post_init__(self) -> None:
        if self.covariance is not None and np.shape(self.covariance) != (6, 6):
            raise InputError(ScanText.COVARIANCE())
        if self.roll_axis is not None:
            axis = np.asarray(self.roll_axis, float)
            # Not `>`: what is no number has no length.
            if axis.shape != (2, 3) or not abs(np.linalg.norm(axis[1]) - 1) <= 1e-6:
                raise InputError(ScanText.ROLL_AXIS())
            if not np.isfinite(axis).all():
                raise InputError(ScanText.ROLL_POINT())
        own(self, "T_world_part", "covariance", "roll_axis", "T_world_found", "T_world_seen")
        put(
            self,
            score=float(self.score),
            visible=float(self.visible),
            gap=None if self.gap is None else float(self.gap),
            residual=None if self.residual is None else float(self.residual),
            probability=None if self.probability is None else float(self.probability),
        )

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        x, y, z = self.T_world_part.translation * 1000
        turns = {} if self.roll_known else {"roll": "not known"}
        if self.by_colour is not None:
            turns["told by"] = "its colours" if self.by_colour else "shape alone"
        place, score = f"({x:.1f}, {y:.1f}, {z:.1f}) mm", f"{self.score:.2f}"
        return {"part": self.part, "place": place, "score": score, **turns}

    @property
    def deviations(self) -> tuple[float, float] | None:
        """Standard deviation of the place [m] and of the turn [rad], in the direction of most."""
        if self.covariance is None:
            return None
        place, turn = self.covariance[:3, :3], self.covariance[3:, 3:]
        largest = (float(np.linalg.eigvalsh(block)[-1]) for block in (place, turn))
        return tuple(np.sqrt(np.maximum(list(largest), 0.0)).tolist())  # type: ignore[return-value]


class Objection(enum.StrEnum):
    """Why a hypothesis is not among the parts found."""

    OUTSIDE = "outside the bin"
    TOO_LITTLE = "explains too little of the visible surface"
    FREE_SPACE = "free space violated"
    UNKNOWN = "something unknown explains it better"
    OUTDONE = "a part of another kind explains it and more"
    GOES_ON = "its surface goes on where the part would end"
    COLOURS = "its colours are those of another kind"
    NOT_HELD = "a small shift would be explained as well"
    CLAIMED = "surface claimed by"
    TWIN = "a twin with a worse score of"
    REACHES_INTO = "reaches into"
    RIVAL_FELL = "lost to a pose that does not stand either"


@dataclass(frozen=True, slots=True, eq=False)
class RejectedHypothesis:
    """A hypothesis, and why it is not among the detections.

    `score` is as in a detection; `rival` is the index of the detection that was preferred.
    """

    part: str
    T_world_part: pin.SE3
    score: float
    reason: Objection
    rival: int | None = None

    def __post_init__(self) -> None:
        own(self, "T_world_part")
        put(self, score=float(self.score))

    @property
    def words(self) -> Message:
        """The reason, as a person reads it."""
        objection = ObjectionText[self.reason.name]()
        if self.rival is None:
            return objection
        return ObjectionText.OF_PART(objection=objection, part=FoundPart(self.rival))


OFF_SCALE, OFF_SURFACE, OFF_BY = 0.005, 0.0003, 3.0
"""A size is wrong that differs by more than this share, a surface that lies off by more than this
distance [m]; both also by this many standard deviations."""


@dataclass(frozen=True, slots=True)
class ScaleCheck:
    """Size of a kind of part in a scan relative to its CAD file: `ratio`, with its `deviation`.

    It is measured on `count` parts.
    """

    part: str
    ratio: float
    deviation: float
    count: int

    @property
    def is_off(self) -> bool:
        """Whether the size differs by more than what noise explains."""
        return abs(self.ratio - 1.0) > max(OFF_SCALE, OFF_BY * self.deviation)

    @property
    def words(self) -> Message | None:
        """What is wrong, as a person reads it; None when nothing is."""
        if not self.is_off:
            return None
        share = 1.0 / self.ratio - 1.0
        text = ScaleText.LARGE if share > 0 else ScaleText.SMALL
        return text(part=self.part, share=f"{abs(share) * 100:.1f}")


@dataclass(frozen=True, slots=True)
class OffsetCheck:
    """Distance of a kind of part's surface in a scan from its CAD file.

    `offset` [m] is positive outside, with its `deviation` [m].  It is measured on `count` parts.
    """

    part: str
    offset: float
    deviation: float
    count: int

    @property
    def is_off(self) -> bool:
        """Whether the surface lies off by more than what noise explains."""
        return abs(self.offset) > max(OFF_SURFACE, OFF_BY * self.deviation)

    @property
    def words(self) -> Message | None:
        """What is wrong, as a person reads it; None when nothing is."""
        if not self.is_off:
            return None
        text = ScaleText.OUTSIDE if self.offset > 0 else ScaleText.INSIDE
        return text(part=self.part, distance=abs(self.offset))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LocalizationResult(FactsRepr):
    """Result of a search: the parts, best first, and the best rejected hypotheses.

    `scales` are those of kinds seen well enough to measure their size, `offsets` those of kinds
    whose surface differs from the CAD file.
    """

    detections: tuple[Detection, ...]
    rejected: tuple[RejectedHypothesis, ...] = ()
    scales: tuple[ScaleCheck, ...] = ()
    offsets: tuple[OffsetCheck, ...] = ()

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        found = ", ".join(
            f"{detection.part} {detection.score:.2f}" for detection in self.detections
        )
        return {"found": found or "nothing", "rejected": len(self.rejected)}


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """An unknown object in a scan, as an upright box around it.

    `size` (3,) [m]: full lengths along the axes of the box, whose frame lies in its middle.

    It can also be a part that surely is on a pallet with layers, or in an assembly.  Then `part` is
    its kind, and `T_world_put` the pose of its release; the box is where the part came to rest.  In
    an assembly (`derived.assembling`) the part's own shape counts instead of the box.  `seen` is
    the part in a scan, if the next part must fit to it as seen; then the box is there.
    """

    T_world_box: pin.SE3
    size: Floats
    part: str = field(default="", metadata=LATER)
    T_world_put: pin.SE3 | None = field(default=None, metadata=LATER)
    seen: SeenBase | None = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        size = frozen(self.size)
        if size.shape != (3,) or not np.all(size > 0):
            raise InputError(ScanText.OBSTACLE_SIZE())
        if bool(self.part) != (self.T_world_put is not None) or (self.seen and not self.part):
            raise InputError(ScanText.PALLET_PART())
        own(self, "T_world_box", "T_world_put")
        put(self, size=size)


@dataclass(frozen=True, slots=True)
class Unexplained:
    """Upright boxes around unknown objects.

    `seen` are around the points of the objects, `unseen` around hidden space into which the
    objects may extend.
    """

    seen: tuple[Obstacle, ...] = ()
    unseen: tuple[Obstacle, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class PosesFolder:
    """A folder into which another program puts poses of parts.

    `part` is the part that is meant where a file does not name one; empty: the cell's first.
    """

    path: str
    part: str


@dataclass(frozen=True, slots=True)
class LocalizerChoice:
    """Which localizer finds the parts, empty: the usual one; `options` are its own keys."""

    name: str = ""
    options: Mapping[str, Option] = field(default_factory=dict[str, Option])


@dataclass(frozen=True, slots=True)
class SearchOverrides:
    """How one search differs from the usual.

    `detail` is the resolution of the search relative to the usual: a finer search finds small
    features and takes longer.  Parts with a score below `least_score` are not used.
    """

    detail: float = 1.0
    least_score: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class SearchRecord:
    """A search in the current scan: seed, overrides, what was found, and how long it took [s].

    `number` is that of the entry that began it.
    """

    number: int
    seed: int
    overrides: SearchOverrides
    detections: tuple[Detection, ...]
    seconds: float


@dataclass(frozen=True, slots=True)
class Remark:
    """What a person has done to the parts found, at [s since the epoch]."""

    at: float
    by: str
    says: Message | str


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Content of the bin: the detections, and other objects in the scan.

    `scan_digest` is that of the scan, or of the detections when they came from a file.
    """

    scan_digest: str
    detections: tuple[Detection, ...]
    obstacles: tuple[Obstacle, ...] = ()
