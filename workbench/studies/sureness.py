"""Whether detections are as sure as they say: chances and covariances against the truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import chi2

BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)
"""Limits between which detections are taken together by the chance that they state."""

HELD = 0.99
"""The share of errors that the ellipsoid of a covariance should hold."""


def sureness(
    stated: Sequence[tuple[float, bool]], errors: Sequence[tuple[float, int]]
) -> dict[str, Any]:
    """How well what is stated holds.

    Args:
        stated: of each detection its chance to be right, 0..1, and whether it is.
        errors: of each right one its squared error over the covariance, with its degrees of
            freedom.

    Returns:
        `bins`, each with `count`, the mean that is `stated` and the share that is `right`; the
        `calibration_error`: how far both are apart in the mean over all detections (Guo et al., On
        Calibration of Modern Neural Networks, 2017); the share `within` the ellipsoid that should
        hold 99 %, and of how many `errors`.  None where nothing is to be counted.
    """
    said = np.array([probability for probability, _ in stated])
    is_right = np.array([right for _, right in stated], dtype=float)
    place = np.clip(np.digitize(said, BINS) - 1, 0, len(BINS) - 2)
    bins = [
        {
            "count": int(chosen.sum()),
            "stated": float(said[chosen].mean()),
            "right": float(is_right[chosen].mean()),
        }
        for chosen in (place == number for number in range(len(BINS) - 1))
        if chosen.any()
    ]
    apart = sum(
        probability_bin["count"] * abs(probability_bin["stated"] - probability_bin["right"])
        for probability_bin in bins
    )
    return {
        "bins": bins,
        "calibration_error": apart / len(said) if len(said) else None,
        "within": float(np.mean([_is_within(*error) for error in errors])) if errors else None,
        "errors": len(errors),
    }


def _is_within(square: float, freedom: int) -> bool:
    """Whether an error lies in the ellipsoid: squares of normal errors go by chi-squared."""
    return square <= float(chi2.ppf(HELD, freedom))
