"""A scanner on an arm in a cell file: where it is, and what is refused."""

import re
import shutil
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import with_lower_view

from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.derived.by_view import view_name, with_view
from workbench.model.errors import FileError
from workbench.model.robot import AxisMapping
from workbench.planning.kinematics.robot import Kinematics
from workbench.plugins.robot_link import spoken_to_by

SHIPPED = find("robots", "yumi")
JOINTS = "joints_deg = [-90.3, -33.9, 23.4, 81.2, 109.7, 17.7, 36]"

SECOND = f'[[scanner.on_arm.view]]\nname = "bin"\n{JOINTS}\n\n'
"""A view of the same name as the one in the file."""

Spoil = Callable[[str, str], Path]


@pytest.fixture
def spoil(tmp_path: Path) -> Spoil:
    """Writes the shipped cell with one text replaced, and gives the file."""
    folder = Path(shutil.copytree(SHIPPED, tmp_path / "mine"))

    def spoiled(old: str, new: str) -> Path:
        path = folder / "on_arm.toml"
        text = path.read_text(encoding="utf-8")
        assert old in text
        path.write_text(text.replace(old, new, 1), encoding="utf-8")
        return path

    return spoiled


def test_the_scanner_is_where_the_flange_is_at_the_view() -> None:
    cell = read_cell(SHIPPED / "on_arm.toml")
    carrier, arm = cell.scanner.on_arm, cell.arm("left")
    assert carrier is not None
    T_world_flange = (
        Kinematics(cell).tcp_pose(arm, carrier.view.q) * arm.tool.T_flange_tcp.inverse()
    )
    assert cell.scanner.T_world_scanner.isApprox(T_world_flange * carrier.T_flange_scanner, 1e-12)
    assert np.allclose(cell.scanner.T_world_scanner.translation, [0.41, 0, 0.48], atol=3e-4)


def test_the_arm_waits_at_the_view_and_its_home_in_the_file_is_known() -> None:
    cell, standing = read_cell(SHIPPED / "on_arm.toml"), read_cell("yumi")
    carrier = cell.scanner.on_arm
    assert carrier is not None
    assert np.array_equal(cell.arm("left").home, carrier.view.q)
    assert np.array_equal(carrier.home, standing.arm("left").home)
    assert np.array_equal(cell.arm("right").home, standing.arm("right").home)


