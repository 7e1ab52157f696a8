"""One pile and its scan, made once."""

import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.part import Part
from workbench.model.scan import Detection, Scan
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="session")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="session")
def part(cell: Cell) -> Part:
    return cell.parts[0]


@pytest.fixture(scope="session")
def pile(cell: Cell, part: Part) -> tuple[Detection, ...]:
    return drop_parts((part,) * 3, cell.bin, seed=11)


@pytest.fixture(scope="session")
def scan(cell: Cell, pile: tuple[Detection, ...]) -> Scan:
    return synthesize(cell, pile, seed=11)
