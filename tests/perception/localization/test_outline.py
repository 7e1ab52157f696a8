"""A part must end where its pose has it end: pieces of other kinds' surfaces are no parts."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from searching import searched

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Detection, Objection
from workbench.perception.localization import kinds, loosening
from workbench.perception.localization.judging import PartSearch
from workbench.perception.localization.localize import begin_search
from workbench.perception.localization.outline import has_visible_boundary
from workbench.perception.parts.part_surface import prepare
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import BUILDS, compare


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


def test_a_bolt_does_not_end_on_the_side_of_a_cylinder_that_bends_away(cell, monkeypatch):
    # Otherwise none is thought to lie there.
    monkeypatch.setattr(loosening, "_bends_alike", lambda search: True)
    monkeypatch.setattr(kinds, "allow_changes", lambda found, _: found)
    cylinder, bolt = read_part("keyed_cylinder"), read_part("bolt")
    build = BUILDS["time_of_flight"]
    scanner = replace(cell.scanner, depth_noise=build.deviation)
    cell = replace(cell, parts=(bolt,), scanner=scanner)
    lying = (pose_from_rpy((0.0, y, 0.019), (0.0, np.pi / 2, 0.0)) for y in (-0.04, 0.0, 0.04))
    truth = tuple(Detection(cylinder.name, cell.bin.T_world_bin * pose) for pose in lying)
    scan = synthesize(replace(cell, parts=(cylinder,)), truth, seed=3, noise=build.noise)
    scene = scene_model(scan, cell, smallest=prepare(bolt).diameter)
    search = begin_search(scan, bolt, cell, detail=1.0, scene=scene)
    assert isinstance(search, PartSearch)
    nobody = np.zeros(search.depth_map.depth.size, np.bool_)
    T_scanner_world = scan.T_world_scanner.inverse()

    def ending(**limits):
        """How many bolts end that are thought to lie on the cylinders."""
        return sum(
            has_visible_boundary(
                search.depth_map,
                search.surface,
                (T_scanner_world * report.T_world_part).homogeneous,
                search.tolerance,
                nobody,
                **limits,
            )
            for report in searched(scan, bolt, cell, seed=3).detections
        )

    assert ending(most_bent=1.0) >= 2
    assert ending() == 0
