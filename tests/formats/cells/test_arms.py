"""Arms of a cell file: any name, any number, and every mistake named."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from three_arms import NAMES, write_cell

from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell as write_whole_cell
from workbench.model.derived.controller_axes import from_controller, to_controller
from workbench.model.errors import FileError


def with_name(folder: Path, name: str) -> Path:
    """The first arm of the cell with another name in the cell file."""
    file = folder / "cell.toml"
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('name = "north"', f"name = {name!r}", 1), encoding="utf-8")
    srdf = folder / "arms.srdf"
    srdf.write_text(srdf.read_text().replace("north_tool", f"{name}_tool"), encoding="utf-8")
    return folder


def refused(folder: Path) -> str:
    with pytest.raises(FileError) as caught:
        read_cell(folder)
    message = str(caught.value)
    assert message.isprintable()
    return message


def test_a_cell_can_have_one_arm_called_manipulator(tmp_path: Path) -> None:
    (arm,) = read_cell(write_cell(tmp_path / "cell", ("manipulator",))).arms
    assert (arm.name, len(arm.joints)) == ("manipulator", 6)


def test_a_cell_can_have_three_arms(tmp_path: Path) -> None:
    cell = read_cell(write_cell(tmp_path / "cell"))
    assert tuple(arm.name for arm in cell.arms) == NAMES
    assert [arm.controller_id for arm in cell.arms] == ["A", "B", "C"]


def test_the_arms_of_old_cells_are_those_of_before() -> None:
    assert [(arm.name, arm.controller_id) for arm in read_cell("yumi").arms] == [
        ("right", "R"),
        ("left", "L"),
    ]
    assert [(arm.name, arm.controller_id) for arm in read_cell("tx2_90").arms] == [("right", "R")]


@pytest.mark.parametrize("name", ["a", "7", "_", "Arm-1", "arm_2", "x" * 40])
def test_letters_digits_and_two_signs_make_a_name(tmp_path: Path, name: str) -> None:
    folder = with_name(write_cell(tmp_path / "cell"), name)
    assert read_cell(folder).arms[0].name == name


@pytest.mark.parametrize("name", ["left arm", "-a", "a.b", "a/b", "größe", "x" * 41, "a:b"])
def test_any_other_name_is_refused_with_what_is_expected(tmp_path: Path, name: str) -> None:
    message = refused(with_name(write_cell(tmp_path / "cell"), name))
    assert "cell.toml: key arm[1].name: " in message
    assert name in message
    assert "1 to 40 letters, digits, - and _ are expected" in message


@pytest.mark.parametrize("name", ["auto", "alternated", "Coordinated", "both", "single"])
def test_no_arm_is_called_like_a_strategy(tmp_path: Path, name: str) -> None:
    message = refused(with_name(write_cell(tmp_path / "cell"), name))
    assert f"cell.toml: key arm[1].name: {name!r} names a strategy" in message
    assert "alternated, coordinated, both" in message


@pytest.mark.parametrize("name", ["south_east", "South_East"])
def test_two_arms_have_names_that_people_can_tell_apart(tmp_path: Path, name: str) -> None:
    message = refused(with_name(write_cell(tmp_path / "cell"), name))
    assert "cell.toml: key arm.name: " in message
    assert f"'south_east' is there beside {name!r}" in message


def test_two_arms_cannot_both_be_called_a(tmp_path: Path) -> None:
    assert "'a' is there beside 'a'" in refused(write_cell(tmp_path / "cell", ("a", "a")))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tool =", "axes = [1, 2, 3, 4, 5, 6.9]\ntool =", "arm[1].axes: 6.9 is not a whole number"),
        ("rpy_deg = [180, 0, 0]\n\n[[arm]]", "grid = [2.5, 1]\npitch_mm = [9, 9]\n[[arm]]",
         "arm[1].place[1].grid: 2.5 is not a whole number"),
        ("field_of_view_deg", "resolution = [640.5, 480]\nfield_of_view_deg",
         "scanner.resolution: 640.5 is not a whole number"),
    ],
)  # fmt: skip
def test_what_is_counted_is_a_whole_number(tmp_path: Path, old, new, message) -> None:
    folder = write_cell(tmp_path / "cell")
    file = folder / "cell.toml"
    text = file.read_text(encoding="utf-8")
    assert old in text
    head, arm = text.split("[[arm]]", 1) if old == "tool =" else ("", text)
    file.write_text((head + "[[arm]]" if head else "") + arm.replace(old, new, 1), encoding="utf-8")
    assert message in refused(folder)


def on_a_torso(folder: Path, kind: str) -> Path:
    """A cell with three arms, the first two of them on a torso that a joint of this kind turns."""
    write_cell(folder)
    urdf = folder / "arms.urdf"
    text = urdf.read_text()
    for k in range(2):
        joint = f'<joint name="joint_{k}_1" type="revolute"><parent link='
        assert f'{joint}"world"' in text
        text = text.replace(f'{joint}"world"', f'{joint}"torso"')
    torso = (
        f'<joint name="waist" type="{kind}"><parent link="world"/><child link="torso"/>'
        '<origin xyz="0 0 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="0"/></joint><link name="torso"/>'
    )
    urdf.write_text(text.replace("</robot>", f"{torso}</robot>"))
    return folder


def test_arms_on_a_joint_that_moves_both_are_refused(tmp_path: Path) -> None:
    """Only one of them would be checked against what the joint carries."""
    folder = on_a_torso(tmp_path / "cell", "revolute")
    cell = folder / "cell.toml"
    cell.write_text(cell.read_text().replace("[0, -20, 120, 0, 80, 0]", "[0, 0, 0, 0, 0, 0, 0]", 2))
    message = refused(folder)
    assert "cell.toml: key arm.flange: 'north' and 'south-west' both hang on waist" in message


def test_arms_on_a_torso_that_stands_still_are_read(tmp_path: Path) -> None:
    arms = read_cell(on_a_torso(tmp_path / "cell", "fixed")).arms
    assert [len(arm.joints) for arm in arms] == [6, 6, 6]


def test_a_cell_without_an_arm_is_refused(tmp_path: Path) -> None:
    folder = write_cell(tmp_path / "cell", ())
    assert "key arm: is missing; at least one [[arm]] table is expected" in refused(folder)


def test_a_pair_with_the_tool_of_no_arm_is_refused(tmp_path: Path) -> None:
    folder = write_cell(tmp_path / "cell", ("manipulator",))
    srdf = folder / "arms.srdf"
    srdf.write_text(srdf.read_text().replace("manipulator_tool", "right_tool"))
    message = refused(folder)
    assert "arms.srdf: names link 'right_tool', which the URDF does not have" in message
    assert "the tool of an arm is called manipulator_tool" in message


def test_three_arms_that_were_written_are_read_again(tmp_path: Path) -> None:
    cell = read_cell(write_cell(tmp_path / "cell"))
    pairs = {pair: "Adjacent" for pair in cell.robot.disabled_pairs}
    again = read_cell(write_whole_cell(tmp_path / "again", cell, pairs))
    assert [arm.name for arm in again.arms] == list(NAMES)
    assert again.robot.disabled_pairs == cell.robot.disabled_pairs


def test_parts_do_not_stay_and_go_at_once(tmp_path: Path) -> None:
    folder = write_cell(tmp_path / "cell")
    file = folder / "cell.toml"
    text = file.read_text(encoding="utf-8")
    both = 'name = "north"\nkeeps_parts = true\npasses_parts_on = true'
    file.write_text(text.replace('name = "north"', both, 1), encoding="utf-8")
    assert "arm[1].passes_parts_on: " in refused(folder)
    file.write_text(file.read_text().replace("keeps_parts = true\n", ""), encoding="utf-8")
    assert [arm.passes_parts_on for arm in read_cell(folder).arms] == [True, False, False]


def test_jerk_is_unlimited_unless_a_cell_says_so(tmp_path: Path) -> None:
    folder = write_cell(tmp_path / "cell")
    file = folder / "cell.toml"
    text, before = file.read_text(encoding="utf-8"), read_cell(folder)
    assert [arm.jerk for arm in before.arms] == [None] * 3

    def says(value: str) -> None:
        limited = f'name = "north"\njerk_deg = {value}'
        file.write_text(text.replace('name = "north"', limited, 1), encoding="utf-8")

    for value, problem in (
        ("0", "arm[1].jerk_deg: 0 is not between 10 and 1e+08"),
        ("-5", "arm[1].jerk_deg: -5 is not between 10 and 1e+08"),
        ("inf", "arm[1].jerk_deg: a finite number is expected, inf is given"),
        ('"much"', "arm[1].jerk_deg: a number is expected, 'much' is given"),
        ("[9000]", "arm[1].jerk_deg: a number is expected, [9000] is given"),
    ):
        says(value)
        assert problem in refused(folder)
    says("12000")
    cell = read_cell(folder)
    jerk = cell.arm("north").jerk
    assert jerk is not None and np.allclose(np.rad2deg(jerk), 12000)
    assert [arm.jerk is None for arm in cell.arms] == [arm.name != "north" for arm in cell.arms]
    assert cell.digest != before.digest
    pairs = {pair: "Adjacent" for pair in cell.robot.disabled_pairs}
    again = read_cell(write_whole_cell(tmp_path / "again", cell, pairs))
    assert again.arm("north").jerk == pytest.approx(jerk)


COUPLED = """axis_coupling = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, -1, 1, 0, 0, 0],
  [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]
