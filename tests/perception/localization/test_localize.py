"""From a scan to poses: found where they are, doubts told, nothing invented."""

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from searching import localize, searched

from workbench.formats.parts.reading import read_part
from workbench.model.errors import InputError, JobCancelled
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Detection, Objection, Scan
from workbench.perception.localization import hypotheses
from workbench.perception.parts.point_pairs import vote
from workbench.perception.simulation.noise_models import ROUGH
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import compare


def compared(part, truth, found):
    """What is wrong, how many parts are missed, distances [m] and turns of what is right."""
    judged, is_found = compare((part,), truth, found)
    right = [one for one in judged if one.is_right]
    return (
        [one for one in judged if not one.is_right],
        is_found.count(False),
        [one.distance for one in right],
        [one.turn for one in right],
    )


@pytest.mark.parametrize("seed", range(6))
def test_two_parts_are_found_where_they_are(cell, part, seed):
    truth = drop_parts((part,) * 2, cell.bin, seed=seed)
    found = localize(synthesize(cell, truth, seed=seed), part, cell, seed=0)
    wrong, missed, distances, turns = compared(part, truth, found)
    assert (wrong, missed) == ([], 0)
    assert max(distances) < 0.0005
    assert max(turns) < math.radians(1.0)


def test_a_heap_is_found_too(cell, part):
    truth = drop_parts((part,) * 8, cell.bin, seed=3)
    found = localize(synthesize(cell, truth, seed=3), part, cell, seed=0)
    wrong, missed, *_ = compared(part, truth, found)
    assert (wrong, missed) == ([], 0)


@pytest.mark.parametrize("name", ["bolt", "bracket"])
def test_other_parts_are_found_in_a_rough_scan_too(cell, name):
    part = read_part(name)
    rough = replace(cell, parts=(part,), scanner=replace(cell.scanner, depth_noise=0.0006))
    truth = drop_parts((part,) * 4, rough.bin, seed=1)
    scan = synthesize(rough, truth, seed=1, noise=ROUGH)
    wrong, missed, *_ = compared(part, truth, localize(scan, part, rough, seed=0))
    assert (wrong, missed) == ([], 0)


def test_what_is_discarded_says_why(cell, part):
    truth = drop_parts((part,) * 4, cell.bin, seed=3)
    findings = searched(synthesize(cell, truth, seed=3), part, cell, seed=0)
    assert 0 < len(findings.rejected) <= 20
    scores = [one.score for one in findings.rejected]
    assert scores == sorted(scores, reverse=True)
    for one in findings.rejected:
        lost = one.reason in (Objection.CLAIMED, Objection.TWIN, Objection.REACHES_INTO)
        assert (one.rival is not None) == lost
        if one.rival is not None:
            assert str(one.words).endswith(f" part-{one.rival + 1}")
            assert one.rival < len(findings.detections)
        for found in findings.detections:
            T = one.T_world_part.actInv(found.T_world_part)
            is_same = np.linalg.norm(pin.log3(T.rotation)) < 0.1
            assert not (is_same and np.linalg.norm(T.translation) < 0.002)


def test_the_best_come_first_with_scores_that_can_be_trusted(scan, part, cell):
    found = localize(scan, part, cell, seed=0)
    scores = [detection.score for detection in found]
    assert scores == sorted(scores, reverse=True)
    for detection in found:
        assert detection.part == part.name
        assert 0.3 < detection.score <= 1
        assert detection.score <= detection.visible + 1e-9
        assert 0 < detection.residual < 0.001


def test_the_same_scan_and_seed_give_the_same_poses(scan, part, cell):
    first, second = (localize(scan, part, cell, seed=4) for _ in range(2))
    assert [d.T_world_part.homogeneous.tolist() for d in first] == [
        d.T_world_part.homogeneous.tolist() for d in second
    ]


