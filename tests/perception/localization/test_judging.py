"""What stands when all is held together: no wrong kinds, and what real scanners see."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from searching import searched

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, Solid
from workbench.model.scan import Objection
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.simulation.noise_models import NOISE_MODELS
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import compare


@pytest.fixture(scope="module")
def rod(part):
    body = trimesh.creation.cylinder(0.01, 0.06, sections=48)
    mesh = Mesh(body.vertices, body.faces)
    return replace(
        part,
        name="rod",
        mesh=mesh,
        pieces=(Solid("rod", mesh, pin.SE3.Identity()),),
        symmetry=Symmetry(fold=0, also=(SymmetryAxis(np.eye(3)[0], 2),)),
    )


def test_rods_in_a_pile_of_brackets_are_something_unknown(cell, rod):
    bracket = read_part("bracket")
    lying = replace(cell, parts=(bracket,))
    scan = synthesize(lying, drop_parts((bracket,) * 8, cell.bin, seed=7000), seed=7000)
    findings = searched(scan, rod, replace(cell, parts=(rod,)), seed=7000)
    assert findings.detections == ()
    assert Objection.UNKNOWN in {one.reason for one in findings.rejected}


@pytest.mark.parametrize(
    ("name", "deviation"), [("stereo", 0.0012), ("time_of_flight", 0.0025), ("laser_line", 0.00015)]
)
def test_parts_are_found_as_other_kinds_of_scanner_see_them(cell, name, deviation):
    """With the noise that the cell has for its own: the scan tells its."""
    bracket = read_part("bracket")
    there = replace(cell, parts=(bracket,), scanner=replace(cell.scanner, depth_noise=deviation))
    truth = drop_parts((bracket,) * 4, cell.bin, seed=1)
    scan = synthesize(there, truth, seed=1, noise=NOISE_MODELS[name])
    found = searched(scan, bracket, replace(cell, parts=(bracket,)), seed=0).detections
    judged, is_found = compare((bracket,), truth, found)
    assert all(one.is_right for one in judged)
    assert is_found.count(False) == 0
