"""Blends of the link to Universal Robots: what is cut off is what was proven, and it is quicker."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from twins import PATIENT, approved_for, legs_of, twin_of

from workbench.devices.universal_robots.blends import LEAST_RADIUS, blend_lines, seconds_of_all
from workbench.devices.universal_robots.flange import Flange
from workbench.devices.universal_robots.link import UrRtdeBlend
from workbench.devices.universal_robots.program import ProgramSettings, program_of
from workbench.devices.universal_robots.urscript import Line, read_program
from workbench.devices.universal_robots.ways import UrWay, without_overlaps
from workbench.plugins.robot_link import send
from workbench.testing import check_robot_link


@pytest.fixture(scope="module")
def planned():
    """A cell with six axes whose controller blends, a plan, and its approval."""
    return approved_for("ur-rtde-blend")


def moves_of(cell, plan, approval, blend):
    """The moves of each leg, and where each begins."""
    text = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0, blend)).text
    lines = [line for line in read_program(text) if line.name == "movej"]
    arm, found = cell.arms[0], []
    for leg in legs_of(plan):
        moving = np.abs(np.diff(leg.q, axis=0)).max(axis=1) > 1e-9
        count = int(moving.sum())
        found.append((arm.to_axes(leg.q[0]).tolist(), lines[:count]))
        lines = lines[count:]
    assert not lines
    return found


def off_what_is_proven(q, corners, zone):
    """How far [rad] a configuration (n,) is from what the proof of a path has looked at.

    That is, of each corner, what lies between it and the parabola from `zone` of the move before
    to `zone` of the one after, and all of the moves.
    """
    least = np.inf
    for a, b in itertools.pairwise(corners):
        share = np.clip((q - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        least = min(least, np.abs(a + share * (b - a) - q).max())
    for a, corner, b in zip(corners[:-2], corners[1:-1], corners[2:], strict=True):
        sides = np.stack([a - corner, b - corner], axis=1)
        shares, *_ = np.linalg.lstsq(sides, q - corner, rcond=None)
        shares = np.maximum(shares, 0.0)
        if np.sqrt(shares).sum() <= np.sqrt(zone):
            least = min(least, np.abs(corner + sides @ shares - q).max())
    return least


def test_the_way_that_is_cut_is_what_was_proven_and_quicker(planned):
    cell, plan, approval = planned
    flange, cut, slow, fast = Flange(cell, cell.arms[0]), 0, 0.0, 0.0
    stops = moves_of(cell, plan, approval, 0.0)
    for (start, lines), (_, sharp) in zip(moves_of(cell, plan, approval, 0.05), stops, strict=True):
        corners = np.array([start, *(line.q for line in lines)])
        assert lines[-1].r == 0.0, "the robot stands at the end of each leg"
        fast += seconds_of_all(start, lines, flange)
        slow += seconds_of_all(start, sharp, flange)
        assert [line.q for line in lines] == [line.q for line in sharp]
        assert without_overlaps(start, lines, flange.at) == list(lines)
        first = start
        while lines:
            count = next(k for k, line in enumerate(lines, start=1) if not line.r)
            way = UrWay(first, lines[:count], flange.at)
            for t in np.linspace(0.0, way.seconds, 60 * count):
                q = np.array(way.at(t))
                assert off_what_is_proven(q, corners, cell.zone) < 1e-6
                cut += min(off_straight(q, a, b) for a, b in itertools.pairwise(corners)) > 1e-6
            first, lines = lines[count - 1].q, lines[count:]
    assert cut > 20, "corners are really cut"
    assert fast < 0.9 * slow


def off_straight(q, a, b):
    share = np.clip((q - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.abs(a + share * (b - a) - q).max()


def test_a_right_angle_is_cut_no_farther_than_was_proven(planned):
    cell, _, _ = planned
    flange = Flange(cell, cell.arms[0])
    start = np.array([0.0, 0.5, 1.0, 0.0, 1.0, 0.0])
    corners = np.cumsum([start, [0.8, 0, 0, 0, 0, 0], [0, 0.6, 0, 0, 0, 0]], axis=0)
    lines = [Line("movej", (), tuple(q.tolist()), 20.0, 1.0) for q in corners[1:]]
    moves = blend_lines(start.tolist(), lines, flange, np.full(6, 20.0), 0.2, 0.5)
    way = UrWay(start.tolist(), moves, flange.at)
    ways = [np.array(way.at(t)) for t in np.linspace(0.0, way.seconds, 500)]
    assert max(off_what_is_proven(q, corners, 0.2) for q in ways) < 1e-6
    assert (
        max(min(off_straight(q, a, b) for a, b in itertools.pairwise(corners)) for q in ways) > 0.01
    )
    # A larger radius leaves what was proven, and the test sees it.
    farther = [replace(moves[0], r=3 * moves[0].r), moves[1]]
    way = UrWay(start.tolist(), farther, flange.at)
    ways = [np.array(way.at(t)) for t in np.linspace(0.0, way.seconds, 500)]
    assert max(off_what_is_proven(q, corners, 0.2) for q in ways) > 1e-3


def test_what_leaves_the_corner_would_be_noticed():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    assert off_what_is_proven(np.array([0.97, 0.03]), corners, 0.2) < 1e-9
    assert off_what_is_proven(np.array([0.85, 0.15]), corners, 0.2) > 0.1
    assert off_what_is_proven(np.array([1.02, 0.0]), corners, 0.2) > 0.01


def test_no_axis_is_faster_or_more_sudden_than_its_limits(planned):
    cell, plan, approval = planned
    arm, flange = cell.arms[0], Flange(cell, cell.arms[0])
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    for start, lines in moves_of(cell, plan, approval, 0.05):
        while lines:
            count = next(k for k, line in enumerate(lines, start=1) if not line.r)
            way = UrWay(start, lines[:count], flange.at)
            t = np.arange(0.0, way.seconds, 1e-3)
            q = np.array([arm.from_axes(way.at(one)) for one in t])
            speeds = np.diff(q, axis=0) / 1e-3
            assert np.all(np.abs(speeds) <= velocity * 1.001)
            assert np.all(np.abs(np.diff(speeds, axis=0) / 1e-3) <= arm.acceleration * 1.3)
            start, lines = lines[count - 1].q, lines[count:]


def test_the_twin_runs_the_blends_and_stays_in_what_was_proven(planned, host, tmp_path):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell, plan, approval = planned
    trace = tmp_path / "trace"
    with twin_of(cell, host, speed=4.0, trace=trace) as (_, there):
        receipts = list(send(plan, approval, there, patience=PATIENT))
        assert receipts[-1].kind == "end" and ", r=" in receipts[0].sent
    arm, legs = cell.arms[0], legs_of(plan)
    seen = [arm.from_axes(json.loads(line)["q"]) for line in trace.read_text().splitlines()]
    off = [min(off_what_is_proven(q, leg.q, cell.zone) for leg in legs) for q in seen]
    assert len(seen) > 30 and max(off) < 1e-6


def test_a_blend_that_overlaps_is_left_out_as_the_maker_says():
    start, r = [0.0] * 6, 0.6
    q = [(1.0, 0, 0, 0, 0, 0), (1.0, 1.0, 0, 0, 0, 0), (2.0, 1.0, 0, 0, 0, 0)]
    lines = [Line("movej", (), one, 1.0, 1.0, r) for one in q[:2]] + [
        Line("movej", (), q[2], 1.0, 1.0)
    ]
    assert without_overlaps(start, lines, lambda axes: axes[:, :3]) == lines[2:]
    lines[0] = replace(lines[0], r=0.3)
    assert without_overlaps(start, lines, lambda axes: axes[:, :3]) == lines


def test_any_moves_with_any_radii_are_one_way_from_rest_to_rest(planned):
    cell, _, _ = planned
    flange, rng = Flange(cell, cell.arms[0]), np.random.default_rng(3)
    for _ in range(20):
        q = np.cumsum(rng.normal(0.0, rng.choice([0.01, 0.3, 3.0]), (5, 6)), axis=0)
        lines = [
            Line(
                "movej",
                (),
                tuple(one),
                *rng.uniform(0.1, 9.0, 2),
                float(rng.choice([0.0, 0.02, 0.4])),
            )
            for one in q[1:].tolist()
        ]
        way = UrWay(q[0].tolist(), lines, flange.at)
        assert way.at(0.0) == pytest.approx(q[0]) and way.at(way.seconds) == pytest.approx(q[-1])
        seen = np.array([way.at(t) for t in np.linspace(0.0, way.seconds, 400)])
        assert np.isfinite(seen).all()
        most = max(line.v for line in lines) * way.seconds / 399
        assert np.abs(np.diff(seen, axis=0)).max() <= most * 1.5, "it never jumps"


def test_where_the_flange_stays_a_corner_is_not_blended(planned):
    cell, _, _ = planned
    flange = Flange(cell, cell.arms[0])
    start = [0.3] * 6
    q = [[0.3] * 5 + [0.9], [0.3] * 5 + [1.5], [0.3] * 4 + [0.9, 1.5]]
    lines = [Line("movej", (), tuple(one), 2.0, 1.0) for one in q]
    moved = blend_lines(start, lines, flange, np.full(6, 2.0), 0.2, 0.05)
    assert [line.r for line in moved] == [0.0, 0.0, 0.0]
    assert moved == tuple(lines)


def test_radii_are_within_what_is_asked_and_none_without_a_zone(planned):
    cell, plan, approval = planned
    radii = [line.r for _, lines in moves_of(cell, plan, approval, 0.004) for line in lines]
    assert 0.0 < max(radii) <= 0.004 and min(one for one in radii if one) >= LEAST_RADIUS
    stopping = replace(cell, policy=replace(cell.policy, zone=0.0))
    blending, plain = (ProgramSettings(0, 0.5, 2.0, blend) for blend in (0.05, 0.0))
    assert ", r=" not in program_of(stopping, plan, approval, blending).text
    assert ", r=" not in program_of(cell, plan, approval, plain).text


@pytest.mark.timeout(1800)
def test_it_keeps_the_promises_of_every_link(planned, host):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    check_robot_link(UrRtdeBlend(), *planned, host=host)
