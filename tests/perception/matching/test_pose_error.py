"""Errors under symmetry, against the definitions of the BOP benchmark, written down anew."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.matching.pose_error import mssd, pose_error

X, Y, Z = np.eye(3)
TUBE = Symmetry(fold=0, point=(0.0, 0.0, 0.03), also=(SymmetryAxis(X, 2),))
CROSS = Symmetry(fold=4, also=(SymmetryAxis(X, 2),))
ELBOW = Symmetry(np.array([1.0, 1.0, 0.0]) / np.sqrt(2), 2, (0.01, -0.01, 0.005))
BALL = Symmetry(fold=0, point=(0.0, 0.02, 0.0), also=(SymmetryAxis(Y, 0),))


def part(symmetry: Symmetry):
    body = trimesh.creation.box((0.02, 0.03, 0.05)).subdivide()
    return replace(read_part("bracket"), mesh=Mesh(body.vertices, body.faces), symmetry=symmetry)


def bop_mssd(R_e, t_e, R_g, t_g, points, discrete, continuous):
    """`get_symmetry_transformations` and `mssd` of bop_toolkit, in one."""
    motions = [(np.eye(3), np.zeros(3)), *discrete]
    steps = int(np.ceil(np.pi / 0.01))
    turned = []
    for axis, offset in continuous:
        for i in range(steps):
            angle = 2.0 * np.pi / steps * i
            K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
            R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
            turned.append((R, -R @ offset + offset))
    both = (
        [(Rc @ Rd, Rc @ td + tc) for Rc, tc in turned for Rd, td in motions] if turned else motions
    )
    estimated = R_e @ points.T + t_e[:, None]
    errors = []
    for R, t in both:
        true = (R_g @ R) @ points.T + (R_g @ t + t_g)[:, None]
        errors.append(np.linalg.norm(estimated - true, axis=0).max())
    return min(errors)


def half_turn(axis, point):
    R = 2 * np.outer(axis, axis) - np.eye(3)
    return R, point - R @ point


CASES = {
    "tube": (TUBE, [half_turn(X, np.array(TUBE.point))], [(Z, np.array(TUBE.point))]),
    "cross": (
        CROSS,
        [
            (R, np.zeros(3))
            for R in (
                np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
                np.diag([-1, -1, 1]),
                np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
                np.diag([1, -1, -1]),
                np.diag([-1, 1, -1]),
                np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
                np.array([[0, -1, 0], [-1, 0, 0], [0, 0, -1]]),
            )
        ],
        [],
    ),
    "elbow": (ELBOW, [half_turn(np.array(ELBOW.axis), np.array(ELBOW.point))], []),
}


@pytest.mark.parametrize("name", CASES)
def test_surface_distances_are_those_of_bop(name):
    symmetry, discrete, continuous = CASES[name]
    kind = part(symmetry)
    for seed in range(8):
        pin.seed(seed)
        T_true, T_off = pin.SE3.Random(), pin.exp6(0.01 * pin.Motion.Random())
        # Some are near a turn of the group, others anywhere.
        motions = symmetry.motions(7)
        turn = pin.SE3(motions[seed % len(motions)]) if seed % 2 else pin.SE3.Random()
        T_found = T_true * turn * T_off
        theirs = bop_mssd(
            T_found.rotation, T_found.translation, T_true.rotation, T_true.translation,
            kind.mesh.points, discrete, continuous,
        )  # fmt: skip
        assert mssd(kind, T_true, T_found) == pytest.approx(theirs, abs=1e-9)


@pytest.mark.parametrize(
    "symmetry", [TUBE, CROSS, ELBOW, BALL], ids=["tube", "cross", "elbow", "ball"]
)
def test_every_turn_of_the_group_is_no_error(symmetry):
    kind = part(symmetry)
    T_world_true = pin.SE3(pin.exp3(np.array([0.3, -1.0, 2.0])), np.array([1.0, -0.5, 0.2]))
    for M in symmetry.motions(23):
        distance, turn = pose_error(kind, T_world_true, T_world_true * pin.SE3(M))
        assert distance == pytest.approx(0.0, abs=1e-9) and turn == pytest.approx(0.0, abs=1e-6)
        if symmetry is not BALL and symmetry.form == "":
            assert mssd(kind, T_world_true, T_world_true * pin.SE3(M)) < 1e-9


def test_what_no_turn_explains_is_an_error():
    T = pin.SE3(np.eye(3), np.array([0.003, 0.0, 0.0]))
    for symmetry in (TUBE, CROSS, BALL):
        distance, _ = pose_error(part(symmetry), pin.SE3.Identity(), T)
        assert distance == pytest.approx(0.003)
    tilted = pin.SE3(pin.exp3(0.2 * Y), np.zeros(3))
    assert pose_error(part(TUBE), pin.SE3.Identity(), tilted)[1] == pytest.approx(0.2)
    assert pose_error(part(BALL), pin.SE3.Identity(), tilted)[1] == 0.0
    # About the wrong point a half turn moves the part.
    flip = pin.SE3(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
    assert pose_error(part(TUBE), pin.SE3.Identity(), flip)[0] == pytest.approx(0.06)


def test_an_unknown_roll_is_about_the_axis_that_the_scan_left_open():
    """A pulley whose set screws give it half a turn across its axis, which alone is stated."""
    kind = part(Symmetry(Y, 2))
    axis = np.array([np.zeros(3), X])
    roll = pin.SE3(pin.exp3(1.1 * X), np.zeros(3))
    flip = pin.SE3(pin.exp3(np.pi * Y), np.zeros(3))
    here = pin.SE3.Identity()
    for T in (roll, flip, roll * flip, flip * roll):
        for errors in (
            pose_error(kind, here, T, roll_known=False, roll_axis=axis),
            pose_error(part(Symmetry()), here, roll, roll_known=False, roll_axis=axis),
        ):
            assert errors == (pytest.approx(0.0, abs=1e-9), pytest.approx(0.0, abs=1e-9))
    assert pose_error(kind, here, roll)[1] == pytest.approx(1.1)
    assert pose_error(part(Symmetry()), here, flip, roll_known=False, roll_axis=axis)[1] > 3.0
    tilted = pin.SE3(pin.exp3(0.2 * Y), np.zeros(3))
    assert pose_error(kind, here, tilted, roll_known=False, roll_axis=axis)[1] == pytest.approx(0.2)
