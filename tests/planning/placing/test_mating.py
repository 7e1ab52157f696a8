"""How often a part mates: by the rule, and by trying every push at every depth."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.model.geometry import pose_from_rpy
from workbench.model.recipes.joint import Joint, PlacingError
from workbench.model.recipes.kit import Insertion
from workbench.planning.placing.chance import draw_errors
from workbench.planning.placing.mating import least_push, mate, mating_chance

NOTHING = np.zeros((6, 6))
EXACT = PlacingError(NOTHING, NOTHING)
WIDE = Joint((0.02, 0.0, 0.006), 0.03, 0.03, 0.006, 0.001, 0.002, 0.0015)


def insertion(**changes) -> Insertion:
    """A peg through a thin plate, turned over as it comes: its tip is at z = 35 mm of it."""
    joint = replace(WIDE, **changes)
    return Insertion("plate", (0.02, 0.0, 0.011), (np.pi, 0.0, 0.4), (0, 0, -1), 0.05, 1e-4, joint)


def deviating(shift: float, degrees: float) -> PlacingError:
    turn = float(np.deg2rad(degrees))
    return PlacingError(NOTHING, np.diag(np.square([shift] * 3 + [turn] * 3)))


def chance(asked: Insertion, part=EXACT, base=EXACT, scanner=NOTHING) -> float:
    return mating_chance(asked, part, base, scanner)


def test_without_any_error_all_parts_mate():
    assert chance(insertion()) == 1.0
    assert chance(insertion(clearance=1e-6, chamfer=0.0, compliance=0.0)) == 1.0


@pytest.mark.parametrize("compliance", [0.0, 0.0015])
def test_each_time_errors_double_fewer_parts_mate(compliance):
    asked = insertion(compliance=compliance)
    shares = [
        chance(asked, deviating(0.0004 * k, 0.8 * k), deviating(0.0003 * k, 0.5 * k))
        for k in (0.5, 1, 2, 4)
    ]
    assert shares == sorted(shares, reverse=True) and len(set(shares)) == 4


def test_a_chamfer_is_of_use_only_to_a_hand_that_gives_way():
    part = deviating(0.0008, 0.0)
    stiff = chance(insertion(compliance=0.0), part)
    assert stiff == chance(insertion(compliance=0.0, chamfer=0.0), part)
    assert stiff == chance(insertion(chamfer=0.0), part) < chance(insertion(), part)
    # Both axes of a normal error: a Rayleigh distribution, and the depth changes nothing.
    assert stiff == pytest.approx(1 - np.exp(-((0.001 / 0.0008) ** 2) / 2), abs=0.01)


def test_a_part_that_would_touch_at_two_points_does_not_mate_however_far_it_gives_way():
    asked = insertion(chamfer=0.02, compliance=0.02)
    most = 2 * WIDE.clearance / WIDE.base_length
    for tilt, mates in ((0.98 * most, True), (1.02 * most, False)):
        error = np.array([[0.0, 0.0, 0.0, tilt, 0.0, 0.0]])
        assert mate(asked, error, np.zeros((1, 6)))[0] == mates


def test_what_the_scanner_is_off_cancels_where_it_moves_both_parts_alike():
    scanner = np.diag([1e-6, 1e-6, 1e-6, 0, 0, 0]) * 4.0
    asked = insertion(compliance=0.0)
    # The part lies turned over in its base's frame: its own axes are turned, too.
    alike = np.kron(np.eye(2), asked.T_base_part.rotation.T)
    base = PlacingError(np.eye(6), NOTHING)
    assert chance(asked, PlacingError(alike, NOTHING), base, scanner) == 1.0
    against = chance(asked, PlacingError(-alike, NOTHING), base, scanner)
    assert against < chance(asked, PlacingError(alike, NOTHING), EXACT, scanner) < 0.2


@given(
    st.tuples(*[st.floats(-3, 3)] * 4),
    st.floats(0.1, 2),
)
def test_the_least_push_is_the_nearest_point_at_which_both_ends_are_free(offsets, clearance):
    mouth, tip = np.array([offsets[:2]]), np.array([offsets[2:]])
    (found,) = least_push(mouth, tip, clearance)
    angle = np.linspace(0, 2 * np.pi, 2000)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if np.isfinite(found):
        # Some push so long frees both ends, and no shorter one does.
        free = [np.linalg.norm(end + found * ring, axis=1).min() for end in (mouth, tip)]
        assert max(free) <= clearance + 0.01
        for part in (0.25, 0.5, 0.75, 0.97):
            ends = [np.linalg.norm(end + part * found * ring, axis=1) for end in (mouth, tip)]
            assert (np.maximum(*ends) > clearance - 1e-6).all() or found < 1e-3
    else:
        assert np.linalg.norm(mouth - tip) > 2 * clearance * (1 - 1e-6)


def tried(asked: Insertion, T_base: pin.SE3, T_part: pin.SE3, joint: Joint) -> bool:
    """Whether some push at each of many depths leaves the whole joint free."""
    along, mouth = np.array(asked.along), np.array(joint.mouth)
    angle, far = np.linspace(0, 2 * np.pi, 48, endpoint=False), np.linspace(0, 1, 17)
    pushes = joint.compliance * np.array(
        [[f * np.cos(a), f * np.sin(a), 0.0] for f in far for a in angle]
    )
    for depth in np.linspace(0.0, joint.depth, 16):
        low, high = max(0.0, depth - joint.part_length), min(depth, joint.base_length)
        # At the mouth the chamfer catches what the hand then pushes.
        most = joint.clearance
        free = np.ones(len(pushes), bool)
        for at in np.linspace(low, high, 4):
            on_base = T_base.act(mouth + at * along)
            seated = mouth + (joint.depth - depth + at) * along
            on_part = (
                asked.T_base_part.act(T_part.act(asked.T_base_part.inverse().act(seated)))
                - (joint.depth - depth) * along
            )
            off = (on_part - on_base)[:2]
            if depth == 0 and np.linalg.norm(off) > joint.clearance + joint.chamfer:
                return False
            free &= np.linalg.norm(off + pushes[:, :2], axis=1) <= most
        if not free.any():
            return False
    return True


def test_the_share_is_that_of_parts_tried_one_by_one_with_exact_motions():
    asked, part, base = insertion(), deviating(0.0007, 1.5), deviating(0.0006, 1.0)
    count = 250
    mates = [
        tried(
            asked,
            pin.SE3(pin.exp3(of_base[3:]), of_base[:3]),
            pin.SE3(pin.exp3(of_part[3:]), of_part[:3]),
            WIDE,
        )
        for of_part, of_base in zip(
            draw_errors(part.covariance, count, 11),
            draw_errors(base.covariance, count, 12),
            strict=True,
        )
    ]
    said = chance(asked, part, base)
    assert 0.3 < said < 0.9
    assert np.mean(mates) == pytest.approx(said, abs=0.06)


def test_the_pose_of_the_seat_counts_and_not_how_its_frame_lies():
    error = np.array([[0.0004, -0.0003, 0.0, 0.01, -0.02, 0.3]])
    straight = Insertion(
        "ring",
        (0, 0, 0.03),
        (0, 0, 0),
        (0, 0, -1),
        0.05,
        1e-4,
        replace(WIDE, mouth=(0.0, 0.0, 0.01), depth=0.02, part_length=0.02, base_length=0.02),
    )
    turn = pose_from_rpy((0.0, 0.0, 0.0), (0.7, -0.4, 0.2))
    joint = straight.joint
    assert joint is not None
    turned = replace(
        straight,
        position=tuple(turn.act(np.array(straight.position))),
        rpy=tuple(pin.rpy.matrixToRpy(turn.rotation)),
        along=tuple(turn.rotation @ np.array(straight.along)),
        joint=replace(joint, mouth=tuple(turn.act(np.array(joint.mouth)))),
    )
    for times in np.linspace(0.1, 6.0, 40):
        results = [mate(one, error * times, np.zeros((1, 6)))[0] for one in (straight, turned)]
        assert results[0] == results[1]
