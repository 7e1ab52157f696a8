"""Arms of a cell file: any name, any number, and every mistake named."""

from pathlib import Path

import pytest
from three_arms import NAMES, write_cell

from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell as write_whole_cell
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
