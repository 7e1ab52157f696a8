"""Grips by physics against what is said before, on few grips."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.planning.kinematics.quickness import hand_acceleration
from workbench.studies.placing import (
    Case,
    Gripped,
    entry_of,
    grip_part,
    measure,
    measure_offsets,
    summary,
)

HERE = pin.SE3.Identity()


def one(grasp, chance, right, **counts):
    n = len(right)
    told = {"slipped": 0, "tipped": 0, "lost": 0, "missed": 0} | counts
    shifts, turns = np.linspace(0.0, 0.002, n), np.zeros(n)
    was = (True,) * n
    return Gripped(grasp, 0, chance, 0.001, 0.1, shifts, turns, right, was, **told)


def test_chances_are_compared_over_all_grips_and_by_grasp():
    told = summary(
        [
            one("side-1", 0.5, (True, False), slipped=1),
            one("side-1@60", 0.7, (True, True)),
            one("tip", 1.0, (True,) * 4, missed=2),
        ]
    )
    assert set(told["grasps"]) == {"side-1", "tip"}
    side = told["grasps"]["side-1"]
    assert (side["grips"], side["slipped"]) == (4, 1)
    assert side["predicted"] == pytest.approx(0.6) and side["measured"] == pytest.approx(0.75)
    assert side["difference"] == pytest.approx(-0.15)
    assert told["all"]["measured"] == pytest.approx(7 / 8)
    assert told["all"]["predicted"] == pytest.approx((0.5 * 2 + 0.7 * 2 + 4.0) / 8)
    assert told["all"]["missed"] == 2 and told["all"]["closed"] == 1.0
    assert told["all"]["within_shift"] == pytest.approx(0.5)
    assert summary([]) == {"all": {"grips": 0}, "grasps": {}}


def test_a_copy_by_symmetry_counts_with_its_entry():
    assert [entry_of(name) for name in ("tip", "tip@60", "side-1-2@180+1")] == [
        "tip",
        "tip",
        "side-1-2",
    ]


class _Counted:
    def off(self, errors):
        return np.linalg.norm(errors[:, :3], axis=1), np.linalg.norm(errors[:, 3:], axis=1)


class _Budget:
    counted = _Counted()


def test_the_error_in_the_hand_is_that_of_the_origin_and_the_turn():
    meant = pose_from_rpy((0.1, 0.2, 0.3), (0.3, -0.4, 2.0))
    moved = meant * pin.SE3(pin.exp3(np.array([0.0, 0.03, 0.0])), np.array([0.001, 0.0, 0.002]))
    shifts, turns = measure_offsets([moved, None, meant], meant, _Budget())
    assert shifts == pytest.approx([np.hypot(0.001, 0.002), np.inf, 0.0], abs=1e-9)
    assert turns == pytest.approx([0.03, np.inf, 0.0], abs=1e-9)


def test_the_hand_accelerates_as_the_strongest_joint_has_it():
    """A joint turns the hand about its axis: at most by its distance from it."""
    cell = read_cell("yumi")
    arm = cell.arms[0]
    assert 0.5 < hand_acceleration(cell, arm) < np.max(arm.acceleration) * 1.0


@pytest.fixture(scope="module")
def some():
    return grip_part(Case("yumi", "bracket", 1, acceleration=2.0))


def test_grips_of_a_part_come_out_as_said_and_the_same_again(some):
    told = summary(some)["all"]
    assert told["grips"] >= 60
    assert abs(told["difference"]) < 0.12
    again = grip_part(Case("yumi", "bracket", 1, acceleration=2.0))
    assert [one.grasp for one in again] == [one.grasp for one in some]
    assert all(np.array_equal(a.shifts, b.shifts) for a, b in zip(some, again, strict=True))


def test_a_search_that_is_less_sure_is_said_and_found_to_be_so(some):
    wider = summary(grip_part(Case("yumi", "bracket", 1, wider=10.0, acceleration=2.0)))["all"]
    narrow = summary(some)["all"]
    assert wider["predicted"] < narrow["predicted"] - 0.1
    assert wider["measured"] < narrow["measured"] - 0.1


def test_a_cell_without_fingers_is_refused():
    with pytest.raises(InputError, match="two fingers"):
        measure(Case("tx2_90", "puck", 0), 10)
