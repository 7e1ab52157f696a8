"""Shipped cells, each read once in a process: tests name them when they are collected."""

from functools import cache

from workbench.formats.cells.reading import read_cell

shipped = cache(read_cell)
