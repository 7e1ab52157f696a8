"""BOP's average precision, against values worked out by hand from its definitions."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.matching.pose_error import mssd as mssd_of_part
from workbench.studies.bop.pose_errors import Shape, mspd, mssd, pose_errors, shape_of
from workbench.studies.bop.precision import (
    THRESHOLDS,
    Estimate,
    Judged,
    average_precision,
    detection_figures,
)

CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05
"""[m] Corners of a cube of 100 mm."""

K = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])

T = pose_from_rpy((0, 0, 1.0))


def cube(*motions: pin.SE3) -> Shape:
    return Shape(CUBE, np.array([np.eye(4), *(M.homogeneous for M in motions)]), 0.1 * np.sqrt(3))


def quarter(k: int) -> pin.SE3:
    return pose_from_rpy((0, 0, 0), (0, 0, k * np.pi / 2))


def test_a_shift_moves_every_vertex_by_itself():
    moved = T * pose_from_rpy((0.003, 0.004, 0))
    assert mssd(cube(), T, moved) == pytest.approx(0.005)
    # The nearest corners are 0.95 m away: 500 px / 0.95 m * 5 mm.
    assert mspd(cube(), T, moved, K) == pytest.approx(500 / 0.95 * 0.005)


def test_a_turn_counts_as_far_as_the_farthest_vertex_moves_unless_it_is_a_symmetry():
    turned = T * quarter(1)
    assert mssd(cube(), T, turned) == pytest.approx(0.1)
    assert mspd(cube(), T, turned, K) == pytest.approx(500 / 0.95 * 0.1)
    for shape in (cube(*map(quarter, (1, 2, 3))), cube(quarter(1))):
        assert mssd(shape, T, turned) == pytest.approx(0, abs=1e-12)
    assert mspd(cube(quarter(1)), T, turned, K) == pytest.approx(0, abs=1e-9)


def test_a_symmetry_about_a_place_that_is_not_the_origin():
    # A half turn about an axis through (30, 0, 0) mm: whoever is there has it 60 mm aside.
    M = pin.SE3(np.diag([-1.0, -1, 1]), np.array([0.06, 0, 0]))
    assert mssd(cube(M), T, T * M) == pytest.approx(0, abs=1e-12)
    assert mssd(cube(), T, T * M) == pytest.approx(np.hypot(0.16, 0.1))


@pytest.mark.parametrize("seed", range(3))
def test_leaving_motions_out_changes_nothing(seed):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(60, 3)) * 0.03
    motions = Symmetry(fold=0, also=(SymmetryAxis(np.array([1.0, 0, 0]), 2),)).motions(315)
    found = T * pose_from_rpy(generator.normal(size=3) * 0.01, generator.normal(size=3))
    Ts = [T.homogeneous @ M for M in motions]
    seen = found.homogeneous
    plain = min(
        np.linalg.norm(
            (points @ A[:3, :3].T + A[:3, 3]) - (points @ seen[:3, :3].T + seen[:3, 3]), axis=1
        ).max()
        for A in Ts
    )
    assert mssd(Shape(points, motions, 0.1), T, found) == pytest.approx(plain, abs=1e-12)


@pytest.mark.parametrize("name", ["bolt", "bracket", "keyed_cylinder"])
def test_a_part_is_measured_as_the_study_measures_it(name):
    part = read_part(name)
    found = T * pose_from_rpy((0.001, 0.002, 0), (0.02, 0.3, 0.1))
    assert mssd(shape_of(part), T, found) == pytest.approx(mssd_of_part(part, T, found))


def test_of_a_ball_no_turn_counts():
    axes = (SymmetryAxis(np.array([1.0, 0, 0]), 0),)
    round_one = replace(read_part("bolt"), symmetry=Symmetry(fold=0, also=axes))
    turned = T * pose_from_rpy((0, 0, 0.002), (1, 2, 3))
    assert mssd(shape_of(round_one), T, turned) == pytest.approx(0.002)


def test_errors_are_brought_to_the_diameter_and_to_640_pixels():
    moved = T * pose_from_rpy((0.01, 0, 0))
    share, surface, pixels = pose_errors(cube(), T, moved, K, 1280)
    assert (share, surface) == (pytest.approx(0.1 / np.sqrt(3)), pytest.approx(0.01))
    assert pixels == pytest.approx(500 / 0.95 * 0.01 / 2)


def test_thresholds_are_those_of_bop_2024():
    assert THRESHOLDS["mssd"] == pytest.approx([k / 20 for k in range(1, 11)])
    assert THRESHOLDS["mssd_mm"] == pytest.approx([k / 1000 for k in range(2, 21, 2)])
    assert THRESHOLDS["mspd"] == pytest.approx(range(5, 51, 5))


def test_precision_is_averaged_over_a_hundred_and_one_recalls():
    # Two of three found at first, a wrong one, the third: precision 1, 1, 2/3, 3/4.  Recalls
    # 0 .. 0.66 (67 of them) have precision 1, 0.67 .. 1 (34) the best that comes later, 3/4.
    ap = average_precision([0.9, 0.8, 0.7, 0.6], [True, True, False, True], 3)
    assert ap == pytest.approx((67 + 34 * 0.75) / 101)
    assert average_precision([0.5], [True], 2) == pytest.approx(51 / 101)
    assert average_precision([0.5, 0.9], [True, False], 1) == pytest.approx(0.5)
    assert average_precision([], [], 2) == 0.0


def estimate(score, *errors, object="a"):
    share = tuple(None if e is None else e / 0.1 for e in errors)
    pixels = tuple(None if e is None else e * 1000 for e in errors)
    return Estimate(object, score, {"mssd": share, "mssd_mm": errors, "mspd": pixels})


def test_figures_are_means_over_thresholds_and_then_over_objects():
    # Object a, 100 mm large: one found 11 mm off, right for thresholds from 0.15 (8 of 10), 12 mm
    # (5 of 10) and 15 px (8 of 10).  Object b: not found.
    image = Judged((estimate(0.9, 0.011, None),), (("a", 1.0), ("b", 1.0)))
    figures = detection_figures([image])
    assert figures["objects"]["a"]["mssd"] == pytest.approx(0.8)
    assert figures["objects"]["a"]["mssd_mm"] == pytest.approx(0.5)
    assert figures["objects"]["b"] == {"targets": 1, "mssd": 0, "mssd_mm": 0, "mspd": 0}
    assert figures["mssd"] == pytest.approx(0.4)
    assert figures["bop24"] == pytest.approx(0.4)


def test_an_object_is_found_once_and_by_the_best_that_is_near_enough():
    # Both lie near the first true object; the better one takes it, the other is wrong.
    twice = Judged(
        (estimate(0.8, 0.001, 0.5), estimate(0.9, 0.0015, 0.5)), (("a", 1.0), ("a", 1.0))
    )
    # One of two is found at precision 1, and what comes after adds nothing.
    assert detection_figures([twice])["mssd"] == pytest.approx(51 / 101)
    # The worse one is tried first where it has the higher score: then the nearest is taken.
    nearest = Judged((estimate(0.9, 0.002, 0.001), estimate(0.8, 0.002, None)), (("a", 1.0),) * 2)
    assert detection_figures([nearest])["mssd"] == pytest.approx(1.0)


def test_an_error_as_large_as_the_threshold_is_too_large():
    image = Judged((Estimate("a", 1.0, {"mspd": (50.0,)}),), (("a", 1.0),))
    figures = detection_figures([image])
    assert (figures["mspd"], figures["mssd"], figures["bop24"]) == (0.0, None, None)


def test_what_is_hardly_visible_is_neither_missed_nor_wrongly_found():
    seen = Judged((estimate(0.9, 0.001, 0.5),), (("a", 1.0), ("a", 0.09)))
    assert detection_figures([seen])["objects"]["a"] | {"mssd": 1.0} == {
        "targets": 1, "mssd": 1.0, "mssd_mm": 1.0, "mspd": 1.0,
    }  # fmt: skip
    found = Judged((estimate(0.95, 0.5, 0.001), estimate(0.9, 0.001, 0.5)), seen.truth)
    assert detection_figures([found])["mssd"] == pytest.approx(1.0)


def test_images_are_one_after_another_and_scores_go_over_all_of_them():
    right = Judged((estimate(0.5, 0.0),), (("a", 1.0),))
    wrong = Judged((estimate(0.9, object="a"),), ())
    assert detection_figures([right, wrong])["mssd"] == pytest.approx(0.5)


def test_no_more_than_a_hundred_estimates_of_an_image_count():
    many = tuple(estimate(1.0, 0.5) for _ in range(100))
    image = Judged((*many, estimate(0.5, 0.0)), (("a", 1.0),))
    assert detection_figures([image])["mssd"] == 0.0
    image = Judged((*many[1:], estimate(0.5, 0.0)), (("a", 1.0),))
    assert detection_figures([image])["mssd"] == pytest.approx(0.01)


def test_where_nothing_is_to_be_found_there_are_no_figures():
    figures = detection_figures([Judged((estimate(0.9, object="a"),), (("a", 0.05),))])
    assert (figures["mssd"], figures["bop24"], figures["objects"]) == (None, None, {})
