"""What the study of emptying is asked, and what it finds out about one pile."""

from dataclasses import dataclass
from typing import Literal

Seen = Literal["truth", "scan"]
"""Whether plans are made with the true poses or with those found in a simulated scan."""

TOGETHER = "+"
"""Joins the names of parts that fall into one pile."""

FAILURES = ("missed", "crooked", "turned")
"""Kinds of failed picks: the fingers close on nothing, on a part that lies elsewhere, or on one
that lies there but for its roll, which the scan did not show, and that is not held so."""


@dataclass(frozen=True, slots=True)
class Task:
    """One pile: of which cell and parts, how many, by which seed, and how it is emptied.

    `part` is one of the cell's, `all` for all of them in turn, or others by name or path, joined by
    `TOGETHER`; empty: the cell's first.  `settles`: the rest moves by physics as a part is lifted.
    `bounds`: what stays is tried by all grasps of the tool, too.  `change`: words of a change of
    the cell (`changes`) that the pile is emptied with, empty for none; it lies as without it, and
    what stays is told without a nearest fix.  `picks`: plans in a row after one look, at most.
    """

    cell: str
    part: str
    count: int
    seed: int
    seen: Seen = "truth"
    settles: bool = True
    strategy: str = "auto"
    bounds: bool = False
    change: str = ""
    picks: int = 1


@dataclass(frozen=True, slots=True)
class Left:
    """A part that stayed in the bin: `part-3` is the third that fell.

    `kind` is the word of the verdict that got furthest, `not found` or `stopped`, `reason` a
    sentence about it; `nearest_fix` is the smallest change of a grasp that takes it, empty when
    none was found; `any_grasp` what a search through all grasps of the tool said, empty when nobody
    asked.
    """

    part: str
    kind: str
    reason: str
    nearest_fix: str
    any_grasp: str = ""


@dataclass(frozen=True, slots=True)
class Scene:
    """What became of a pile.

    Of `parts`, `taken` came out as planned; `failed` counts the failed picks by kind, in the order
    of `FAILURES`, `touches` the legs on which something met that the plan held apart, and
    `knocked_out` the parts that fell out of the bin.  `cycles` are approvals: plans carried out,
    or rows of them; `scans` are looks into the bin.  `motion_seconds` [s] is predicted by the
    plans, `planning` [s] was measured for every look, `stages` [s] by stage in all, and `finding`
    [s] for the parts in the scans.  `more` is how many of those left come out by any grasp of the
    tool, None when nobody asked; `rolled` how many of those taken had another roll than found,
    which the localizer had said.
    """

    task: Task
    parts: int
    taken: int
    failed: tuple[int, ...]
    touches: int
    knocked_out: int
    cycles: int
    scans: int
    motion_seconds: float
    left: tuple[Left, ...]
    planning: tuple[float, ...]
    stages: tuple[tuple[str, float], ...]
    finding: float
    more: int | None = None
    rolled: int = 0
