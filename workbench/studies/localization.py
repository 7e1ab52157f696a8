"""How well and how fast parts are found: seeded piles, simulated scans, true poses to compare."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.runtime.work import find_parts
from workbench.formats.cells.reading import read_cell
from workbench.formats.meshes.reading import read_mesh
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Part
from workbench.model.scan import ALL_KINDS, Detection, OffsetCheck, ScaleCheck
from workbench.perception.matching.pose_error import (
    mahalanobis_squared,
    mssd,
    pose_error,
)
from workbench.perception.parts.sizing import grown, sized
from workbench.perception.simulation.noise_models import NOISE_MODELS, NoiseModel
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize, visible_shares
from workbench.perception.views.camera import Pinhole
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.progress import never, silent
from workbench.studies.bop.pose_errors import errors_by_name, pose_errors, shape_of
from workbench.studies.bop.precision import Estimate, Judged, detection_figures
from workbench.studies.cases import percentiles
from workbench.studies.sureness import sureness

RIGHT_WITHIN, RIGHT_TURN = 0.002, float(np.deg2rad(3.0))
"""[m], [rad] A detection that is further from a true pose is wrong."""

CLEARLY_SEEN = 0.6
"""Parts of which more than this share can be seen are expected to be found."""

BEST = 2
"""Detections at the head of the list on which the robot acts first."""


@dataclass(frozen=True, slots=True)
class Build:
    """A scanner: the noise that its mount declares [m], None for the cell's own, and the rest.

    It is that of a pixel by itself: what builds that average leave of it is less (`NoiseModel`).
    """

    deviation: float | None
    noise: NoiseModel


DEVIATIONS: Mapping[str, float] = MappingProxyType(
    {
        "rough": 0.0006,
        "structured_light": 0.0004,
        "stereo": 0.0012,
        "time_of_flight": 0.0025,
        "laser_line": 0.00015,
        "moving": 0.00015,
    }
)

BUILDS: Mapping[str, Build] = MappingProxyType(
    {name: Build(DEVIATIONS.get(name), noise) for name, noise in NOISE_MODELS.items()}
)

TOGETHER = "+"
"""Joins the names of parts that fall into one pile."""


@dataclass(frozen=True, slots=True)
class Task:
    """One scene: which parts lie in it, how many, and which build of scanner sees them.

    The scanner is not where the cell has it: all that it sees is `raised` [m] and `tilted` [rad]
    about the bin's x axis.  `searched` are the kinds that are searched for, as in `part`; empty:
    those that lie there.  Their CAD files are `cad_scale` times as large as what lies there, their
    faces `cad_offset` [m] further outside; or meshes in the folder `models`, in millimetres, stand
    in for them.
    """

    cell: str
    part: str
    build: str
    count: int
    seed: int
    raised: float = 0.0
    tilted: float = 0.0
    searched: str = ""
    cad_scale: float = 1.0
    models: str = ""
    cad_offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Found:
    """A detection against the truth, in the order of the scores.

    `distance` [m] of the part's middle and `turn` [rad] from the nearest true pose that no better
    detection has taken; None when none is left.  Where the roll is said to be unknown it does not
    count.  `is_right`: both are within the limits.  `mssd` [m] see there.  `probability` is the
    chance that it states, `squared_error` that of a right one over its covariance with its degrees
    of freedom.
    """

    distance: float | None
    turn: float | None
    roll_known: bool
    is_right: bool
    mssd: float | None = None
    probability: float | None = None
    squared_error: tuple[float, int] | None = None


@dataclass(frozen=True, slots=True)
class Scene:
    """What came of a task: `visible` and `is_found` of each true part, and the time [s].

    `processor_seconds` are those of the search's own thread, so all of them only where numba has
    one (`NUMBA_NUM_THREADS=1`).  `bop` is what BOP goes by, `scales` and `offsets` what the
    search says of the CAD files.
    """

    task: Task
    found: tuple[Found, ...]
    visible: tuple[float, ...]
    is_found: tuple[bool, ...]
    seconds: float
    bop: Judged = field(default_factory=lambda: Judged((), ()))
    scales: tuple[ScaleCheck, ...] = ()
    processor_seconds: float = 0.0
    offsets: tuple[OffsetCheck, ...] = ()


def localized_scene(task: Task) -> Scene:
    """Drop parts, scan them, find them, and compare."""
    cell = _warm(replace(task, part=task.searched or task.part, searched="", count=0, seed=0))
    lying = replace(cell, parts=_kinds(task.part))
    fallen = pile_of(lying, ALL_KINDS, task.count, seed=task.seed)
    scan = synthesize(lying, fallen, seed=task.seed, noise=BUILDS[task.build].noise)
    T_world_bin = cell.bin.T_world_bin
    off = T_world_bin * pose_from_rpy((0, 0, task.raised), (task.tilted, 0, 0))
    off = off * T_world_bin.inverse()
    truth = tuple(
        replace(detection, T_world_part=off * detection.T_world_part) for detection in fallen
    )
    scan = replace(scan, T_world_scanner=off * scan.T_world_scanner)
    began, processor_began = working_time(), processor_time()
    result = find_parts(cell, {"scan": scan, "seed": task.seed}, silent, never)
    seconds, processor_seconds = working_time() - began, processor_time() - processor_began
    detections = result.detections
    names = {part.name for part in cell.parts}
    is_searched = [detection.part in names for detection in truth]
    there = [detection for detection, wanted in zip(truth, is_searched, strict=True) if wanted]
    found, is_found = compare(cell.parts, there, detections)
    shares = visible_shares(lying, fallen)
    visible = tuple(share for share, wanted in zip(shares, is_searched, strict=True) if wanted)
    T_scanner_world = scan.T_world_scanner.inverse()
    bop = Judged(
        tuple(
            Estimate(
                detection.part, detection.score, _errors(cell, T_scanner_world, there, detection)
            )
            for detection in detections
        ),
        tuple((detection.part, share) for detection, share in zip(there, visible, strict=True)),
    )
    return Scene(
        task, found, visible, is_found, seconds, bop, result.scales, processor_seconds,
        result.offsets,
    )  # fmt: skip


def _errors(
    cell: Cell, T_scanner_world: pin.SE3, truth: Sequence[Detection], found: Detection
) -> Mapping[str, tuple[float | None, ...]]:
    """The errors of a detection against all that lies there, as BOP has them."""
    shape, camera = shape_of(cell.part(found.part)), Pinhole.of_scanner(cell.scanner)
    return errors_by_name(
        [
            pose_errors(
                shape,
                T_scanner_world * true.T_world_part,
                T_scanner_world * found.T_world_part,
                camera.matrix,
                camera.shape[1],
            )
            if true.part == found.part
            else None
            for true in truth
        ]
    )


@lru_cache(maxsize=12)
def _kinds(names: str) -> tuple[Part, ...]:
    return tuple(map(read_part, names.split(TOGETHER)))


@lru_cache(maxsize=12)
def _warm(task: Task) -> Cell:
    """The cell of a task, after a search: code and parts are prepared."""
    kinds = tuple(
        grown(
            sized(_with_model(part, task.models), task.cad_scale, about_middle=True),
            task.cad_offset,
        )
        for part in _kinds(task.part)
    )
    deviation = BUILDS[task.build].deviation
    cell = read_cell(task.cell)
    scanner = cell.scanner if deviation is None else replace(cell.scanner, depth_noise=deviation)
    cell = replace(cell, parts=kinds, scanner=scanner)
    # What falls are the parts as they are: pieces would not fit another mesh.
    lying = replace(cell, parts=_kinds(task.part))
    scan = synthesize(lying, pile_of(lying, ALL_KINDS, len(kinds), seed=0), seed=0)
    find_parts(cell, {"scan": scan, "seed": 0}, silent, never)
    return cell


def _with_model(part: Part, models: str) -> Part:
    """The part with the mesh of its name in a folder, if one is given."""
    return (
        replace(part, mesh=read_mesh(Path(models, f"{part.name}.ply"), 0.001)) if models else part
    )


def compare(
    parts: Sequence[Part], truth: Sequence[Detection], detections: Sequence[Detection]
) -> tuple[tuple[Found, ...], tuple[bool, ...]]:
    """Each detection against the truth of its kind, and whether each true part is found rightly."""
    kinds = {part.name: part for part in parts}
    left = list(range(len(truth)))
    right: set[int] = set()
    found: list[Found] = []
    for detection in detections:
        kind = kinds[detection.part]
        errors = {
            k: pose_error(
                kind,
                truth[k].T_world_part,
                detection.T_world_part,
                roll_known=detection.roll_known,
                roll_axis=detection.roll_axis,
            )
            for k in left
            if truth[k].part == kind.name
        }
        if not errors:
            found.append(
                Found(None, None, detection.roll_known, False, None, detection.probability)
            )
            continue
        fits = {k: d <= RIGHT_WITHIN and turn <= RIGHT_TURN for k, (d, turn) in errors.items()}
        best = min(errors, key=lambda k: (not fits[k], errors[k]))
        surface = mssd(kind, truth[best].T_world_part, detection.T_world_part)
        found.append(
            Found(
                *errors[best],
                detection.roll_known,
                fits[best],
                surface,
                detection.probability,
                _squared_error(kind, truth[best], detection) if fits[best] else None,
            )
        )
        if fits[best]:
            right.add(best)
            left.remove(best)
    return tuple(found), tuple(k in right for k in range(len(truth)))


def _squared_error(part: Part, true: Detection, found: Detection) -> tuple[float, int] | None:
    if found.covariance is None:
        return None
    return mahalanobis_squared(
        part,
        true.T_world_part,
        found.T_world_part,
        found.covariance,
        roll_known=found.roll_known,
        roll_axis=found.roll_axis,
    )


def how_sure(scenes: Sequence[Scene]) -> dict[str, Any]:
    """Over all scenes, how well holds what detections state of themselves; see `sureness`."""
    found = [pose for scene in scenes for pose in scene.found]
    stated = [(pose.probability, pose.is_right) for pose in found if pose.probability is not None]
    errors = [
        pose.squared_error for pose in found if pose.is_right and pose.squared_error is not None
    ]
    return sureness(stated, errors)


def summary(scenes: Sequence[Scene]) -> list[dict[str, Any]]:
    """One row for each part, build and count, in the order in which they come.

    Shares are None when nothing is there to be counted.  `clear` are the parts that are expected
    to be found, `missed` those of them that are not; `roll_unknown` are right detections that
    claim no roll.  `bop` is the average precision as BOP has it (`detection_figures`), and
    `size` what is said of the CAD files: in how many scenes it is `told` and `said` to be wrong,
    and the `median` of the scanned size over it.
    """
    groups: dict[tuple[str, str, int], list[Scene]] = {}
    for scene in scenes:
        task = scene.task
        groups.setdefault((task.part, task.build, task.count), []).append(scene)
    return [_row(*key, group) for key, group in groups.items()]


def _row(part: str, build: str, count: int, scenes: Sequence[Scene]) -> dict[str, Any]:
    found = [pose for scene in scenes for pose in scene.found]
    best = [pose for scene in scenes for pose in scene.found[:BEST]]
    right = [pose for pose in found if pose.is_right]
    clear = [
        is_found
        for scene in scenes
        for visible, is_found in zip(scene.visible, scene.is_found, strict=True)
        if visible > CLEARLY_SEEN
    ]
    return {
        "part": part,
        "build": build,
        "count": count,
        "scenes": len(scenes),
        "parts": sum(len(scene.visible) for scene in scenes),
        "clear": len(clear),
        "found": len(found),
        "best_right": _share([pose.is_right for pose in best]),
        "precision": _share([pose.is_right for pose in found]),
        "recall": _share(clear),
        "wrong": len(found) - len(right),
        "missed": clear.count(False),
        "roll_unknown": sum(not pose.roll_known for pose in right),
        "distance": _percentiles([pose.distance for pose in right if pose.distance is not None]),
        "turn": _percentiles([pose.turn for pose in right if pose.turn is not None]),
        "mssd": _percentiles([pose.mssd for pose in right if pose.mssd and pose.roll_known]),
        "seconds": _percentiles([scene.seconds for scene in scenes]),
        "processor_seconds": _percentiles([scene.processor_seconds for scene in scenes]),
        "bop": detection_figures([scene.bop for scene in scenes]),
        "size": _size([scene.scales for scene in scenes]),
    }


def _size(scenes: Sequence[tuple[ScaleCheck, ...]]) -> dict[str, Any]:
    ratios = [scale.ratio for scales in scenes for scale in scales]
    return {
        "told": sum(bool(scales) for scales in scenes),
        "said": sum(any(scale.is_off for scale in scales) for scales in scenes),
        "median": float(np.median(ratios)) if ratios else None,
    }


def _share(flags: Sequence[bool]) -> float | None:
    return sum(flags) / len(flags) if flags else None


def _percentiles(values: Sequence[float]) -> dict[str, float] | None:
    return percentiles(values, median=50, p90=90, worst=100)