def test_another_seed_finds_the_same_parts(scan, part, cell, pile):
    for seed in (1, 2):
        wrong, missed, distances, _ = compared(part, pile, localize(scan, part, cell, seed=seed))
        assert (wrong, missed) == ([], 0)
        assert max(distances) < 0.0005


def test_a_cloud_without_order_does_as_well(scan, part, cell, pile):
    shuffled = np.random.default_rng(0).permutation(scan.points)
    wrong, missed, distances, _ = compared(
        part, pile, localize(Scan(shuffled, scan.T_world_scanner, "test"), part, cell, seed=0)
    )
    assert (wrong, missed) == ([], 0)
    assert max(distances) < 0.0005


def test_nothing_is_found_in_an_empty_bin(part, cell):
    assert localize(synthesize(cell, (), seed=0), part, cell, seed=0) == ()


def off(scan, cell, raised, tilted):
    """The scan by a scanner that is not where the cell has it, and by how much in the world."""
    there = pose_from_rpy((0, 0, raised), (math.radians(tilted), 0, 0))
    T = cell.bin.T_world_bin * there * cell.bin.T_world_bin.inverse()
    return Scan(scan.points, T * scan.T_world_scanner, "off", scan.pixels, scan.resolution), T


@pytest.mark.parametrize("raised", [-0.005, 0.003, 0.005])
@pytest.mark.parametrize("name", ["bracket", "keyed_cylinder"])
def test_an_empty_bin_is_empty_whatever_its_height(cell, name, raised):
    part = read_part(name)
    scan, _ = off(synthesize(cell, (), seed=3), cell, raised, 0.0)
    assert localize(scan, part, cell, seed=0) == ()


@pytest.mark.parametrize(("raised", "tilted"), [(0.005, 0.0), (-0.005, 0.0), (0.0, 1.0)])
def test_parts_in_a_bin_that_is_off_are_found_there(cell, raised, tilted):
    part = read_part("bracket")
    cell = replace(cell, parts=(part,))
    truth = drop_parts((part,) * 4, cell.bin, seed=1)
    scan, T = off(synthesize(cell, truth, seed=1), cell, raised, tilted)
    there = tuple(replace(one, T_world_part=T * one.T_world_part) for one in truth)
    wrong, missed, *_ = compared(part, there, localize(scan, part, cell, seed=0))
    assert (wrong, missed) == ([], 0)


@pytest.mark.parametrize(("shift", "turned"), [((0.025, -0.02, 0.0), 0.0), ((0, 0.01, 0), 5.0)])
def test_parts_in_a_bin_that_was_moved_are_found_there(cell, shift, turned):
    part = read_part("bracket")
    cell = replace(cell, parts=(part,))
    truth = drop_parts((part,) * 4, cell.bin, seed=1)
    scan = synthesize(cell, truth, seed=1)
    T_moved = pose_from_rpy(shift, (0, 0, math.radians(turned)))
    believed = replace(cell, bin=replace(cell.bin, T_world_bin=cell.bin.T_world_bin * T_moved))
    wrong, missed, *_ = compared(part, truth, localize(scan, part, believed, seed=0))
    assert (wrong, missed) == ([], 0)


def test_nothing_is_found_where_the_bin_is_not(scan, part, cell):
    elsewhere = replace(cell.bin, T_world_bin=pose_from_rpy((2, 0, 0)))
    assert localize(scan, part, replace(cell, bin=elsewhere), seed=0) == ()


