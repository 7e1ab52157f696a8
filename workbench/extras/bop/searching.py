"""The localizer run on images of a BOP data set, and its poses or anybody's judged."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.runtime.work import find_parts
from workbench.extras.bop.models import ObjectModel, read_models
from workbench.extras.bop.results import PoseEstimate
from workbench.extras.bop.scenes import BopImage, depth_width, read_depth, read_images
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, sampled
from workbench.model.part import Bin, GraspLibrary, Part
from workbench.model.scan import Scan
from workbench.model.symmetry import Symmetry
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import Report, never, silent
from workbench.studies.bop.pose_errors import Shape, errors_by_name, pose_errors
from workbench.studies.bop.precision import Estimate, Judged, detection_figures

PLANES_TRIED = 300
"""Planes through three points that are compared to find what things lie on."""

MOST_POINTS = 20_000
"""Points by which they are compared."""

PLANE_WITHIN = 0.002
"""How far a point of a plane may lie off it, over its distance from the camera."""

MARGIN = 0.02
"""[m] Room around all that is seen."""

HIGHEST_SHARE = 0.8
"""Share of the way from what things lie on to the camera in which they are searched for."""


@dataclass(frozen=True, slots=True, eq=False)
class DataSet:
    """Images, the objects to be found in them, and the shapes that errors are measured on."""

    images: tuple[BopImage, ...]
    models: Mapping[int, ObjectModel]
    shapes: Mapping[int, Shape]

    @classmethod
    def read(cls, folder: Path, split: str, models: str, sensor: str, most: int) -> "DataSet":
        """The data set in a folder; `most` images at most, 0: all.

        Raises:
            FileError: a file is missing or broken.
            InputError: nothing is to be found in it, or an object has no model.
        """
        searched = read_models(folder / models)
        fine = folder / "models_eval"
        measured = read_models(fine) if fine.is_dir() else searched
        images = tuple(read_images(folder, split, sensor))
        images = images[:most] if most else images
        there = {true.object for image in images for true in image.truth}
        if not there:
            raise InputError(f"{folder / split}: no image has a true pose, so nothing is measured")
        lacking = sorted(there - (searched.keys() & measured.keys()))
        if lacking:
            raise InputError(f"{folder}: object {lacking[0]} lies in a scene and has no model")
        shapes = {
            number: Shape(model.mesh.points, model.motions, model.diameter)
            for number, model in measured.items()
        }
        return cls(images, searched, shapes)

    def search(
        self, cell: Cell, seed: int, report: Report = silent, *, is_own_bin: bool = False
    ) -> list[PoseEstimate]:
        """What the cell's localizer finds in all images; every object is searched for in each.

        `is_own_bin`: the images are of the cell's bin, by its scanner; see `place_of` else.
        """
        parts = tuple(
            Part(str(number), model.mesh, (), 1.0, Symmetry(), GraspLibrary())
            for number, model in self.models.items()
        )
        found: list[PoseEstimate] = []
        for done, image in enumerate(self.images):
            report(done / len(self.images), f"image {image.number} of scene {image.scene}")
            found += _find(replace(cell, parts=parts), image, seed, is_own_bin)
        return found


def figures_of(data: DataSet, found: Sequence[PoseEstimate]) -> dict[str, Any]:
    """`detection_figures` of what was found, and the mean time of an image, `seconds`, if known.

    Raises:
        InputError: an object was found that has no model.
    """
    of_image: dict[tuple[int, int], list[PoseEstimate]] = {}
    for estimate in found:
        if estimate.object not in data.shapes:
            raise InputError(
                f"object {estimate.object} was found, of which the data set has no model"
            )
        of_image.setdefault((estimate.scene, estimate.image), []).append(estimate)
    each = [(image, of_image.get((image.scene, image.number), [])) for image in data.images]
    times = [estimates[0].seconds for _, estimates in each if estimates]
    is_known = bool(times) and min(times) >= 0
    return {
        **detection_figures([_judge(data.shapes, *image) for image in each]),
        "seconds": float(np.mean(times)) if is_known else None,
    }


def _judge(shapes: Mapping[int, Shape], image: BopImage, found: Sequence[PoseEstimate]) -> Judged:
    width = depth_width(image)

    def errors(estimate: PoseEstimate) -> dict[str, tuple[float | None, ...]]:
        return errors_by_name(
            [
                pose_errors(
                    shapes[estimate.object],
                    true.T_camera_object,
                    estimate.T_camera_object,
                    image.K,
                    width,
                )
                if true.object == estimate.object
                else None
                for true in image.truth
            ]
        )

    return Judged(
        tuple(
            Estimate(str(estimate.object), estimate.score, errors(estimate)) for estimate in found
        ),
        tuple((str(true.object), true.visible) for true in image.truth),
    )


def _find(cell: Cell, image: BopImage, seed: int, is_own_bin: bool) -> list[PoseEstimate]:
    """What is found in one image.

    Nothing is taken from the truth: where to look is reported by the image alone.
    """
    depths = read_depth(image)
    rows, columns = np.nonzero(depths)
    z = depths[rows, columns]
    across = np.linalg.solve(image.K, np.stack([columns, rows, np.ones(len(z))]))
    # The third coordinate of the rays is 1: the last row of K is 0 0 1.
    height, width = depths.shape
    scan = Scan(
        across.T * z[:, None],
        pin.SE3.Identity(),
        "bop",
        rows * width + columns,
        (width, height),
    )
    mount = replace(cell.scanner, T_world_scanner=pin.SE3.Identity())
    T_scanner_bin = cell.scanner.T_world_scanner.actInv(cell.bin.T_world_bin)
    own = replace(cell.bin, T_world_bin=T_scanner_bin)
    there = replace(cell, bin=own if is_own_bin else place_of(scan.points, seed), scanner=mount)
    began = working_time()
    detections = find_parts(there, {"scan": scan, "seed": seed}, silent, never).detections
    seconds = working_time() - began
    return [
        PoseEstimate(
            image.scene,
            image.number,
            int(detection.part),
            detection.score,
            detection.T_world_part,
            seconds,
        )
        for detection in detections
    ]


def place_of(points: Floats, seed: int) -> Bin:
    """Where parts may lie in a picture: a box above the plane that most of it lies on.

    That is the plane through three points with the most points on it, less those behind it.

    Args:
        points: (n, 3) [m] in the camera's frame, all before it.
        seed: of the planes that are compared.
    """
    some = sampled(points, MOST_POINTS)
    generator = np.random.default_rng(seed)
    best, normal, offset = -np.inf, np.array([0.0, 0.0, -1.0]), float(some[:, 2].max())
    for _ in range(PLANES_TRIED):
        a, b, c = some[generator.integers(len(some), size=3)]
        n = np.cross(b - a, c - a)
        length = float(np.linalg.norm(n))
        if not length > 0:
            continue
        n *= -np.sign(n @ a) / length  # towards the camera
        height = (some - a) @ n
        gate = PLANE_WITHIN * some[:, 2]
        count = np.count_nonzero(np.abs(height) < gate) - np.count_nonzero(height < -gate)
        if count > best:
            best, normal, offset = count, n, float(-n @ a)
    height = some @ normal + offset
    on = np.abs(height) < PLANE_WITHIN * some[:, 2]
    if np.count_nonzero(on) >= 3:
        middle = some[on].mean(axis=0)
        fitted = np.linalg.svd(some[on] - middle, full_matrices=False)[2][2]
        normal = fitted * -np.sign(fitted @ middle)
        offset = float(-normal @ middle)
    R = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), normal).matrix()
    flat = some @ R
    low, high = flat[:, :2].min(axis=0) - MARGIN, flat[:, :2].max(axis=0) + MARGIN
    tall = min(float((some @ normal).max()) + offset + MARGIN, HIGHEST_SHARE * offset)
    origin = R @ np.array([*(low + high) / 2, -offset])
    return Bin(pin.SE3(R, origin), np.array([*(high - low), max(tall, MARGIN)]))
