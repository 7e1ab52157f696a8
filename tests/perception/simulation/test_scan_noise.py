"""What is wrong with a simulated scan: shadows, drop-outs, outliers, flying pixels, range noise."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.simulation.image_errors import sheared
from workbench.perception.simulation.noise_models import (
    FINE_SCANNER,
    NOISE_MODELS,
    ROUGH,
    NoiseModel,
)
from workbench.perception.simulation.scan_noise import noisy
from workbench.perception.simulation.synthesize import synthesize, visible_shares

PERFECT = NoiseModel(
    baseline=0.0, grazing=0.01, fading=0.02, drop_outs=0.0, outliers=0.0, stray=0.0, flying=0.0
)


def picture(scan) -> np.ndarray:
    """Depths (rows, columns) [m], NaN where nothing was measured."""
    columns, rows = scan.resolution
    depth = np.full(rows * columns, np.nan)
    depth[scan.pixels] = scan.points[:, 2]
    return depth.reshape(rows, columns)


@pytest.fixture(scope="module")
def upright(cell, part):
    """A part standing in the middle of the bin."""
    return Detection(part.name, cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.04)))


def test_where_the_projector_is_blocked_nothing_is_measured(cell, upright):
    """The shadow lies on the side away from the projector, as wide as the heights demand."""
    quiet = replace(cell, scanner=replace(cell.scanner, depth_noise=0.0))
    lit = picture(synthesize(quiet, (upright,), seed=0, noise=PERFECT))
    aside = replace(PERFECT, baseline=0.2)
    dark = np.isnan(picture(synthesize(quiet, (upright,), seed=0, noise=aside)))
    rows, columns = lit.shape
    middle = slice(rows // 2 - 5, rows // 2 + 5)
    high = np.flatnonzero((lit[middle] < 0.83).all(axis=0))
    left, right = high.min(), high.max()
    floor = np.nanmax(lit[middle])
    # By similar triangles: what stands h above the floor shades h b / (z - h) of it.
    height = floor - np.nanmin(lit[middle])
    focal = columns / 2 / np.tan(cell.scanner.field_of_view / 2)
    wide = height * 0.2 / (floor - height) * focal / floor
    shadow = dark[middle][:, left - int(1.5 * wide) : left].mean(axis=0)
    assert 0.6 * wide < shadow.sum() < 1.4 * wide
    assert dark[middle][:, right + 6 : right + 30].mean() < 0.02
    assert np.isfinite(lit[middle]).mean() > 0.99


def test_without_a_baseline_there_is_no_shadow(cell, upright):
    scan = synthesize(cell, (upright,), seed=0, noise=PERFECT)
    assert np.isfinite(picture(scan)[100:380, 100:540]).mean() > 0.99


def test_noise_grows_with_distance_and_angle():
    depth = np.repeat([[0.6], [1.2]], 40_000, axis=1)
    for cosine, factor in ((1.0, 1.0), (0.5, 2.0)):
        off = noisy(depth, np.full_like(depth, cosine), 0.001, PERFECT, np.random.default_rng(0))
        near, far = (off - depth).std(axis=1)
        assert near == pytest.approx(0.001 * 0.36 * factor, rel=0.03)
        assert far == pytest.approx(0.001 * 1.44 * factor, rel=0.03)


def test_flying_pixels_lie_between_the_two_sides_of_an_edge():
    depth = np.full((50, 60), 0.9)
    depth[:, 30:] = 0.8
    flying = replace(PERFECT, flying=1.0)
    made = noisy(depth, np.ones_like(depth), 0.0, flying, np.random.default_rng(0))
    between = (made > 0.8) & (made < 0.9)
    assert between[:, 29:31].mean() > 0.99
    assert not between[:, :29].any() and not between[:, 31:].any()


def test_grazing_and_dark_surfaces_drop_out():
    depth, cosine = np.full((4, 10_000), 0.9), np.repeat([[1.0], [0.5], [0.35], [0.0]], 10_000, 1)
    measured = np.isfinite(noisy(depth, cosine, 0.0003, ROUGH, np.random.default_rng(1)))
    head_on, slanted, grazing, dark = measured.mean(axis=1)
    assert head_on == pytest.approx(1 - ROUGH.drop_outs, abs=0.01)
    assert head_on > slanted > grazing > dark == 0.0


def test_the_rough_build_has_more_wrong_with_it(cell, upright):
    def stray(noise: NoiseModel) -> float:
        scan = synthesize(cell, (), seed=0, noise=noise)
        return float(np.mean(np.abs(scan.points[:, 2] - np.median(scan.points[:, 2])) > 0.02))

    assert stray(ROUGH) > stray(FINE_SCANNER) > 0.0


def of(depth, **errors):
    """What a scanner without noise that has these errors measures of depths, met head-on."""
    model = replace(PERFECT, **errors)
    return noisy(depth, np.ones_like(depth), 0.0, model, np.random.default_rng(0))


@pytest.fixture
def edge():
    """A step of 4 mm in the middle."""
    depth = np.full((40, 60), 0.9)
    depth[:, 30:] = 0.896
    return depth


def test_low_edges_are_smoothed_and_high_ones_are_not(edge):
    made = of(edge, blur=1.5, bridged=0.006)
    assert 0.897 < made[20, 29] < 0.8995
    assert np.abs(made - edge)[:, :26].max() < 1e-9
    high = np.where(edge < 0.9, 0.8, 0.9)
    assert np.abs(of(high, blur=1.5, bridged=0.006) - high).max() < 1e-9


def test_what_is_smoothed_shares_its_noise_with_what_is_beside():
    flat = np.full((80, 80), 1.0)
    square = np.ones_like(flat)
    model = replace(PERFECT, blur=1.5, bridged=0.02)
    made = noisy(flat, square, 0.001, model, np.random.default_rng(0)) - 1.0
    assert np.corrcoef(made[:, :-1].ravel(), made[:, 1:].ravel())[0, 1] > 0.7
    assert 0.0001 < made.std() < 0.0004


def test_near_things_are_fattened(edge):
    high = np.where(edge < 0.9, 0.88, 0.9)
    assert (of(high, fattened=2)[:, 28:30] == 0.88).all()
    assert (of(high, fattened=2)[:, :28] == 0.9).all()


def test_slopes_are_not_fattened():
    """At 60 degrees, with pixels of 1.3 mm."""
    slope = np.tile(0.9 - 0.00225 * np.arange(60), (40, 1))
    assert of(slope, fattened=1) == pytest.approx(slope, abs=1e-12)


def test_depths_come_in_steps_of_the_disparity():
    made = of(np.linspace(0.8, 0.9, 400)[None], step=0.002)
    steps = np.unique(np.round(1.0 / made, 9))
    assert len(steps) == pytest.approx((1 / 0.8 - 1 / 0.9) / 0.002, abs=1)
    assert np.diff(steps) == pytest.approx(0.002, rel=1e-6)


def test_fringes_leave_a_wave_as_high_as_stated():
    off = of(np.linspace(0.99, 1.01, 400)[None], wave=0.0002, fringe=0.01) - np.linspace(
        0.99, 1.01, 400
    )
    assert off.max() == pytest.approx(0.0002, rel=0.05)
    assert off.min() == pytest.approx(-0.0002, rel=0.05)


def test_concave_corners_are_measured_too_deep():
    slope = np.abs(np.arange(-30.0, 31.0)) * 0.001
    depth = np.tile(0.9 - slope, (40, 1))
    off = of(depth, corners=0.1) - depth
    assert off[20, 30] > 0.0001
    assert np.abs(off[20, 15:20]).max() < 1e-9


def test_what_moves_while_it_is_measured_is_sheared():
    depth = np.full((31, 60), 0.9)
    depth[:, 20:30] = 0.8
    edges = (of(depth, drifted=3.0) == 0.8).argmax(axis=1)
    assert edges[0] == 20
    assert edges[-1] == 23
    assert (np.diff(edges) >= 0).all()


def test_gloss_is_a_hole_and_stripes_are_missing():
    depth, cosine = np.full((200, 50), 0.9), np.full((200, 50), 0.999)
    glossy = replace(PERFECT, gloss=0.995, glare=1.0)
    assert np.isnan(noisy(depth, cosine, 0.0, glossy, np.random.default_rng(0))).all()
    dull = noisy(depth, 0.99 * cosine, 0.0, glossy, np.random.default_rng(0))
    assert np.isfinite(dull).all()
    lost = np.isnan(of(depth, torn=0.1))
    assert (lost.all(axis=1) == lost.any(axis=1)).all()
    assert 8 <= lost.all(axis=1).sum() <= 35


def test_a_cell_names_the_build_of_its_simulated_scanner(cell, upright):
    scanner = replace(cell.scanner, options={"like": "stereo"})
    stereo = synthesize(replace(cell, scanner=scanner), (upright,), seed=0)
    named = synthesize(cell, (upright,), seed=0, noise=NOISE_MODELS["stereo"])
    assert stereo.digest == named.digest != synthesize(cell, (upright,), seed=0).digest


@pytest.mark.extensive
@pytest.mark.parametrize("name", NOISE_MODELS)
def test_the_same_seed_gives_the_same_scan(cell, upright, name):
    noise = NOISE_MODELS[name]
    first, again, other = (
        synthesize(cell, (upright,), seed=seed, noise=noise).digest for seed in (3, 3, 4)
    )
    assert first == again != other


@given(st.integers(0, 2**31), st.sampled_from(sorted(NOISE_MODELS)))
@settings(max_examples=20, deadline=None)
def test_measured_depths_are_finite_or_missing(seed, name):
    generator = np.random.default_rng(seed)
    depth = generator.uniform(0.5, 1.2, (20, 30))
    depth[generator.random(depth.shape) < 0.3] = np.inf
    cosine = generator.random(depth.shape)
    made = noisy(depth, cosine, 0.0005, NOISE_MODELS[name], generator)
    assert not np.isinf(made).any()
    assert np.isnan(made[np.isinf(sheared(depth, NOISE_MODELS[name].drifted))]).all()


def test_a_part_under_another_is_seen_in_part(cell, part):
    low, across = (
        Detection(part.name, cell.bin.T_world_bin * T)
        for T in (
            pose_from_rpy((0, 0, 0.015), (0, np.pi / 2, 0)),
            pose_from_rpy((0, 0, 0.055), (np.pi / 2, 0, 0)),
        )
    )
    below, above = visible_shares(cell, (low, across))
    assert above > 0.99
    assert 0.4 < below < 0.8
    assert visible_shares(cell, (low,))[0] > 0.99


@pytest.mark.parametrize(
    ("name", "left"), [("structured_light", 0.36), ("stereo", 0.18), ("time_of_flight", 0.29)]
)
def test_averaging_leaves_less_of_a_pixels_noise_as_the_documents_say(name, left):
    averaging = replace(PERFECT, blur=NOISE_MODELS[name].blur, bridged=NOISE_MODELS[name].bridged)
    depth = np.ones((200, 200))
    for deviation in (0.0003, 0.0012):
        off = noisy(depth, depth, deviation, averaging, np.random.default_rng(0)) - depth
        assert off[8:-8, 8:-8].std() == pytest.approx(left * deviation, rel=0.03)