@pytest.mark.parametrize("count", [1, 5, 50])
def test_a_few_points_are_no_part(part, cell, scan, count):
    few = Scan(scan.points[:: len(scan.points) // count][:count], scan.T_world_scanner, "test")
    assert localize(few, part, cell, seed=0) == ()


def test_noise_everywhere_is_no_part(part, cell, scan):
    points = np.random.default_rng(0).uniform([-0.1, -0.15, 0.85], [0.1, 0.15, 0.9], (20_000, 3))
    assert localize(Scan(points, scan.T_world_scanner, "test"), part, cell, seed=0) == ()


def test_a_mesh_that_is_inside_out_is_found_all_the_same(scan, part, cell, pile):
    turned = replace(part, mesh=Mesh(part.mesh.points, part.mesh.triangles[:, ::-1]))
    wrong, missed, *_ = compared(part, pile, localize(scan, turned, cell, seed=0))
    assert (wrong, missed) == ([], 0)


def test_a_mesh_of_which_nothing_can_be_seen_is_refused(scan, part, cell):
    """A triangle there twice: the mesh no longer tells inside from outside."""
    turned = part.mesh.triangles[:, ::-1]
    doubled = replace(part, mesh=Mesh(part.mesh.points, np.vstack([turned, turned[:1]])))
    with pytest.raises(InputError, match=r"keyed_cylinder .* do its triangles look inwards"):
        localize(scan, doubled, cell, seed=0)


def test_not_all_points_of_a_scan_with_very_many_collect_votes(monkeypatch, scan, part, cell, pile):
    voters = []

    def counted(table, seen, references, peaks):
        voters.append(len(references))
        return vote(table, seen, references, peaks)

    monkeypatch.setattr(hypotheses, "vote", counted)
    monkeypatch.setattr(hypotheses, "MOST_REFERENCES", 60)
    wrong, missed, *_ = compared(part, pile, localize(scan, part, cell, seed=0))
    assert (wrong, missed) == ([], 0)
    assert max(voters) == 60


@pytest.mark.parametrize("depth", [0.0, -0.005])
def test_points_beside_and_behind_the_scanner_are_left_out(part, cell, depth):
    """A scanner so low over the bin that they lie in the room above its rim."""
    low = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.09), (np.pi, 0, 0))
    floor = np.random.default_rng(0).uniform([-0.08, -0.1, 0.07], [0.08, 0.1, 0.08], (2000, 3))
    points = np.vstack([floor, [[0.01, 0.01, depth]]])
    assert localize(Scan(points, low, "test"), part, cell, seed=0) == ()


def test_parts_are_found_where_a_corner_of_the_bin_is_behind_the_scanner(cell, part):
    length, width, _ = cell.bin.size
    truth = drop_parts((part,) * 2, cell.bin, seed=1)
    scan = synthesize(cell, truth, seed=1)
    away = (cell.bin.T_world_bin.inverse() * scan.T_world_scanner).translation[2]
    deep = replace(cell, bin=replace(cell.bin, size=np.array([length, width, away + 0.05])))
    wrong, missed, *_ = compared(part, truth, localize(scan, part, deep, seed=0))
    assert (wrong, missed) == ([], 0)


def test_roll_is_only_claimed_where_it_shows(cell, part):
    """Lying with the key upwards it shows; lying on the key nothing tells the roll."""
    down = []
    for roll in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.02), (np.pi / 2, 0, 0))
        T = T * pose_from_rpy((0, 0, 0), (0, 0, roll))
        truth = (Detection(part.name, T),)
        (found,) = localize(synthesize(cell, truth, seed=1), part, cell, seed=0)
        assert compared(part, truth, (found,))[0] == []
        down.append(found.roll_known)
        assert (found.roll_axis is None) == found.roll_known
        if found.roll_axis is not None:
            point, direction = found.roll_axis
            assert abs(direction[2]) > np.cos(np.deg2rad(1.0))
            assert np.linalg.norm(np.cross(point, direction)) < 5e-4
    assert any(down), "the key is never seen"
    assert not all(down), "the key is claimed to be seen through the part"


def test_progress_rises_to_the_end_and_cancelling_ends_it(scan, part, cell):
    told: list[float] = []
    localize(scan, part, cell, seed=0, report=lambda done, note: told.append(done))
    assert told == sorted(told)
    assert told[0] == 0.0
    assert 0.5 < told[-1] <= 1.0
    with pytest.raises(JobCancelled):
        localize(scan, part, cell, seed=0, cancelled=lambda: len(told) > 0)
