"""A part must end where its pose has it end: pieces of other kinds' surfaces are no parts."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from searching import searched

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Detection, Objection
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import compare


@pytest.mark.extensive
def test_bolts_in_a_pile_of_cylinders_are_pieces_of_them(cell):
    cylinder, bolt = read_part("keyed_cylinder"), read_part("bolt")
    lying = replace(cell, parts=(cylinder,))
    truth = drop_parts((cylinder,) * 8, cell.bin, seed=601)
    scan = synthesize(lying, truth, seed=601)
    findings = searched(scan, bolt, replace(cell, parts=(bolt,)), seed=601)
    reasons = [one.reason for one in findings.rejected]
    assert reasons.count(Objection.GOES_ON) + reasons.count(Objection.UNKNOWN) >= 3
    assert findings.detections == ()
    for one in findings.rejected:
        assert one.rival is None or one.rival < len(findings.detections)


@pytest.fixture(scope="module")
def block(part):
    """A block with a step, so that it lies in one way only."""
    base = trimesh.creation.box((0.06, 0.04, 0.02))
    step = trimesh.creation.box((0.02, 0.04, 0.015))
    step.apply_translation((0.02, 0.0, 0.0165))
    mesh = trimesh.boolean.union([base, step])
    return replace(part, name="block", mesh=Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces)))


def test_parts_a_millimetre_apart_are_both_found(cell, block):
    cell = replace(cell, parts=(block,))
    places = [(-0.0305, 0.0, 0.01), (0.0305, 0.0, 0.01)]
    truth = tuple(
        Detection("block", cell.bin.T_world_bin * pose_from_rpy(place)) for place in places
    )
    found = searched(synthesize(cell, truth, seed=1), block, cell, seed=0).detections
    judged, is_found = compare((block,), truth, found)
    assert all(is_found) and all(one.is_right for one in judged)
