"""How true models merged from several scans are: simulated scans, poses known nearly."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin
import trimesh

from workbench.extras.reconstruction.depth_views import Bounds, depth_view
from workbench.extras.reconstruction.reconstruct import Reconstruction, reconstruct
from workbench.extras.reconstruction.surface import distances
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.part import Bin, Part
from workbench.model.scan import Detection, Scan
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.views.surfaces import triangles_of
from workbench.studies.localization import BUILDS

DISTANCE, NEAR_RANGE, FAR_RANGE = 0.6, 0.3, 0.9
"""[m] From the scanner to the part's middle, and its range."""

WAYS = {"turntable": (40.0,), "held": (45.0, -45.0, 0.0)}
"""[deg] How high the scanner is as seen from the part, view by view: over a turntable's plate, or
on all sides of a part that is held, of which nothing that holds it is simulated."""

REGION_SLACK = 0.01
"""[m] The region is so much larger than the part, except for the plate."""

POINTS = 20_000
"""On each surface, from which distances to the other are measured."""


@dataclass(frozen=True, slots=True)
class ModelTask:
    """One model: how the part is scanned, by which build, from how many poses, how wrong they are.

    `shift` [m] and `turn` [rad] are the root mean squares of the errors of poses, in and about the
    model's frame: of turntable or flange.  The second scan's is `off` [m] along x besides.
    """

    way: str
    build: str
    views: int
    shift: float
    turn: float
    seed: int
    off: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class MadeModel:
    """A model, and a row of figures: distances [m] in both directions, volume over the true one.

    The same of the convex hull of what the first scan shows stands beside it.
    """

    reconstruction: Reconstruction
    row: dict[str, Any]


def made_model(part: Part, task: ModelTask) -> MadeModel:
    """Scan a part that stands as in its own frame, merge the scans, and compare with its mesh.

    Raises:
        InputError: the scans are not merged, as `reconstruct` has it.
    """
    true = triangles_of(part.mesh)
    low, high = (np.array(corner) for corner in true.bounds)
    bounds = Bounds(low - REGION_SLACK, high + REGION_SLACK)
    if task.way == "turntable":
        bounds = Bounds(np.array([*(low - REGION_SLACK)[:2], low[2]]), high + REGION_SLACK)
    scans = _scans(part, task, low, high)
    made = reconstruct(scans, bounds)
    model = triangles_of(made.mesh)
    view = depth_view(scans[0], bounds)
    hull = trimesh.convex.convex_hull(view.points()[0])
    hull.apply_transform(view.T_model_camera.homogeneous)
    row = {
        "part": part.name,
        "way": task.way,
        "build": task.build,
        "unseen": made.unseen,
        "triangles": len(made.mesh.triangles),
        "apart": made.apart,
        "model": _compare(model, true),
        "hull": _compare(hull, true),
    }
    return MadeModel(made, row)


def _scans(part: Part, task: ModelTask, low: Floats, high: Floats) -> tuple[Scan, ...]:
    cell, build = read_cell("yumi"), BUILDS[task.build]
    generator = np.random.default_rng(task.seed)
    # The plate of a turntable is a bin without walls; of a part that is held it is out of sight.
    under = low[2] if task.way == "turntable" else low[2] - 10.0
    plate = Bin(pose_from_rpy((0, 0, under)), np.array([0.4, 0.4, 0.1]), has_walls=False)
    middle, heights = (low + high) / 2, WAYS[task.way]
    scans: list[Scan] = []
    for number in range(task.views):
        around = 2 * np.pi * number / task.views
        up = np.deg2rad(heights[number % len(heights)])
        aside = np.array([np.cos(around), np.sin(around)]) * np.cos(up)
        T_part_scanner = _looking(middle + DISTANCE * np.array([*aside, np.sin(up)]), middle)
        mount = replace(
            cell.scanner,
            T_world_scanner=T_part_scanner,
            depth_noise=build.deviation or cell.scanner.depth_noise,
            near=NEAR_RANGE,
            far=FAR_RANGE,
        )
        seen = replace(cell, parts=(part,), bin=plate, fixtures=(), scanner=mount)
        there = [Detection(part.name, pin.SE3.Identity(), 1.0)]
        seed = int(generator.integers(2**31))
        scan = synthesize(seen, there, seed=seed, noise=build.noise)
        shift, turn = generator.normal(size=(2, 3)) / np.sqrt(3)
        error = pin.SE3(pin.exp3(turn * task.turn), shift * task.shift)
        if number == 1:
            error = pose_from_rpy((task.off, 0, 0)) * error
        scans.append(
            replace(scan, T_world_scanner=error * T_part_scanner, source=f"scan {number + 1}")
        )
    return tuple(scans)


def _looking(eye: Floats, at: Floats) -> pin.SE3:
    """The pose of a scanner at `eye` (3,) [m] that looks at a point (3,) [m], upright."""
    z = (at - eye) / np.linalg.norm(at - eye)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return pin.SE3(np.stack([x, np.cross(z, x), z], axis=1), eye)


def _compare(model: trimesh.Trimesh, true: trimesh.Trimesh) -> dict[str, float]:
    """Distances [m] of points on each surface from the other, and volume over the true one."""
    apart = np.concatenate([_off(model, true), _off(true, model)])
    return {
        "median": float(np.median(apart)),
        "p95": float(np.quantile(apart, 0.95)),
        "hausdorff": float(apart.max()),
        "volume": float(model.volume / true.volume),
    }


def _off(mesh: trimesh.Trimesh, other: trimesh.Trimesh) -> Floats:
    points = trimesh.sample.sample_surface(mesh, POINTS, seed=0)[0]
    return distances(points, other)
