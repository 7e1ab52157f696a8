"""Loads that a plan states and the cell does not have, by a computation of the proof's own."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.model.geometry import Mesh
from workbench.model.load import Load, loads_of
from workbench.proof.claims.grasps.loads import load_violations


def weighed(cell, arm, mass=0.23):
    """The cell with a mass of the arm's tool."""
    arms = tuple(
        replace(one, tool=replace(one.tool, mass=mass)) if one.name == arm else one
        for one in cell.arms
    )
    return replace(cell, arms=arms)


@pytest.fixture
def proven(cell, result):
    return SimpleNamespace(cell=cell, plan=result.plan)


def said(cell, plan, loads):
    one = replace(plan.arms[0], loads=loads)
    return [str(found) for found in load_violations(cell, plan, one)]


def right(cell, plan):
    one = plan.arms[0]
    part = cell.part(plan.detections[one.detection].part)
    return loads_of(cell.arm(one.arm).tool, part, one.T_tcp_part)


def test_a_plan_states_the_loads_of_its_cell(proven):
    cell, plan = weighed(proven.cell, proven.plan.arms[0].arm), proven.plan
    loads = right(cell, plan)
    assert said(cell, plan, loads) == []
    unweighed = weighed(cell, plan.arms[0].arm, None)
    assert said(unweighed, plan, None) == []
    (problem,) = said(cell, plan, None)
    assert "states no load" in problem
    (problem,) = said(unweighed, plan, loads)
    assert "no mass of the tool" in problem


@pytest.mark.parametrize("what", ["tool", "part"])
@pytest.mark.parametrize("change", ["mass", "centre", "inertia"])
def test_a_load_that_is_a_little_otherwise_is_noticed(proven, what, change):
    cell, plan = weighed(proven.cell, proven.plan.arms[0].arm), proven.plan
    loads = right(cell, plan)
    load = getattr(loads, what)
    bent = {
        "mass": lambda: replace(load, mass=load.mass * 1.001),
        "centre": lambda: replace(load, centre=load.centre + [0, 0, 1e-4]),
        "inertia": lambda: Load(load.mass, load.centre, load.inertia * 1.01),
    }[change]()
    (problem,) = said(cell, plan, replace(loads, **{what: bent}))
    assert f"the load of the {what} is not that of the cell" in problem


def test_the_load_of_a_part_with_an_open_surface_is_that_of_its_pieces(proven):
    plan = proven.plan
    cell = weighed(proven.cell, plan.arms[0].arm)
    part = cell.part(plan.detections[plan.arms[0].detection].part)
    opened = replace(part, mesh=Mesh(part.mesh.points, part.mesh.triangles[1:]))
    cell = replace(cell, parts=tuple(opened if p.name == part.name else p for p in cell.parts))
    assert said(cell, plan, right(cell, plan)) == []
