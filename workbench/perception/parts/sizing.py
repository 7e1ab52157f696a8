"""Parts that are larger or smaller than their CAD files, and the size that a scan shows."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.model.cell import Cell
from workbench.model.geometry import Mesh, outwards
from workbench.model.part import Part
from workbench.model.scan import LocalizationResult

EXACT_LEVEL = 0.05
"""See `outwards`: these meshes are exact."""

MOST_SEARCHES = 4
"""Searches at most: poses found with a wrong size show the right one only nearly."""


def sized(part: Part, factor: float, *, about_middle: bool = False) -> Part:
    """The part with a mesh `factor` times as large, about what its symmetry leaves in its place.

    Its convex pieces, symmetry and grasps are as they were.

    Args:
        part: the part.
        factor: no unit.
        about_middle: about the place of these that is nearest to the mesh's middle, so that a pose
            has both meshes in the same place.
    """
    if factor == 1.0:
        return part
    fixed = np.array(part.symmetry.point)
    if about_middle:
        middle = (part.mesh.points.min(axis=0) + part.mesh.points.max(axis=0)) / 2
        fixed = part.symmetry.invariant_point(middle)
    points = fixed + factor * (part.mesh.points - fixed)
    return replace(part, mesh=replace(part.mesh, points=points))


def grown(part: Part, by: float) -> Part:
    """The part with a mesh whose faces lie `by` [m] further outside, inside where that is negative.

    Its convex pieces, symmetry and grasps are as they were.
    """
    if by == 0.0:
        return part
    # Brings Open3D along, which takes longer to load than to read a cell.
    from workbench.perception.views.surfaces import triangles_of

    mesh = triangles_of(part.mesh)
    mesh.merge_vertices()
    triangles = np.asarray(mesh.faces)
    points = mesh.vertices + by * outwards(np.asarray(mesh.vertices), triangles, EXACT_LEVEL)
    return replace(part, mesh=Mesh(points, triangles))


def with_sizes(cell: Cell, sizes: Mapping[str, float]) -> Cell:
    """The cell whose parts are this many times as large, no unit, by their names."""
    return replace(cell, parts=tuple(sized(part, sizes.get(part.name, 1.0)) for part in cell.parts))


def learn_sizes(
    cell: Cell, search: Callable[[Cell], LocalizationResult], names: Sequence[str]
) -> tuple[LocalizationResult, Cell, dict[str, float]]:
    """Search until the parts of these names are as large as the scan shows them.

    Args:
        cell: its parts in the sizes that are known before.
        search: finds the parts of a cell in the scan.
        names: of parts.

    Returns:
        The result of the last search, its cell, and for each changed part the ratio of its size
        to the size before (no unit).
    """
    sizes: dict[str, float] = {}
    findings = search(cell)
    for _ in range(MOST_SEARCHES - 1):
        checks = (check for check in findings.scales if check.part in names)
        off = {check.part: check.ratio for check in checks if check.is_off}
        if not off:
            break
        cell = with_sizes(cell, off)
        sizes |= {name: sizes.get(name, 1.0) * ratio for name, ratio in off.items()}
        findings = search(cell)
    return findings, cell, sizes


def offset_of(findings: LocalizationResult, name: str) -> float:
    """How far outside of its mesh [m] a scan shows a part's surface; 0 where it is not off."""
    checks = (check for check in findings.offsets if check.part == name)
    return next((check.offset for check in checks if check.is_off), 0.0)
