"""Average precision of detected poses, as BOP 2024 and BOP-Industrial go by.

Nguyen et al., BOP Challenge 2024 on Model-Based and Model-Free 6D Object Pose Estimation, 2025; as
computed by bop_toolkit: thresholds in scripts/eval_bop24_pose.py, matching in
bop_toolkit_lib/pose_matching.py (`match_poses`), precision in bop_toolkit_lib/score.py
(`calc_pose_detection_scores`, `calc_ap`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

THRESHOLDS: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {
        "mssd": tuple(np.arange(0.05, 0.51, 0.05)),
        "mssd_mm": tuple(np.arange(2, 21, 2) / 1000),
        "mspd": tuple(map(float, range(5, 51, 5))),
    }
)
"""Below which errors are right: MSSD over the diameter, MSSD [m], MSPD [px] of a width of 640."""

WIDTH = 640
"""[px] The width of an image to which MSPD is brought."""

LEAST_VISIBLE = 0.1
"""Objects of which less is visible need not be found, and finding them is no mistake."""

MOST_ESTIMATES = 100
"""In an image, the best; what is beyond does not count."""

RECALLS = np.linspace(0.0, 1.0, 101)
"""At which the precision is averaged, as COCO does it."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """An object found: its name, score, and errors by the names of `THRESHOLDS`.

    Each error is one for each true object of the image, None where that is of another kind.
    """

    object: str
    score: float
    errors: Mapping[str, tuple[float | None, ...]]


@dataclass(frozen=True, slots=True)
class Judged:
    """The estimates in one image, and its true objects: their names and visible shares, 0..1."""

    estimates: tuple[Estimate, ...]
    truth: tuple[tuple[str, float], ...]


def detection_figures(images: Sequence[Judged]) -> dict[str, Any]:
    """The average precision of all that was found, 0..1.

    Returns:
        `mssd`, `mssd_mm` and `mspd`, the mean over thresholds and then over objects; `bop24`, that
        of the first and the last; and `objects`: the same for each, with how many `targets` it
        has.  None where there is nothing to be found, or no such errors are known.
    """
    images = [Judged(_best(result.estimates), result.truth) for result in images]
    targets: dict[str, int] = {}
    for image in images:
        for name, visible in image.truth:
            targets[name] = targets.get(name, 0) + int(visible >= LEAST_VISIBLE)
    wanted = sorted(name for name, count in targets.items() if count)
    known = [
        e
        for e in THRESHOLDS
        if all(e in estimate.errors for i in images for estimate in i.estimates)
    ]
    objects: dict[str, dict[str, Any]] = {
        name: {"targets": targets[name]}
        | {
            error: float(np.mean([_precision(images, name, error, t) for t in THRESHOLDS[error]]))
            for error in known
        }
        for name in wanted
    }
    figures: dict[str, Any] = {
        error: float(np.mean([errors_of_object[error] for errors_of_object in objects.values()]))
        if objects and error in known
        else None
        for error in THRESHOLDS
    }
    both = (figures["mssd"], figures["mspd"])
    return {
        **figures,
        "bop24": None if None in both else float(np.mean(both)),
        "objects": objects,
    }


def _best(estimates: Sequence[Estimate]) -> tuple[Estimate, ...]:
    return tuple(sorted(estimates, key=lambda estimate: -estimate.score)[:MOST_ESTIMATES])


def _precision(images: Sequence[Judged], name: str, error: str, threshold: float) -> float:
    """The average precision for one object at one threshold."""
    scores: list[float] = []
    right: list[bool] = []
    wanted = 0
    for image in images:
        wanted += sum(
            name_there == name and share >= LEAST_VISIBLE for name_there, share in image.truth
        )
        taken: set[int] = set()
        for estimate in image.estimates:
            if estimate.object != name:
                continue
            best = _match(estimate.errors[error], threshold, taken)
            if best is not None:
                taken.add(best)
            if best is None or image.truth[best][1] >= LEAST_VISIBLE:
                scores.append(estimate.score)
                right.append(best is not None)
    return average_precision(scores, right, wanted)


def _match(errors: Sequence[float | None], threshold: float, taken: set[int]) -> int | None:
    """The nearest true object below the threshold that no better estimate has taken."""
    open_to = {
        k: e for k, e in enumerate(errors) if e is not None and e < threshold and k not in taken
    }
    return min(open_to, key=lambda k: open_to[k], default=None)


def average_precision(scores: Sequence[float], right: Sequence[bool], wanted: int) -> float:
    """The mean over 101 recalls of the highest precision at that recall or more, 0..1.

    Args:
        scores: of what was found.
        right: whether it is.
        wanted: how many there are to be found, at least one.
    """
    order = np.argsort(-np.array(scores), kind="stable")
    hits = np.cumsum(np.array(right, dtype=float)[order])
    recall, precision = hits / wanted, hits / np.arange(1, len(hits) + 1)
    return float(
        np.mean([precision[recall >= threshold].max(initial=0.0) for threshold in RECALLS])
    )
