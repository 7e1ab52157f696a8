"""Shipped cells, each read once in a process: tests name them when they are collected."""

from dataclasses import replace
from functools import cache

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell

shipped = cache(read_cell)


def without_search(cell: Cell) -> Cell:
    """The cell with parts of which plans search no grips but those of the libraries."""
    parts = [replace(p, library=replace(p.library, searches=False)) for p in cell.parts]
    return replace(cell, parts=tuple(parts))
