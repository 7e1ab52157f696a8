"""Changes of a cell go into its file, and everything else there stays."""

import json
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shipped import shipped

from workbench.formats.cells.edits import log_change, save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy

SHIPPED = shipped("yumi")


def near(T: pin.SE3, U: pin.SE3) -> bool:
    return np.allclose(T.homogeneous, U.homogeneous, atol=5e-6)


def test_a_moved_bin_changes_one_line(cell_file):
    cell = read_cell(cell_file)
    T = pose_from_rpy((0.42, 0.01, -0.005))
    save_cell(cell_file, replace(cell, bin=replace(cell.bin, T_world_bin=T)))
    before = (find("robots", "yumi") / "cell.toml").read_text().splitlines()
    changed = [
        (old, new)
        for old, new in zip(before, cell_file.read_text().splitlines(), strict=True)
        if old != new
    ]
    assert changed == [("position_mm = [410, 0, -5]", "position_mm = [420, 10, -5]")]
    assert read_cell(cell_file).bin.T_world_bin.isApprox(T, 1e-9)


def test_a_tcp_that_was_measured_anew_changes_its_lines(cell_file):
    cell = read_cell(cell_file)
    T = pose_from_rpy((0.001, 0.0, 0.1415), (0.0, 0.0, -np.pi / 2))

    def longer(tool):
        return replace(tool, T_flange_tcp=T)

    arms = tuple(
        replace(arm, tool=longer(arm.tool), tools=tuple(map(longer, arm.tools)))
        for arm in cell.arms
    )
    save_cell(cell_file, replace(cell, arms=arms))
    assert "position_mm = [1, 0, 141.5]        # the finger tips" in cell_file.read_text()
    assert all(near(arm.tool.T_flange_tcp, T) for arm in read_cell(cell_file).arms)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"near_margin": 0.0}, "near_margin_mm = 0"),
        ({"lifts": ("leaning", "up")}, 'lifts = ["leaning", "up"]'),
    ],
)
def test_what_a_fix_changes_of_the_policy_is_written(cell_file, change, line):
    cell = read_cell(cell_file)
    changed = replace(cell, policy=replace(cell.policy, **change))
    save_cell(cell_file, changed)
    assert line in cell_file.read_text()
    assert read_cell(cell_file).digest == changed.digest


@settings(
    max_examples=15,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(
    xyz=st.tuples(*[st.floats(-1, 1)] * 3),
    rpy=st.tuples(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3)),
    turn=st.floats(-0.2, 0.2),
)
def test_whatever_can_be_moved_comes_back(cell_file, xyz, rpy, turn):
    cell = read_cell(cell_file)
    T = pose_from_rpy(xyz, rpy)
    right, left = cell.arms
    moved = replace(
        cell,
        T_world_robot=pose_from_rpy((0, 0, turn)),
        bin=replace(cell.bin, T_world_bin=T, size=np.array([0.21, 0.3, 0.06])),
        scanner=replace(cell.scanner, T_world_scanner=T),
        fixtures=(replace(cell.fixtures[0], T_world_fixture=T), *cell.fixtures[1:]),
        arms=(
            replace(right, home=np.asarray(SHIPPED.arms[0].home) + turn),
            replace(left, Ts_world_place=(*left.Ts_world_place[1:], T, T)),
        ),
    )
    save_cell(cell_file, moved)
    again = read_cell(cell_file)
    assert near(again.bin.T_world_bin, T)
    assert near(again.scanner.T_world_scanner, T)
    assert near(again.fixtures[0].T_world_fixture, T)
    np.testing.assert_allclose(again.arms[0].home, moved.arms[0].home, atol=2e-6)
    assert len(again.arms[1].Ts_world_place) == len(left.Ts_world_place) + 1
    assert near(again.arms[1].Ts_world_place[-1], T)


def test_what_the_file_cannot_hold_is_refused_and_nothing_is_written(cell_file):
    cell, before = read_cell(cell_file), cell_file.read_bytes()
    with pytest.raises(FileError, match="cannot be written into the file"):
        save_cell(cell_file, replace(cell, policy=replace(cell.policy, margin=0.02)))
    with pytest.raises(FileError, match="names no part"):
        save_cell(cell_file, replace(cell, parts=()))
    assert cell_file.read_bytes() == before
    assert [item.name for item in cell_file.parent.iterdir() if "trial" in item.name] == []


def test_a_pose_that_is_the_same_writes_nothing(cell_file):
    before = cell_file.read_bytes()
    save_cell(cell_file, read_cell(cell_file))
    assert cell_file.read_bytes() == before


def test_the_log_tells_who_saved_what_and_why(cell_file):
    cell = read_cell(cell_file)
    log_change(cell_file, cell, "Ada", 0.0, "moved the bin")
    log_change(cell_file, cell, "Bo", 86400.0, "and back")
    first, second = map(json.loads, (cell_file.parent / "changes.log").read_text().splitlines())
    assert (first["by"], first["at"], first["remark"]) == (
        "Ada",
        "1970-01-01T00:00:00Z",
        "moved the bin",
    )
    assert second["cell"] == cell.digest


def test_identity_is_written_where_nothing_stood(cell_file):
    cell = read_cell(cell_file)
    table = cell.fixtures[0]
    assert table.T_world_fixture.isApprox(pin.SE3.Identity())
    moved = replace(table, T_world_fixture=pose_from_rpy((0, 0, 0.01)))
    save_cell(cell_file, replace(cell, fixtures=(moved, *cell.fixtures[1:])))
    assert read_cell(cell_file).fixtures[0].T_world_fixture.translation[2] == pytest.approx(0.01)


@pytest.mark.parametrize("what", ["arms", "fixtures"])
def test_arms_and_fixtures_can_neither_be_added_nor_taken_away(cell_file, what):
    before = cell_file.read_text()
    cell = read_cell(cell_file)
    for fewer in (getattr(cell, what)[1:], getattr(cell, what)[::-1] * 2):
        with pytest.raises(FileError, match="something was changed that cannot be written"):
            save_cell(cell_file, replace(cell, **{what: fewer}))
    assert cell_file.read_text() == before
