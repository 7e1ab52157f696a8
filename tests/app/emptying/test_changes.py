"""Single changes of a cell."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.emptying.changes import apply_change, changes_of
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Box
from workbench.model.messages.changes import ChangeText
from workbench.model.part import GraspLibrary
from workbench.model.prediction import CHANGE_KINDS


@pytest.fixture(scope="module", params=["yumi", "tx2_90"])
def cell(request):
    return read_cell(request.param)


def test_every_change_makes_another_cell_or_says_that_there_is_nothing_to_change(cell):
    said = [change.said for change in changes_of(cell)]
    assert len(set(said)) == len({str(one) for one in said}) == len(said)
    assert {change.kind for change in changes_of(cell)} <= set(CHANGE_KINDS)
    made = 0
    for change in changes_of(cell):
        if change.said.text is ChangeText.SUGGESTED:
            continue  # it takes a minute
        other = change.made(cell)
        assert other is None or other.digest != cell.digest, change.said
        made += other is not None
        assert apply_change(cell, change.said).digest == (other or cell).digest
    assert made >= 10
    assert apply_change(cell, None) is cell


def test_thinner_fingers_close_where_they_did_and_longer_ones_take_the_tcp_along():
    cell = read_cell("yumi")
    tool = cell.arms[0].tool
    said = ChangeText.FINGERS_THINNER(by=0.002), ChangeText.FINGERS_LONGER(by=0.02)
    thin, long = (apply_change(cell, one).arms[0].tool for one in said)
    for before, after in zip(tool.fingers, thin.fingers, strict=True):
        a, b = before.solid, after.solid
        assert isinstance(a.shape, Box) and isinstance(b.shape, Box)
        assert a.shape.size[0] - b.shape.size[0] == pytest.approx(0.002)
        inner = [abs(s.T_owner_shape.translation[0]) - s.shape.size[0] / 2 for s in (a, b)]
        assert inner == pytest.approx([0.0, 0.0])
    for before, after in zip(tool.fingers, long.fingers, strict=True):
        a, b = before.solid, after.solid
        assert isinstance(a.shape, Box) and isinstance(b.shape, Box)
        ends = [s.T_owner_shape.translation[2] + s.shape.size[2] / 2 for s in (a, b)]
        roots = [s.T_owner_shape.translation[2] - s.shape.size[2] / 2 for s in (a, b)]
        assert ends[1] - ends[0] == pytest.approx(0.02) and roots[0] == pytest.approx(roots[1])
    step = long.T_flange_tcp.translation - tool.T_flange_tcp.translation
    assert step == pytest.approx([0, 0, 0.02])


def test_a_bin_that_is_moved_takes_its_scanner_along():
    cell = read_cell("yumi")
    near = apply_change(cell, ChangeText.BIN_NEARER(by=0.05))
    step = near.bin.T_world_bin.translation - cell.bin.T_world_bin.translation
    assert step == pytest.approx([-0.05, 0, 0], abs=1e-6)
    turned = apply_change(cell, ChangeText.BIN_TURNED(by=np.pi / 2))
    for one in (cell, near, turned):
        view = one.bin.T_world_bin.actInv(one.scanner.T_world_scanner)
        assert np.allclose(
            view.homogeneous,
            cell.bin.T_world_bin.actInv(cell.scanner.T_world_scanner).homogeneous,
        )


def test_twice_as_many_turns_lie_between_those_that_there_are():
    cell = read_cell("yumi")
    more = apply_change(cell, TURNS_CHANGE)
    (before,), (after,) = (one.parts[0].library.entries for one in (cell, more))
    assert np.rad2deg(sorted(after.angles)) == pytest.approx(np.arange(10) * 36.0)
    assert after.angles[:5] == before.angles


def with_entries(cell, entries):
    part = cell.parts[0]
    return replace(cell, parts=(replace(part, library=GraspLibrary(tuple(entries))),))


TURNS_CHANGE = ChangeText.MORE_TURNS()


@pytest.mark.parametrize(
    ("before", "more"),
    [
        ((0.0, 0.4, 0.8), (0.2, 0.6)),  # a part of a circle: nothing beyond its ends
        ((0.0, 0.4, 1.2), (0.2, 0.8)),
        ((0.0, np.pi / 2, np.pi, 3 * np.pi / 2), np.array([0.25, 0.75, 1.25, 1.75]) * np.pi),
        ((-np.pi / 2, 0.0, np.pi / 2, np.pi), np.array([-0.25, 0.25, 0.75, 1.25]) * np.pi),
        ((0.0, 0.0), None),
        ((0.3,), None),
    ],
)
def test_turns_are_added_between_those_that_people_have_authored(before, more):
    cell = read_cell("yumi")
    (pattern,) = cell.parts[0].library.entries
    other = changed_by(with_entries(cell, [replace(pattern, angles=before)]), TURNS_CHANGE)
    if more is None:
        assert other is None
        return
    (after,) = other.parts[0].library.entries
    assert after.angles[: len(before)] == before
    assert sorted(after.angles[len(before) :]) == pytest.approx(sorted(more))


def changed_by(cell, said):
    return next(one for one in changes_of(cell) if one.said == said).made(cell)


def test_grasps_that_no_fingers_open_any_further_for_are_not_tried_again():
    cell = read_cell("yumi")
    high = min(arm.tool.stroke[1] for arm in cell.arms)
    wide = with_entries(cell, [replace(one, opening=high) for one in cell.parts[0].grasps])
    assert changed_by(wide, ChangeText.MORE_OPEN(by=0.003)) is None
    assert changed_by(wide, ChangeText.LESS_OPEN(by=0.003)) is not None
    tight = with_entries(
        cell, [replace(one, opening=one.grip + 0.001) for one in cell.parts[0].grasps]
    )
    assert changed_by(tight, ChangeText.LESS_OPEN(by=0.003)) is None


def test_fingers_open_for_a_grasp_as_far_as_every_arm_can():
    """The first arm has no fingers, the third opens less far than the second."""
    cell = read_cell("yumi")
    first, second = cell.arms
    (low, high), cup = second.tool.stroke, read_cell("tx2_90").arms[0].tool
    short = replace(second, tool=replace(second.tool, stroke=(low, high - 0.002)))
    grasps = [replace(one, opening=high - 0.003) for one in cell.parts[0].grasps]
    cell = replace(cell, arms=(replace(first, tool=cup), second, short))
    wider = changed_by(with_entries(cell, grasps), ChangeText.MORE_OPEN(by=0.003))
    assert wider is not None
    openings = {round(one.opening, 6) for one in wider.parts[0].grasps}
    assert openings == {round(high - 0.002, 6)}
