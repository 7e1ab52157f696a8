"""Whether parts are as large as their CAD file: told by lengths, not by what blurs a scan."""

from dataclasses import replace

import pytest
from searching import searched

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh
from workbench.model.scan import ScaleCheck
from workbench.perception.localization.cad_scale import scale_check
from workbench.perception.matching.maps import make_map
from workbench.perception.parts.part_surface import prepare
from workbench.perception.parts.sizing import sized
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.noise_models import NOISE_MODELS
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import compare

TOLERANCE = 0.0015


@pytest.fixture(scope="module")
def bracket():
    return read_part("bracket")


@pytest.fixture(scope="module")
def truth(cell, bracket):
    return drop_parts((bracket,) * 5, cell.bin, seed=100)


def told(cell, part, truth, factor, noise, count=None):
    """By the true poses, so that the CAD file's size is all that is wrong."""
    seen = replace(cell, parts=(part,))
    scan = synthesize(seen, truth, seed=1, noise=noise)
    large = replace(part, mesh=Mesh(part.mesh.points * factor, part.mesh.triangles))
    surface = prepare(large)
    depth_map = make_map(
        scan, cell.bin, scene_model(scan, seen).bin, size=surface.diameter,
        pitch=surface.diameter / 70,
    )  # fmt: skip
    assert depth_map is not None
    poses = [scan.T_world_scanner.actInv(one.T_world_part).homogeneous for one in truth[:count]]
    return scale_check(part.name, depth_map, surface, poses, TOLERANCE)


@pytest.mark.parametrize("noise", ["fine", "rough"])
@pytest.mark.parametrize("factor", [0.97, 0.99, 1.0, 1.01, 1.03])
def test_a_size_is_told_to_a_few_tenths_of_a_percent(cell, bracket, truth, factor, noise):
    check = told(cell, bracket, truth, factor, NOISE_MODELS[noise])
    assert check is not None
    assert check.ratio == pytest.approx(1 / factor, abs=0.003)
    assert check.deviation < 0.0033
    assert check.is_off == (factor != 1.0)


@pytest.mark.parametrize("build", ["structured_light", "stereo", "time_of_flight"])
def test_scanners_that_average_and_fatten_do_not_make_parts_larger(cell, bracket, truth, build):
    for part, lying in (
        (bracket, truth),
        (cell.parts[0], drop_parts((cell.parts[0],) * 4, cell.bin, seed=101)),
    ):
        check = told(cell, part, lying, 1.0, NOISE_MODELS[build])
        assert check is None or not check.is_off


def test_a_scan_without_any_noise_tells_it_too(cell, bracket, truth):
    exact = replace(NOISE_MODELS["fine"], drop_outs=0.0, outliers=0.0, flying=0.0)
    still = replace(cell, scanner=replace(cell.scanner, depth_noise=0.0))
    check = told(still, bracket, truth, 1.01, exact)
    assert check is not None and check.ratio == pytest.approx(1 / 1.01, abs=0.001)


@pytest.mark.parametrize(
    ("name", "factor"), [("bolt", 0.95), ("keyed_cylinder", 1.05), ("bracket", 0.97)]
)
def test_poses_are_those_of_the_part_though_its_cad_file_is_wrong(cell, name, factor):
    lying = read_part(name)
    truth = drop_parts((lying,) * 6, cell.bin, seed=103)
    scan = synthesize(replace(cell, parts=(lying,)), truth, seed=103)
    wrong = sized(lying, factor, about_middle=True)
    found = searched(scan, wrong, replace(cell, parts=(wrong,)), seed=103)
    (check,) = found.scales
    assert check.is_off and check.ratio == pytest.approx(1 / factor, abs=0.01)
    judged, _ = compare((wrong,), truth, found.detections)
    assert len(judged) >= 4
    assert all(one.distance is not None and one.distance < 0.001 for one in judged)


def test_two_parts_are_not_enough(cell, bracket, truth):
    assert told(cell, bracket, truth, 1.0, NOISE_MODELS["fine"], count=2) is None


def test_nothing_is_told_where_nothing_is_seen(cell, bracket, truth):
    far = [replace(one, T_world_part=cell.scanner.T_world_scanner) for one in truth]
    assert scale_at(cell, bracket, truth, far) is None


def scale_at(cell, part, truth, poses):
    seen = replace(cell, parts=(part,))
    scan = synthesize(seen, truth, seed=1)
    surface = prepare(part)
    depth_map = make_map(scan, cell.bin, scene_model(scan, seen).bin, size=0.1, pitch=0.001)
    assert depth_map is not None
    T = scan.T_world_scanner.inverse()
    return scale_check(
        part.name,
        depth_map,
        surface,
        [(T * one.T_world_part).homogeneous for one in poses],
        TOLERANCE,
    )


def test_it_is_said_which_way_and_by_how_much():
    large = ScaleCheck("bolt", 0.97, 0.002, 4)
    assert str(large.words) == "the CAD file of bolt seems 3.1% too large for the scan"
    assert "2.9% too small" in str(ScaleCheck("bolt", 1.03, 0.002, 4).words)
    # Less than half a percent, or than three deviations, is no difference.
    assert ScaleCheck("bolt", 1.0049, 0.0001, 4).words is None
    assert ScaleCheck("bolt", 1.03, 0.011, 4).words is None