axis_offsets = [0, 90, 0, 0, 0, -180]
"""


def with_keys(folder: Path, keys: str, protocol: str = "pick-server") -> Path:
    """The cell of one arm with more keys, spoken to by that link."""
    file = folder / "cell.toml"
    text = re.sub(r"\n\[controller\][^\[]*", "\n", file.read_text(encoding="utf-8"))
    text = text.replace('name = "manipulator"\n', f'name = "manipulator"\n{keys}', 1)
    file.write_text(f'{text}\n[controller]\nprotocol = "{protocol}"\n', encoding="utf-8")
    return folder


def test_a_controller_that_couples_axes_shows_them_so_and_a_written_cell_keeps_it(
    tmp_path: Path,
) -> None:
    cell = read_cell(with_keys(write_cell(tmp_path / "cell", ("manipulator",)), COUPLED))
    q = np.deg2rad([10, 20, 30, 40, 50, 60])
    axes = np.rad2deg(cell.arms[0].to_axes(q))
    shown = np.rad2deg(to_controller(cell.arms[0], q))
    assert shown == pytest.approx(axes + [0, 90, -axes[1], 0, 0, -180])
    assert from_controller(cell.arms[0], np.deg2rad(shown)) == pytest.approx(q)
    again = read_cell(write_whole_cell(tmp_path / "again", cell, {}).parent)
    assert to_controller(again.arms[0], q) == pytest.approx(np.deg2rad(shown))
    assert again.arms[0].home == pytest.approx(cell.arms[0].home)


def test_home_is_typed_as_the_controller_shows_it(tmp_path: Path) -> None:
    folder = with_keys(write_cell(tmp_path / "cell", ("manipulator",)), COUPLED)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    typed = "home_deg = [10, 120, -20, 40, 50, -120]"
    text = re.sub(r"home_deg = .*", typed, text)
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    cell = read_cell(folder)
    axes = cell.arms[0].to_axes(cell.arms[0].home)
    assert np.rad2deg(axes) == pytest.approx([10, 30, 10, 40, 50, 60])
    moved = replace(cell.arms[0], home=np.deg2rad([0, 20, 0, 0, 30, 0]))
    save_cell(folder / "cell.toml", replace(cell, arms=(moved,)))
    assert read_cell(folder).arms[0].home == pytest.approx(np.asarray(moved.home))


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ("[0, -1, 1,", "[0, -1.5, 1,", "whole numbers"),
        ("[0, -1, 1, 0, 0, 0]", "[0, 1, 0, 0, 0, 0]", "depend on each other"),
        ("[0, -1, 1, 0, 0, 0],\n", "", "6 rows"),
        ("[0, 90, 0, 0, 0, -180]", "[0, 90]", "6 numbers"),
        ("[0, 90, 0, 0, 0, -180]", "[0, 0.005, 0, 0, 0, 0]", "digits"),
    ],
)
def test_a_coupling_that_no_controller_has_is_refused(
    tmp_path: Path, old: str, new: str, why: str
) -> None:
    assert old in COUPLED
    keys = COUPLED.replace(old, new)
    assert why in refused(with_keys(write_cell(tmp_path / "cell", ("manipulator",)), keys))


def test_a_link_that_does_not_know_couplings_is_refused_with_one(tmp_path: Path) -> None:
    folder = with_keys(write_cell(tmp_path / "cell", ("manipulator",)), COUPLED, "abb-socket")
    assert "does not know the axis_coupling" in refused(folder)
