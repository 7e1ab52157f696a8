"""What is counted while a pile is emptied."""

from collections import Counter
from dataclasses import dataclass, field

from workbench.app.emptying.assemblies import Assembled
from workbench.model.prediction import FAILURES
from workbench.model.scan import Detection, Scene


@dataclass(slots=True)
class Tally:
    """What has happened with one pile.

    `seen_in_motion` is of looks that may be taken while the robot still moves: how long that goes
    on, and how long finding and planning took [s].  `standing` are the numbers of parts on
    stations, between two plans of a row.
    """

    taken: int = 0
    rolled: int = 0
    failed: Counter[str] = field(default_factory=Counter[str])
    touches: int = 0
    knocked_out: int = 0
    cycles: int = 0
    scans: int = 0
    motion: float = 0.0
    planning: list[float] = field(default_factory=list[float])
    stages: Counter[str] = field(default_factory=Counter[str])
    finding: float = 0.0
    seen: tuple[Detection, ...] = ()
    known: Scene = field(default_factory=lambda: Scene("", ()))
    stirs: int = 0
    outcomes: list[str] = field(default_factory=list[str])
    seen_in_motion: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    warned_picks: int = 0
    warned_touches: int = 0
    assembled: Assembled = field(default_factory=Assembled)
    standing: set[int] = field(default_factory=set[int])


def counts_of(failed: Counter[str]) -> tuple[int, ...]:
    """Failed picks by kind, the last one only where there are any: as before there was that kind.

    So what is recorded in sessions stays the same in cells whose grips nobody weighs.
    """
    counts = tuple(failed[kind] for kind in FAILURES)
    return counts if counts[-1] else counts[:-1]
