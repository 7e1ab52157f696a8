"""The shipped cell that assembles, with a post for spacers, and plates around the left nest."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.picking.pallets import boxes_around
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.model.scan import Detection, Obstacle

PLATES = 0.1
"""[m] From the middle of the nest to each plate: no hand comes to the bolt from the side."""

HIGH = 0.04


def cell_with_post() -> Cell:
    """By its recipe; a spacer is taken by its side, or from its end while leaning."""
    cell = with_recipe(read_cell(find("robots", "yumi") / "assembly.toml"), 1)
    regrasp = read_cell(find("robots", "yumi") / "regrasp.toml")
    post = next(fixture for fixture in regrasp.fixtures if fixture.name == "post")
    fixtures = tuple(
        replace(fixture, solids=(*fixture.solids, *_plates()))
        if fixture.name == "nest_left"
        else fixture
        for fixture in cell.fixtures
    )
    parts = tuple(
        replace(
            part,
            library=replace(
                part.library,
                searches=False,
                entries=tuple(e for e in part.library.entries if e.name in ("side", "end_leaning")),
            ),
        )
        if part.name == "spacer"
        else part
        for part in cell.parts
    )
    return replace(cell, fixtures=(*fixtures, post), stations=regrasp.stations, parts=parts)


def _plates() -> tuple[Solid, ...]:
    plates: list[Solid] = []
    for name, x, y in (("front", 1, 0), ("back", -1, 0), ("left", 0, 1), ("right", 0, -1)):
        size = np.array([0.004 if x else 2 * PLATES, 0.004 if y else 2 * PLATES, HIGH])
        T = pin.SE3(np.eye(3), np.array([x * PLATES, y * PLATES, HIGH / 2]))
        plates.append(Solid(f"plate_{name}", Box(size), T))
    return tuple(plates)


def bolt_in_nest(cell: Cell) -> tuple[Obstacle, ...]:
    """Let go of in the left nest."""
    T = cell.arm("left").part_places[0].T_world_part
    return boxes_around(cell, [Detection("bolt", T)])


def lying_spacer(cell: Cell) -> Detection:
    """On a flat, in the bin."""
    on_flat = pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, np.pi / 6))
    T = pose_from_rpy((0.0, 0.05, 0.0155), (np.pi / 2, 0.0, 1.0)) * on_flat
    return Detection("spacer", cell.bin.T_world_bin * T, 0.9)
