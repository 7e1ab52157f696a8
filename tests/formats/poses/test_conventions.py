"""Poses as pendants show them: read, written, and refused."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from workbench.formats.poses.conventions import CONVENTIONS, convention
from workbench.model.errors import InputError

SEQUENCES = {
    "denso": "xyz",
    "fanuc": "xyz",
    "kawasaki": "ZYZ",
    "kuka": "ZYX",
    "mitsubishi": "xyz",
    "staubli": "XYZ",
    "yaskawa": "xyz",
}
"""SciPy's words: small letters about fixed axes, capitals about turned ones."""


def random_poses(count, seed):
    draw = np.random.default_rng(seed)
    turns = Rotation.random(count, rng=seed).as_matrix()
    return [pin.SE3(R, draw.uniform(-2, 2, 3)) for R in turns]


@pytest.mark.parametrize("name", CONVENTIONS)
def test_what_is_shown_is_read_as_the_same_pose(name):
    written = convention(name)
    for T in random_poses(200, seed=5):
        numbers = written.show(T)
        assert len(numbers) == len(written.names)
        assert np.allclose(written.pose(numbers).homogeneous, T.homogeneous, atol=1e-9)


@pytest.mark.parametrize("name", SEQUENCES)
def test_angles_turn_in_the_order_of_their_maker(name):
    sequence = SEQUENCES[name]
    for degrees in np.random.default_rng(6).uniform(-180, 180, (50, 3)):
        T = convention(name).pose((100, 200, 300, *degrees))
        wanted = Rotation.from_euler(sequence, degrees, degrees=True).as_matrix()
        assert np.allclose(T.rotation, wanted, atol=1e-12)
        assert np.allclose(T.translation, (0.1, 0.2, 0.3))


def test_quaternions_begin_with_the_real_part_and_rotation_vectors_are_in_radians():
    turned = convention("abb").pose((0, 0, 0, np.sqrt(0.5), 0, 0, np.sqrt(0.5)))
    same = convention("ur").pose((0, 0, 0, 0, 0, np.pi / 2))
    assert np.allclose(turned.rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert np.allclose(turned.rotation, same.rotation)


@pytest.mark.parametrize("name", CONVENTIONS)
@pytest.mark.parametrize("degrees", [(0, 90, 0), (30, 90, 40), (30, -90, 40), (20, 180, 0)])
@pytest.mark.parametrize("sequence", ["ZYX", "ZYZ", "XYZ"])
def test_poles_lose_no_turn(name, degrees, sequence):
    R = Rotation.from_euler(sequence, degrees, degrees=True).as_matrix()
    written = convention(name)
    T = written.pose(written.show(pin.SE3(R, np.zeros(3))))
    assert np.allclose(T.rotation, R, atol=1e-7)


@pytest.mark.parametrize(
    ("name", "numbers", "says"),
    [
        ("kuka", (1, 2, 3, 4, 5), "a pose as KUKA shows it has the 6 numbers X [mm]"),
        ("fanuc", (1, 2, 3, 4, 5, float("nan")), "a pose as FANUC shows it has the 6 numbers"),
        ("abb", (1, 2, 3, 0, 0, 0, 0), "the quaternion 0, 0, 0, 0 has the length 0.000"),
        ("abb", (1, 2, 3, 1, 1, 0, 0), "has the length 1.414"),
    ],
)
def test_numbers_that_are_no_pose_are_refused(name, numbers, says):
    with pytest.raises(InputError) as refused:
        convention(name).pose(numbers)
    assert says in str(refused.value)


def test_a_maker_that_is_not_known_is_named():
    with pytest.raises(InputError, match="the pose format 'delta' is not one of abb, denso"):
        convention("delta")
