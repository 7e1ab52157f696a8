"""One search for parts in a scan: what was wished, and what it found, to be compared."""

from dataclasses import dataclass

from workbench.model.scan import Detection


@dataclass(frozen=True, slots=True)
class SearchWishes:
    """How one search differs from the usual.

    `detail` is how fine the scan is looked at, 1 being usual: finer finds small features and takes
    longer.  Parts with a score below `least_score` are not taken.
    """

    detail: float = 1.0
    least_score: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """A search in the current scan: its seed and wishes, what was found, and how long it took [s].

    `number` is that of the entry that began it.
    """

    number: int
    seed: int
    wishes: SearchWishes
    detections: tuple[Detection, ...]
    seconds: float


@dataclass(frozen=True, slots=True)
class Remark:
    """What a person has done to the parts found, at [s since the epoch]."""

    at: float
    by: str
    says: str
