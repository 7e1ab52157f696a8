"""The picture of a scan's points, on the plane z = 1."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from workbench.perception.scene import sensor
from workbench.perception.views.camera import are_within, picture_bounds

CLOUDS = arrays(np.float64, st.tuples(st.integers(1, 60), st.just(2)), elements=st.floats(-3, 3))


@given(CLOUDS)
def test_the_corners_hold_nearly_all_points_and_are_themselves_between(image):
    low, high = picture_bounds(image)
    inside = are_within(image, low, high)
    np.testing.assert_array_equal(inside, ((image >= low) & (image <= high)).all(axis=1))
    assert (image[inside].min(axis=0) >= low).all() and (image[inside].max(axis=0) <= high).all()
    assert are_within(np.array([low, high]), low, high).all()


def test_a_stray_point_makes_no_picture_endless():
    image = np.random.default_rng(0).uniform(-0.3, 0.3, (4000, 2))
    low, high = picture_bounds(np.vstack([image, [[900.0, -900.0]]]))
    np.testing.assert_array_equal([low, high], [image.min(axis=0), image.max(axis=0)])


def test_the_picture_of_a_scan_is_measured_once_for_all_windows(monkeypatch):
    measured = []

    def counted(image):
        measured.append(len(image))
        return picture_bounds(image)

    monkeypatch.setattr(sensor, "picture_bounds", counted)
    u, v = np.meshgrid(np.linspace(-0.2, 0.2, 300), np.linspace(-0.2, 0.2, 300))
    depth = 1.0 + np.random.default_rng(0).normal(0, 3e-4, u.shape)
    noise = sensor.sensor_model(np.stack([u * depth, v * depth, depth], axis=-1).reshape(-1, 3))
    assert measured == [300 * 300] and abs(noise.noise - 3e-4) < 3e-5
