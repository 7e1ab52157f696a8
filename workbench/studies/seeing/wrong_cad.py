"""CAD files of a wrong size: are the parts found, and is the error reported?"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from workbench.studies.cases import percentiles
from workbench.studies.localization import CLEARLY_SEEN, Scene, Task, how_sure

SCALE_NEAR, OFFSET_NEAR = 0.01, 0.0003
"""By which a reported scale, and a reported distance [m] of the surface, may be wrong."""

COUNT = 8
"""Parts in a pile."""


def wrong_cad_tasks(
    cell: str,
    parts: Sequence[str],
    builds: Sequence[str],
    *,
    scales: Sequence[float],
    offsets: Sequence[float],
    scenes: int,
    seed: int,
) -> list[Task]:
    """Piles of each part for each scanner, searched by each wrong CAD file; the seeds count up.

    Args:
        cell: name or path.
        parts: names or paths.
        builds: scanners, by name.
        scales: of the CAD files over the parts.
        offsets: [m] by which faces of the CAD files lie outside of those of the parts.
        scenes: piles for each part, scanner and error.
        seed: of the first pile.
    """
    errors = [(scale, 0.0) for scale in scales] + [(1.0, offset) for offset in offsets]
    cases = [
        (part, build, error)
        for error in errors
        for build in builds
        for part in parts
        for _ in range(scenes)
    ]
    return [
        Task(cell, part, build, COUNT, seed + number, cad_scale=scale, cad_offset=offset)
        for number, (part, build, (scale, offset)) in enumerate(cases)
    ]


def wrong_cad_rows(scenes: Sequence[Scene]) -> list[dict[str, Any]]:
    """A row for each error and scanner, over all parts.

    `stated` is the mean probability, `right` the share of right detections; `reported` counts the
    piles with a scale within `SCALE_NEAR`, and where surfaces lie off with an offset within
    `OFFSET_NEAR`; `off` counts those that call the CAD file wrong.
    """
    groups: dict[tuple[float, float, str], list[Scene]] = {}
    for scene in scenes:
        task = scene.task
        groups.setdefault((task.cad_scale, task.cad_offset, task.build), []).append(scene)
    return [_row(*key, group) for key, group in groups.items()]


def _row(scale: float, offset: float, build: str, scenes: Sequence[Scene]) -> dict[str, Any]:
    found = [pose for scene in scenes for pose in scene.found]
    clear = [
        is_found
        for scene in scenes
        for visible, is_found in zip(scene.visible, scene.is_found, strict=True)
        if visible > CLEARLY_SEEN
    ]
    checks = [check for scene in scenes for check in scene.scales]
    offsets = [check for scene in scenes for check in scene.offsets]
    reported = (
        [abs(check.offset + offset) <= OFFSET_NEAR for check in offsets]
        if offset != 0.0
        else [abs(check.ratio - 1.0 / scale) <= SCALE_NEAR for check in checks]
    )
    return {
        "scale": scale,
        "offset": offset,
        "build": build,
        "piles": len(scenes),
        "clear": len(clear),
        "missed": clear.count(False),
        "found": len(found),
        "right": sum(pose.is_right for pose in found),
        "stated": float(np.mean([pose.probability or 0.0 for pose in found])) if found else None,
        "calibration_error": how_sure(scenes)["calibration_error"],
        "reported": sum(reported),
        "off": sum(check.is_off for check in (*checks, *offsets)),
        "distance": percentiles(
            [pose.distance for pose in found if pose.distance is not None], median=50, worst=100
        ),
        "processor_seconds": percentiles(
            [scene.processor_seconds for scene in scenes], median=50, worst=100
        ),
    }
