"""The canonical form and the digest made from it."""

import hashlib
import json
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.formats.cells.reading import read_cell
from workbench.model.digest import LARGE, canonical, digest_of
from workbench.model.geometry import Capsule, Cylinder, Mesh


@dataclass(frozen=True)
class Sample:
    number: float
    name: str
    digest: str = "not part of it"


def test_the_digest_is_sha256_over_canonical_json():
    text = '{"name":"a","number":0.5}'
    assert digest_of(Sample(0.5, "a")) == hashlib.sha256(text.encode()).hexdigest()


def test_a_round_trip_through_json_keeps_the_digest():
    value = {"q": np.linspace(0, 1, 7), "T": pin.SE3.Random(), "names": ("a", "b"), "none": None}
    assert digest_of(json.loads(json.dumps(canonical(value)))) == digest_of(value)


@given(st.floats(allow_nan=False), st.floats(allow_nan=False))
def test_different_numbers_have_different_digests(a, b):
    assert (digest_of(Sample(a, "")) == digest_of(Sample(b, ""))) == (a == b)


def test_zero_has_no_sign():
    assert digest_of(np.array([0.0, -0.0])) == digest_of(np.array([0.0, 0.0]))
    assert digest_of(-0.0) == digest_of(0.0)


def test_large_arrays_enter_by_their_bytes():
    large = np.arange(LARGE + 1.0)
    assert set(canonical(large)) == {"shape", "type", "sha256"}
    changed = large.copy()
    changed[17] += 1e-9
    assert digest_of(changed) != digest_of(large)


def test_shapes_of_different_kinds_differ():
    assert digest_of(Cylinder(0.1, 0.2)) != digest_of(Capsule(0.1, 0.2))
    points, triangles = np.eye(3), np.array([[0, 1, 2]])
    assert digest_of(Mesh(points, triangles)) != digest_of(Mesh(points, triangles, is_convex=True))


def test_what_has_no_form_is_refused():
    with pytest.raises(TypeError, match="no canonical form for object"):
        canonical(object())


@pytest.mark.parametrize("of", [lambda cell: cell, lambda cell: cell.robot, lambda cell: cell.arms])
def test_a_text_that_is_made_once_is_the_canonical_json(of):
    value = of(read_cell("yumi"))
    text = json.dumps(
        canonical(value),
        sort_keys=True,
        separators=(",", ":"),
        ensure_ascii=False,
    )
    for _ in range(2):
        assert digest_of(value) == hashlib.sha256(text.encode()).hexdigest()


def test_a_cell_with_another_robot_has_another_digest():
    cell = read_cell("yumi")
    first, *others = cell.robot.joints
    robot = replace(cell.robot, joints=(replace(first, velocity=9.0), *others))
    changed = replace(cell, robot=robot)
    assert changed.digest != cell.digest
    assert replace(changed, robot=cell.robot).digest == cell.digest
    del robot, changed
    assert digest_of(replace(cell)) == digest_of(cell)
