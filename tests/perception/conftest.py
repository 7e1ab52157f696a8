"""One pile and its scan, made once."""

import pinocchio as pin
import pytest

from workbench.formats.cells import read_cell
from workbench.model.cell import Cell
from workbench.model.part import Part
from workbench.model.scan import Scan
from workbench.perception.piles import drop_parts
from workbench.perception.synthesize import synthesize


@pytest.fixture(scope="session")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="session")
def part(cell: Cell) -> Part:
    return cell.parts[0]


@pytest.fixture(scope="session")
def pile(cell: Cell, part: Part) -> tuple[pin.SE3, ...]:
    return drop_parts(part, cell.bin, 3, seed=11)


@pytest.fixture(scope="session")
def scan(cell: Cell, part: Part, pile: tuple[pin.SE3, ...]) -> Scan:
    return synthesize(cell, part, pile, seed=11)
