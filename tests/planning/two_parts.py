"""A cell with two parts in the bin, and a plan for them, made once, for several folders."""

import numpy as np
import pytest
from shipped import without_search

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import PlanResult
from workbench.model.scan import Detection
from workbench.planning.collision.world import World


@pytest.fixture(scope="session")
def detections(cell: Cell) -> tuple[Detection, ...]:
    """Two cylinders lying along the bin's floor, apart from each other and from the walls."""
    along, height, floor = (np.pi / 2, 0.0), 0.0191, cell.bin.T_world_bin.translation
    return (
        Detection("keyed_cylinder", pose_from_rpy(floor + [-0.01, -0.07, height], (*along, 0.4))),
        Detection("keyed_cylinder", pose_from_rpy(floor + [0.01, 0.07, height], (*along, -0.6))),
    )


@pytest.fixture(scope="session")
def cell() -> Cell:
    return without_search(read_cell("yumi"))


@pytest.fixture
def world(cell: Cell, detections: tuple[Detection, ...]) -> World:
    return World(cell, detections)


@pytest.fixture(scope="session")
def result(cell: Cell, detections: tuple[Detection, ...]) -> PlanResult:
    return plan_pick(cell, detections, "scan", seed=0)
