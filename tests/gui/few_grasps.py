"""A part with few grasps, and the grasp that it has."""

from dataclasses import replace

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.people import Role
from workbench.app.runtime.bench import Bench
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary

PART = "keyed_cylinder"


def with_grasps(bench: Bench, *entries: Grasp) -> None:
    """The part with these grasps only."""
    cell = bench.state.cell
    part = replace(cell.part(PART), library=GraspLibrary(entries))
    bench.do(ChangeCell(replace(cell, parts=(part,)), "other grasps"), "Ada", Role.ENGINEER)


def grasp_now(bench: Bench) -> Grasp:
    (grasp,) = bench.state.cell.part(PART).library.entries
    return grasp


HAND = Grasp("side", pose_from_rpy((0, 0, 0.02)), 0.04, 0.03)
