"""Tools with several TCPs: which one a cell works with, and what stays the same."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.derived.by_tcp import (
    by_each_tcp,
    by_taking,
    from_current_tcp,
    may_touch,
    with_tcp,
    with_tcp_at,
    with_tcps,
)
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy


@pytest.fixture(scope="module")
def cell():
    return read_cell("robots/tx2_90/two_cups.toml")


def test_a_cell_works_with_each_tcp_the_first_one_first(cell):
    first, second = by_each_tcp(cell)
    assert first is cell
    assert [each.arms[0].tool.tcp for each in (first, second)] == ["straight", "angled"]
    assert first.digest == second.digest, "it is the same cell"
    np.testing.assert_allclose(
        second.arms[0].tool.T_flange_tcp.translation, [0.052, 0.0, 0.28], atol=1e-12
    )
    assert second.arms[0].tool.body is first.arms[0].tool.body, "all cups stay bodies"
    assert by_each_tcp(cell)[1] is second, "the same object each time"


def test_two_arms_work_with_each_pair_of_tcps(cell):
    arm = cell.arms[0]
    both = replace(cell, arms=(arm, replace(arm, name="left", controller_id="L")))
    pairs = [tuple(one.tool.tcp for one in each.arms) for each in by_each_tcp(both)]
    assert pairs == [
        ("straight", "straight"),
        ("straight", "angled"),
        ("angled", "straight"),
        ("angled", "angled"),
    ]


def test_a_tool_without_names_has_one_tcp():
    cell = read_cell("tx2_90")
    assert by_each_tcp(cell) == (cell,)
    with pytest.raises(InputError, match="has no TCP 'angled'; it has one without a name"):
        with_tcp(cell.arms[0].tool, "angled")


def test_a_cell_goes_back_to_the_first_tcp(cell):
    second = with_tcps(cell, {"right": "angled"})
    assert with_tcps(second, {}).arms[0].tool.tcp == "straight"
    tool = with_tcp(second.arms[0].tool, "")
    np.testing.assert_allclose(tool.T_flange_tcp.translation, [0, 0, 0.3], atol=1e-12)


def test_only_the_named_solids_may_touch(cell):
    straight, angled = (each.arms[0].tool for each in by_each_tcp(cell))
    assert [s.name for s in straight.body if may_touch(straight, s.name)] == ["cup"]
    assert [s.name for s in angled.body if may_touch(angled, s.name)] == ["angled_cup"]
    plain = read_cell("tx2_90").arms[0].tool
    assert all(may_touch(plain, solid.name) for solid in plain.body)


def test_a_moved_tcp_is_moved_in_its_table_as_well(cell):
    moved = with_tcp_at(cell.arms[0].tool, pose_from_rpy((0.0, 0.0, 0.31)))
    back = with_tcp(with_tcp(moved, "angled"), "straight")
    np.testing.assert_allclose(back.T_flange_tcp.translation, [0, 0, 0.31], atol=1e-12)


def test_what_an_arm_does_states_the_tcp(cell):
    class Taking:
        arm, tcp = "right", "angled"

    assert by_taking(cell, Taking()).arms[0].tool.tcp == "angled"
    T = from_current_tcp(cell.arms[0].tool, "angled")
    np.testing.assert_allclose(T.translation, [0.052, 0.0, -0.02], atol=1e-12)
