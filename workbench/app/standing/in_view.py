"""Whether the scanner views the places of bases that a scan has to show, before anything is."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.assembling import bases_to_see, standing_parts
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.derived.scanner_poses import scanner_pose
from workbench.model.geometry import transform
from workbench.model.scan import Detection
from workbench.perception.views.camera import Pinhole
from workbench.proof.claims.places.layers import kept_box


@dataclass(frozen=True, slots=True)
class BasePlace:
    """A place of a base that a scan has to show, and the views from which it is in the picture.

    `place` counts those of the `arm` for this kind from 1.  `seen_from` are names of views, the
    empty one of a scanner that stands; `views` are how many there are.
    """

    recipe: int
    base: str
    arm: str
    place: int
    seen_from: tuple[str, ...]
    views: int


def base_places(cell: Cell) -> Iterator[BasePlace]:
    """The places of all recipes at which a scan has to show a base."""
    for recipe in cell.recipes:
        chosen = with_recipe(cell, recipe.number)
        views = _views(chosen)
        for base in sorted(bases_to_see(chosen, ())):
            for arm in chosen.arms:
                for number, place in enumerate(arm.places_for(base), 1):
                    put = Detection(base, place.T_world_part)
                    box = kept_box(chosen, (), put, place.T_world_part)
                    (stands,) = standing_parts(chosen, [box])
                    seen_from = tuple(
                        name for name, T in views if _is_in_picture(chosen, stands, T)
                    )
                    yield BasePlace(recipe.number, base, arm.name, number, seen_from, len(views))


def _views(cell: Cell) -> list[tuple[str, pin.SE3]]:
    """The names of all views with `T_world_scanner` there."""
    carrier = cell.scanner.on_arm
    if carrier is None:
        return [("", cell.scanner.T_world_scanner)]
    return [(view.name, scanner_pose(cell, view.q)) for view in carrier.views]


def _is_in_picture(cell: Cell, stands: Detection, T_world_scanner: pin.SE3) -> bool:
    """Whether all of a part lies in the scanner's picture and range; things may still hide it."""
    mount, camera = cell.scanner, Pinhole.of_scanner(cell.scanner)
    points = cell.part(stands.part).mesh.points
    T = T_world_scanner.actInv(stands.T_world_part)
    x, y, z = transform(T, points).T
    if z.min() < mount.near or z.max() > mount.far:
        return False
    pixels = np.stack([x / z, y / z], axis=1) * camera.focal + camera.centre
    rows, columns = camera.shape
    return bool((pixels >= 0).all() and (pixels <= [columns - 1, rows - 1]).all())
