"""Kept cases searched again: what is right, wrong and missed now, beside what it was then."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from workbench.app.records.cases import Case, read_case
from workbench.app.runtime.work import find_parts
from workbench.model.digest import digest_of
from workbench.model.errors import WorkbenchError
from workbench.model.scan import Detection
from workbench.perception.matching.pose_error import pose_error
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import Report, never, silent
from workbench.studies.localization import RIGHT_TURN, RIGHT_WITHIN

BY_HAND = 3.0
"""This many times as far from where a person has put a part may a right detection be.

People move a part until it looks right, and a search fits it to the scan: an assumption, which no
measurement has confirmed.
"""


@dataclass(frozen=True, slots=True)
class Tally:
    """Detections compared with a person's corrections; `is_right` for each real part.

    A detection is `wrong` where the person removed a detection, or moved it by more than the limits
    of the study on simulated piles.  It is also wrong at a part that a better detection has, and
    elsewhere if the scan shows nothing else.  Otherwise detections elsewhere are `unjudged`.
    """

    is_right: tuple[bool, ...] = ()
    wrong: int = 0
    unjudged: int = 0

    @property
    def right(self) -> int:
        """Number of parts found correctly."""
        return sum(self.is_right)

    @property
    def missed(self) -> int:
        """Number of real parts not found, or not correctly."""
        return len(self.is_right) - self.right


@dataclass(frozen=True, slots=True)
class Held:
    """A case searched again: `before` is what was found when it was kept, `now` what is.

    `seconds_before` [s] were taken on the machine on which it was kept, `seconds` on this one.
    `problem` says why it could not be searched; then nothing else is known.
    """

    name: str
    comment: str = ""
    cell: str = ""
    workbench: str = ""
    before: Tally = field(default_factory=Tally)
    now: Tally = field(default_factory=Tally)
    seconds_before: float = 0.0
    seconds: float = 0.0
    problem: str = ""

    @property
    def lost(self) -> int:
        """Parts that were found rightly and are not now."""
        pairs = zip(self.before.is_right, self.now.is_right, strict=True)
        return sum(before and not now for before, now in pairs)

    @property
    def is_worse(self) -> bool:
        """Whether a part that was right is not now, or more detections are wrong."""
        return self.lost > 0 or self.now.wrong > self.before.wrong

    @property
    def is_better(self) -> bool:
        """Whether it is not worse, and more parts are right or fewer detections wrong."""
        more = self.now.right > self.before.right or self.now.wrong < self.before.wrong
        return more and not self.is_worse


def tally(case: Case, detections: Sequence[Detection]) -> Tally:
    """Hold detections, the surest first, against what a person says of a scan.

    A detection counts by the pose nearest to it, of all that are said to be right or wrong: within
    the limits of that study, `BY_HAND` times as wide where the search has not put the part itself.
    Errors are those of `pose_error`: of poses that look alike the nearest counts, and a roll that
    either of both does not know does not.
    """
    # Who moves a part by less than what counts, or takes the poses of another matcher, does not
    # call wrong what was found.
    called_wrong = [
        called
        for called in case.changed
        if all(_error(case, true, called) > 1.0 for true in case.truth)
    ]
    stated = (*case.truth, *called_wrong)
    found = {digest_of(detection) for detection in case.search.detections}
    limits = [1.0 if digest_of(true_pose) in found else BY_HAND for true_pose in stated]
    right: set[int] = set()
    wrong = unjudged = 0
    for detection in detections:
        errors = [_error(case, true_pose, detection) for true_pose in stated]
        near = [k for k, limit in enumerate(limits) if errors[k] <= limit]
        if not near:
            wrong += case.is_complete
            unjudged += not case.is_complete
            continue
        nearest = min(near, key=errors.__getitem__)
        if nearest < len(case.truth) and nearest not in right:
            right.add(nearest)
        else:
            wrong += 1
    return Tally(tuple(k in right for k in range(len(case.truth))), wrong, unjudged)


def _error(case: Case, stated: Detection, found: Detection) -> float:
    """How far apart two poses are, over the limits of the study; no unit, 1 is on the limit."""
    if stated.part != found.part:
        return float("inf")
    distance, turn = pose_error(
        case.cell.part(stated.part),
        stated.T_world_part,
        found.T_world_part,
        roll_known=stated.roll_known and found.roll_known,
        roll_axis=stated.roll_axis if found.roll_known else found.roll_axis,
    )
    return max(distance / RIGHT_WITHIN, turn / RIGHT_TURN)


def held_cases(paths: Iterable[Path], report: Report = silent) -> list[Held]:
    """Search in kept cases again, each with its own cell, seed and overrides.

    The first with some parts is searched twice, since the time is that of parts made ready.

    Args:
        paths: files of cases; one that cannot be used says why, and the others go on.
        report: progress.
    """
    files, ready, found = tuple(paths), set[tuple[str, ...]](), list[Held]()
    for number, path in enumerate(files):
        report(number / len(files), f"{number} of {len(files)} cases")
        try:
            case = read_case(path)
            parts = tuple(part.digest for part in case.cell.parts)
            if parts not in ready:
                _search(case)
                ready.add(parts)
            found.append(_compare(path.name, case))
        except WorkbenchError as error:
            found.append(Held(path.name, problem=" ".join(str(error).split())))
        except Exception as error:
            # A rim: what comes from elsewhere, or a localizer of somebody else, ends no study.
            said = f"{path}: cannot be searched: {type(error).__name__}: {error}"
            found.append(Held(path.name, problem=" ".join(said.split())))
    return found


def _compare(name: str, case: Case) -> Held:
    began = working_time()
    now = _search(case)
    seconds = working_time() - began
    before = case.search
    return Held(
        name,
        case.comment,
        case.cell.name,
        case.workbench,
        tally(case, before.detections),
        tally(case, now),
        before.seconds,
        seconds,
    )


def _search(case: Case) -> tuple[Detection, ...]:
    about = {"scan": case.scan, "seed": case.search.seed, "overrides": case.search.overrides}
    return find_parts(case.cell, about, silent, never).detections


def in_all(held: Sequence[Held]) -> dict[str, Any]:
    """Sums over the cases that were searched, and how many became worse or better."""
    done = [comparison for comparison in held if not comparison.problem]
    sides = {
        side: {
            "right": sum(case_tally.right for case_tally in tallies),
            "wrong": sum(case_tally.wrong for case_tally in tallies),
            "missed": sum(case_tally.missed for case_tally in tallies),
            "unjudged": sum(case_tally.unjudged for case_tally in tallies),
        }
        for side, tallies in (
            ("before", [comparison.before for comparison in done]),
            ("now", [comparison.now for comparison in done]),
        )
    }
    return {
        "cases": len(done),
        "parts": sum(len(comparison.now.is_right) for comparison in done),
        **sides,
        "worse": sum(comparison.is_worse for comparison in done),
        "better": sum(comparison.is_better for comparison in done),
        "unusable": len(held) - len(done),
    }