def test_a_view_is_stated_by_the_pose_of_the_scanner_as_well(spoil: Spoil) -> None:
    cell = read_cell(spoil(JOINTS, "position_mm = [410, 0, 480]\nrpy_deg = [180, 0, 90]"))
    T = cell.scanner.T_world_scanner
    assert np.allclose(T.translation, [0.41, 0, 0.48], atol=5e-5)
    assert np.allclose(T.rotation, [[0, 1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('arm = "left"', 'arm = "middle"', "on_arm.arm: 'middle' is not one of right, left"),
        ("[scanner]\n", "[scanner]\nposition_mm = [0, 0, 900]\n", "hangs on an arm, too"),
        (
            "[scanner]\n",
            '[scanner]\nsource = "merged"\naddress = "x"\noptions = { views = "a, b" }\n',
            "cannot hang on an arm",
        ),
        ("[scanner]\n", "[scanner]\nwhile_moving = true\n", "waits until its arm stands still"),
        (JOINTS, "", "either the 7 joints of arm left are expected, or the scanner's pose"),
        (JOINTS, f"{JOINTS}\nposition_mm = [410, 0, 480]", "either the 7 joints of arm left"),
        (JOINTS, JOINTS.replace("-33.9", "60"), "60 for axis 2 is outside -143.5 to 43.5"),
        (JOINTS, "position_mm = [1500, 0, 480]", "the view is out of reach of arm left, "),
        ('name = "bin"', 'name = "home"', "a view cannot be called home: that is where"),
        ('name = "bin"', 'name = "bin"\nbin = "left"', "is not one of none: the cell has a single"),
        ("[scanner.on_arm.view]", f"{SECOND}[[scanner.on_arm.view]]", "'bin' is there 2 times"),
        (
            'arm = "left"',
            'arm = "left"\nmerge_views = true',
            "merge_views: there is one view only",
        ),
        ('name = "camera"', 'name = "palm"', "'palm' is a solid of tool smart_gripper"),
        ('name = "camera"', 'name = "bracket"', "'bracket' is there 2 times"),
    ],
)
def test_what_cannot_be_is_refused_by_its_key(spoil: Spoil, old: str, new: str, says: str) -> None:
    with pytest.raises(FileError, match=re.escape(says)):
        read_cell(spoil(old, new))


def test_views_are_stated_as_a_controller_shows_them_that_counts_in_its_own_way(
    tmp_path: Path,
) -> None:
    cell = read_cell(find("robots", "tx2_90") / "on_arm.toml")
    (arm,), carrier = cell.arms, cell.scanner.on_arm
    assert carrier is not None
    coupling = np.eye(6)
    coupling[2, 1] = -1
    arm = replace(arm, mapping=AxisMapping(coupling, np.deg2rad([0, 90, 0, 0, 0, 0])))
    counted = replace(spoken_to_by(cell, "pick-server"), arms=(arm,))
    path = write_cell(tmp_path / "made", counted, {})
    shutil.copytree(find("parts", "puck"), path.parent / "puck")
    again = read_cell(path).scanner.on_arm
    assert again is not None
    assert np.allclose(again.view.q, carrier.view.q, atol=1e-5)
    axes = np.rad2deg(arm.to_axes(carrier.view.q))
    views = tomllib.loads(path.read_text(encoding="utf-8"))["scanner"]["on_arm"]["view"]
    shown = axes + [0, 90, -axes[1], 0, 0, 0]
    assert np.allclose((views if isinstance(views, dict) else views[0])["joints_deg"], shown)


def test_a_written_cell_is_read_again(tmp_path: Path) -> None:
    cell = read_cell(SHIPPED / "on_arm.toml")
    path = write_cell(tmp_path / "made", cell, {})
    text = path.read_text(encoding="utf-8")
    shutil.copytree(find("parts", "keyed_cylinder"), path.parent / "keyed_cylinder")
    again = read_cell(path)
    mine, other = cell.scanner.on_arm, again.scanner.on_arm
    assert mine is not None and other is not None
    assert "[scanner.on_arm.view]" in text
    assert np.allclose(mine.view.q, other.view.q, atol=1e-6)
    assert np.allclose(mine.home, other.home, atol=1e-6)
    assert mine.T_flange_scanner.isApprox(other.T_flange_scanner, 1e-6)
    assert [solid.name for solid in other.housing] == ["camera", "bracket"]
    assert again.scanner.T_world_scanner.isApprox(cell.scanner.T_world_scanner, 1e-5)


def test_several_views_are_in_order_and_written_and_read_again(tmp_path: Path) -> None:
    cell = with_lower_view(read_cell(SHIPPED / "on_arm.toml"), merges=True)
    path = write_cell(tmp_path / "made", cell, {})
    shutil.copytree(find("parts", "keyed_cylinder"), path.parent / "keyed_cylinder")
    again = read_cell(path)
    carrier, read = cell.scanner.on_arm, again.scanner.on_arm
    assert carrier is not None and read is not None
    assert [(view.name, view.number) for view in read.views] == [("bin", 1), ("low", 2)]
    assert read.merges_views
    assert np.allclose(read.views[1].q, carrier.views[1].q, atol=1e-6)
    low = with_view(again, "low")
    assert np.array_equal(low.arm("left").home, read.views[1].q)
    assert view_name(read_cell(path)) == "bin"


def test_each_bin_has_to_be_seen(spoil: Spoil) -> None:
    two = (
        '[[bin]]\nname = "right"\nposition_mm = [410, 0, 5]\nsize_mm = [200, 300, 80]\n\n'
        '[[bin]]\nname = "left"\nposition_mm = [410, 700, 5]\nsize_mm = [200, 300, 80]\n'
    )
    path = spoil('name = "bin"', 'name = "bin"\nbin = "left"')
    text = path.read_text(encoding="utf-8")
    start = text.index("[bin]")
    end = text.index("\n\n", start)
    path.write_text(text[:start] + two + text[end:], encoding="utf-8")
    with pytest.raises(FileError, match="no view sees bin 'right'"):
        read_cell(path)


@pytest.mark.parametrize("turn", ["[0, 90, 0]", "[30, 90, -50]", "[180, -90, 20]"])
def test_a_scanner_turned_by_90_degrees_about_y_is_written_and_read_again(
    spoil: Spoil, tmp_path: Path, turn: str
) -> None:
    path = spoil("position_mm = [0, -75, 35]", f"position_mm = [0, -75, 35]\nrpy_deg = {turn}")
    cell = read_cell(path)
    again = write_cell(tmp_path / "made", cell, {})
    shutil.copytree(find("parts", "keyed_cylinder"), again.parent / "keyed_cylinder")
    mine, other = cell.scanner.on_arm, read_cell(again).scanner.on_arm
    assert mine is not None and other is not None
    assert mine.T_flange_scanner.isApprox(other.T_flange_scanner, 1e-5)


def test_a_robot_that_is_moved_takes_its_scanner_along(spoil: Spoil) -> None:
    path = spoil("parts = ", "parts = ")
    cell = read_cell(path)
    up = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.1]))
    moved = replace(cell, T_world_robot=up * cell.T_world_robot)
    assert np.allclose(
        moved.scanner.T_world_scanner.translation,
        cell.scanner.T_world_scanner.translation + [0, 0, 0.1],
    )
    save_cell(path, moved)
    assert read_cell(path).scanner.T_world_scanner.isApprox(moved.scanner.T_world_scanner, 1e-6)
