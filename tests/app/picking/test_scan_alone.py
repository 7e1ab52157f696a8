"""A plan beside a scan without poses: its word for parts counts as far as the scan shows them."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import check, prove, scene_of
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.certificates import Certificate, versions
from workbench.model.digest import digest_of
from workbench.perception.scene.unexplained import explained_by, unexplained
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


@pytest.fixture(scope="module")
def case(cell):
    """A scan, a plan for poses in it, and which part each point (n,) belongs to."""
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=931)
    scan = synthesize(cell, pile, seed=931)
    boxes = unexplained(cell, scan, pile)
    plan = plan_pick(cell, pile, digest_of(pile), obstacles=boxes).plan
    assert plan is not None
    T = scan.T_world_scanner
    return scan, plan, explained_by(cell, pile, scan.points @ T.rotation.T + T.translation)


def with_points(scan, points):
    return replace(scan, points=points, pixels=None)


def certificate_of(cell, plan, scan):
    proof = prove(cell, plan, scan=scan)
    return Certificate(plan, scene_of(cell, plan, scan=scan), proof, versions())


def test_what_the_scan_shows_holds(cell, case):
    scan, plan, _ = case
    assert prove(cell, plan, scan=scan).holds
    assert check(cell, certificate_of(cell, plan, scan), scan).holds


def test_a_part_that_the_scan_does_not_show_is_not_there(cell, case):
    """Such a scan has nothing that no part explains, so that nothing else stands against it."""
    scan, plan, whose = case
    for gone in range(len(plan.detections)):
        other = with_points(scan, scan.points[whose != gone])
        proof = prove(cell, plan, scan=other)
        said = f"part-{gone + 1} of the plan is not in the scan"
        assert [str(v.problem) for v in proof.violations] == [said]
        # Who knows by other means where parts are says so by poses.
        assert prove(cell, plan, detections=plan.detections, scan=other).holds
        checked = check(cell, certificate_of(cell, plan, scan), other)
        assert [str(v.problem) for v in checked.violations] == [said]


@pytest.mark.parametrize("far", [0.005, 0.012])
def test_a_part_that_lies_higher_is_found_elsewhere(cell, case, far):
    scan, plan, whose = case
    up = scan.T_world_scanner.rotation.T @ np.array([0.0, 0.0, far])
    other = with_points(scan, scan.points + up * (whose == 0)[:, None])
    problems = [str(violation.problem) for violation in prove(cell, plan, scan=other).violations]
    assert "part-1 of the plan is not in the scan" in problems
