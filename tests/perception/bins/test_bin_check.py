"""The bin in a scan: where it is, how full, and no false alarm by a heap."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.messages.calibration import BinText
from workbench.model.scan import Detection, Scan
from workbench.perception.bins.bin_check import check_bin
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


def is_too_full(check):
    return any(finding.text is BinText.TOO_FULL for finding in check.findings)


def scanned(cell, parts=0, shift=(0, 0, 0), rpy_deg=(0, 0, 0), seed=0):
    """A scan with the bin elsewhere, and where it truly is."""
    T = cell.bin.T_world_bin * pose_from_rpy(np.array(shift) / 1000, np.deg2rad(rpy_deg))
    moved = replace(cell, bin=replace(cell.bin, T_world_bin=T))
    part = cell.parts[0]
    pile = drop_parts((part,) * parts, moved.bin, seed=seed)
    return synthesize(moved, pile, seed=seed), T


def error(check, truth) -> tuple[float, float]:
    between = truth.actInv(check.T_world_bin)
    distance, angle = (
        np.linalg.norm(between.translation),
        np.linalg.norm(pin.log3(between.rotation)),
    )
    return distance * 1000, np.rad2deg(angle)


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
@pytest.mark.parametrize(
    ("shift", "rpy_deg"),
    [
        ((12, -7, 0), (0, 0, 0)),
        ((30, 25, 0), (0, 0, 6)),
        ((-50, 40, 8), (0, 0, -10)),
        ((0, 0, -9), (0, 0, 0)),
        ((0, 0, 0), (1.5, 1.0, 0)),
    ],
)
def test_a_moved_bin_is_measured(name, shift, rpy_deg):
    cell = read_cell(name)
    scan, truth = scanned(cell, 3, shift, rpy_deg, seed=1)
    check = check_bin(scan, cell.bin)
    assert check.is_elsewhere and check.light == "warning"
    distance, angle = error(check, truth)
    assert distance < 0.7 and angle < 0.15
    assert "from its place in the cell" in str(check.says)
    assert check.shift == pytest.approx(np.linalg.norm(shift) / 1000, abs=0.001)


@pytest.mark.parametrize("parts", [1, 2, 4])
@pytest.mark.parametrize("seed", range(3))
def test_a_bin_in_its_place_is_no_news(cell, parts, seed):
    scan, truth = scanned(cell, parts, seed=seed)
    check = check_bin(scan, cell.bin)
    assert not (check.is_elsewhere or check.is_empty)
    assert error(check, truth)[0] < 0.5
    assert 0.01 < check.fill < 0.3
    assert not is_too_full(check)
    if check.above < 0.01:
        assert check.light == "good" and check.findings == ()
        assert "is where it should be" in str(check.says)


def test_a_part_that_stands_above_the_rim_makes_no_bin_too_full(cell):
    check = check_bin(scanned(cell, 4, seed=1)[0], cell.bin)
    assert check.fill < 0.2 and not is_too_full(check)
    assert (
        list(map(str, check.findings)) == ["a part stands 30 mm above the rim"]
        and check.light == "warning"
    )


def test_an_empty_bin_is_told(cell):
    check = check_bin(scanned(cell)[0], cell.bin)
    assert check.is_empty and check.fill < 0.01
    assert list(map(str, check.findings)) == ["nothing higher than 1.0 mm lies on the floor"]
    assert check.light == "warning"


def test_flat_parts_on_the_floor_are_seen_to_lie_there(cell):
    ring = trimesh.creation.annulus(0.0032, 0.00625, 0.0016)
    washer = replace(cell.parts[0], name="washer", mesh=Mesh(ring.vertices, ring.faces))
    with_washers = replace(cell, parts=(washer,))
    lying = tuple(
        Detection("washer", cell.bin.T_world_bin * pose_from_rpy((x, y, 0.0008)), 1.0, 1.0)
        for x in (-0.05, 0.0, 0.05)
        for y in (-0.03, 0.04)
    )
    check = check_bin(synthesize(with_washers, lying, seed=0), cell.bin)
    assert not check.is_empty
    assert list(map(str, check.findings)) == ["only things lower than 4 mm lie on the floor"]


def test_a_floor_that_is_not_where_the_rim_is_is_told_and_the_bin_empty_all_the_same(cell):
    scan = scanned(cell)[0]
    higher = np.array(scan.points_world - cell.bin.T_world_bin.translation)
    on_floor = (np.abs(higher[:, :2]) < cell.bin.size[:2] / 2).all(axis=1) & (higher[:, 2] < 0.01)
    raised = np.array(scan.points)
    raised[on_floor] *= 1 - 0.005 / raised[on_floor, 2:]
    check = check_bin(Scan(raised, scan.T_world_scanner, "raised"), cell.bin)
    assert check.is_empty and not check.is_elsewhere
    assert any("the floor of the bin lies 5.0 mm higher" in str(one) for one in check.findings)


def test_one_part_is_not_empty(cell):
    assert not check_bin(scanned(cell, 1)[0], cell.bin).is_empty


@pytest.mark.extensive
@pytest.mark.parametrize("seed", [0])
def test_an_overfull_bin_is_told_and_not_taken_for_a_moved_one(cell, seed):
    check = check_bin(scanned(cell, 20, seed=seed)[0], cell.bin)
    assert is_too_full(check) and check.above > 0.01
    assert not check.is_elsewhere, check.says
    assert str(check.findings[0]).startswith("the bin is too full: parts lie ")
    more, less = check, check_bin(scanned(cell, 2, seed=seed)[0], cell.bin)
    assert (more.fill or 1.0) > 2 * less.fill


def test_a_bin_that_is_not_there_is_told(cell):
    gone = replace(cell.bin, T_world_bin=pose_from_rpy((0.41, 0, -0.5)))
    scan = synthesize(replace(cell, bin=gone), (), seed=0)
    check = check_bin(scan, cell.bin)
    assert check.T_world_bin is None and check.light == "bad"
    assert "is the bin there, and are its size_mm" in str(check.says)


@pytest.mark.parametrize("count", [1, 5, 200])
def test_a_few_points_say_nothing(cell, count):
    points = np.random.default_rng(0).uniform(-1, 1, (count, 3))
    check = check_bin(Scan(points, cell.scanner.T_world_scanner, "few"), cell.bin)
    assert check.T_world_bin is None and check.fill is None


def test_the_same_scan_gives_the_same_words(cell):
    scan = scanned(cell, 2, (10, 0, 0))[0]
    assert check_bin(scan, cell.bin).says == check_bin(scan, cell.bin).says


def table(cell):
    return replace(cell, bin=replace(cell.bin, has_walls=False))


def test_a_surface_is_as_high_as_it_should_be_and_how_much_lies_on_it_is_told(cell):
    scan, _ = scanned(table(cell), 1, seed=1)
    check = check_bin(scan, table(cell).bin)
    assert check.light == "good", check.says
    assert 0.01 < check.fill < 0.3
    assert str(check.says).startswith("parts lie as high as they should, within 0.")


@pytest.mark.parametrize(("up", "word"), [(5, "+5.0 mm"), (-4, "-4.0 mm")])
def test_a_surface_at_another_height_is_measured(cell, up, word):
    scan, truth = scanned(table(cell), 3, (0, 0, up), (0.5, 0, 0), seed=1)
    check = check_bin(scan, table(cell).bin)
    assert check.is_elsewhere and check.light == "warning" and word in str(check.says)
    distance, angle = error(check, truth)
    assert distance < 0.5 and angle < 0.1


def test_a_surface_that_is_not_there_is_bad_news(cell):
    scan, _ = scanned(replace(table(cell), fixtures=()), 0, (0, 0, -40))
    check = check_bin(scan, table(cell).bin)
    assert check.light == "bad" and check.T_world_bin is None
    assert "no surface for the parts within" in str(check.says)


def test_a_surface_on_which_nothing_lies_is_told(cell):
    check = check_bin(scanned(table(cell))[0], table(cell).bin)
    assert check.is_empty and list(map(str, check.findings)) == [
        "nothing higher than 1.0 mm lies on the floor"
    ]
