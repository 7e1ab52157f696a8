"""How parts of three kinds are found by libraries of many: `library_figures.py SCENES FIRST KINDS`.

With `PYTHONPATH=.:tests/perception`; all three may be left out, and several numbers of kinds be
given.  Keyed cylinders, brackets and bolts lie there, eight in a pile; the other kinds of a library
are drawn shapes, stretched otherwise each time.
"""

import sys
import time
from dataclasses import replace

import numpy as np
from drawn_shapes import DRAWN

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.geometry import Mesh
from workbench.model.part import Part
from workbench.model.scan import ALL_KINDS
from workbench.model.symmetry import Symmetry
from workbench.perception.parts.part_surface import prepare
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize, visible_shares
from workbench.plugins.localizer import find_parts
from workbench.studies.localization import BUILDS, CLEARLY_SEEN, compare

LYING = ("keyed_cylinder", "bracket", "bolt")
SIZES = (3, 10, 50)
COUNT = 8


def library(size: int) -> tuple[Part, ...]:
    """So many kinds, those that lie there first."""
    lying = tuple(map(read_part, LYING))
    stretched = np.random.default_rng(0).uniform(0.7, 1.4, (size, 3))
    shapes = [make() for make in DRAWN]
    others = []
    for number in range(size - len(lying)):
        drawn = shapes[number % len(shapes)]
        mesh = Mesh(drawn.vertices * stretched[number], drawn.faces)
        others.append(
            replace(lying[1], name=f"drawn_{number}", mesh=mesh, symmetry=Symmetry(fold=1))
        )
    return lying + tuple(others)


def searched(cell: Cell, build: str, seed: int) -> tuple[float, float, int, int, int, int]:
    """Seconds by the clock and of the processor; parts found, wrong, clear, clear and missed."""
    deviation = BUILDS[build].deviation or cell.scanner.depth_noise
    cell = replace(cell, scanner=replace(cell.scanner, depth_noise=deviation))
    lying = replace(cell, parts=cell.parts[: len(LYING)])
    truth = pile_of(lying, ALL_KINDS, COUNT, seed=seed)
    scan = synthesize(lying, truth, seed=seed, noise=BUILDS[build].noise)
    began = time.perf_counter(), time.process_time()
    detections = find_parts(scan, cell, seed=seed).detections
    spent = time.perf_counter() - began[0], time.process_time() - began[1]
    found, is_found = compare(cell.parts, truth, detections)
    clear = [
        right
        for right, share in zip(is_found, visible_shares(lying, truth), strict=True)
        if share > CLEARLY_SEEN
    ]
    wrong = sum(not one.is_right for one in found)
    return *spent, len(found), wrong, len(clear), clear.count(False)


def main(scenes: int = 5, first: int = 51000, *sizes: int) -> None:
    """Print a table of the documentation."""
    print("| kinds | to prepare them, s | noise | found | wrong | clear missed | s | s processor |")
    print("|---|---|---|---|---|---|---|---|")
    for size in sizes or SIZES:
        cell = replace(read_cell("yumi"), parts=library(size))
        began = time.process_time()
        for part in cell.parts:
            prepare(part)
        prepared = time.process_time() - began
        searched(cell, "fine", first - 1)  # what is compiled then is not measured
        for build in ("fine", "rough"):
            rows = [searched(cell, build, seed) for seed in range(first, first + scenes)]
            clock, processor, found, wrong, clear, missed = np.array(rows).T
            print(
                f"| {size} | {prepared:.1f} | {build} | {found.sum():.0f} | {wrong.sum():.0f} "
                f"| {missed.sum():.0f} of {clear.sum():.0f} | {np.median(clock):.2f} "
                f"| {np.median(processor):.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
