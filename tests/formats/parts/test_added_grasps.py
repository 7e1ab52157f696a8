"""Grasps written into files that people write."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.files.shipped import find
from workbench.formats.parts.grasp_files import add_grasps
from workbench.formats.parts.reading import read_grasps
from workbench.model.errors import FileError
from workbench.model.part import Grasp


def grasp(name: str) -> Grasp:
    T = pin.SE3(pin.exp3(np.array([0.3, -1.2, 0.7])), np.array([0.0123456, -0.02, 0.3]))
    return Grasp(
        name,
        T,
        0.04,
        0.03,
        approach=np.array([0.0, 0.6, 0.8]),
        approach_length=0.05,
        retreat=np.array([0.0, 0.0, -1.0]),
        retreat_length=0.07,
        priority=3,
        is_enabled=False,
        arms=("left",),
        free_rotation=0.5,
        tool="cup",
        tilt=0.2,
        slide=0.012,
    )


def test_what_is_added_is_read_again_and_the_rest_stays(tmp_path):
    path = tmp_path / "grasps.toml"
    before = (find("parts", "keyed_cylinder") / "grasps.toml").read_text()
    path.write_text(before)
    assert add_grasps(path, [grasp("new"), grasp("new"), grasp("side-1-1")]) == (
        "new",
        "new-2",
        "side-1-1-2",
    )
    assert path.read_text().startswith(before.rstrip())
    library = read_grasps(path)
    assert len(library.grasps) == 18
    read, given = library.grasps[15], grasp("new")
    assert np.allclose(read.T_part_tcp.homogeneous, given.T_part_tcp.homogeneous, atol=1e-6)
    for key in (
        "opening",
        "grip",
        "approach_length",
        "retreat_length",
        "free_rotation",
        "tilt",
        "slide",
    ):
        assert getattr(read, key) == pytest.approx(getattr(given, key), abs=1e-6)
    assert (read.priority, read.is_enabled, read.arms, read.tool) == (3, False, ("left",), "cup")
    assert read.approach == pytest.approx(given.approach)
    assert read.retreat == pytest.approx(given.retreat)


def test_a_name_of_a_pattern_is_taken(tmp_path):
    """A pattern holds no grasp of its own name, and yet the name is that of an entry."""
    path = tmp_path / "grasps.toml"
    path.write_text((find("parts", "keyed_cylinder") / "grasps.toml").read_text())
    assert add_grasps(path, [grasp("side")]) == ("side-2",)


def test_a_file_that_is_not_there_is_made(tmp_path):
    path = tmp_path / "grasps.toml"
    assert add_grasps(path, [grasp("first")]) == ("first",)
    assert [one.name for one in read_grasps(path).grasps] == ["first"]
    assert [item.name for item in tmp_path.iterdir()] == ["grasps.toml"]


def test_a_file_that_cannot_be_read_is_left_as_it_is(tmp_path):
    path = tmp_path / "grasps.toml"
    path.write_text("[[grasp]]\nname = 3\n")
    with pytest.raises(FileError, match="name"):
        add_grasps(path, [grasp("new")])
    assert path.read_text() == "[[grasp]]\nname = 3\n"


def test_what_could_not_be_read_again_is_not_written(tmp_path):
    path = tmp_path / "grasps.toml"
    path.write_text("")
    bad = grasp("bad")
    wide = Grasp("wide", bad.T_part_tcp, opening=0.01, grip=0.02)
    with pytest.raises(FileError, match="grip_mm"):
        add_grasps(path, [wide])
    assert path.read_text() == ""
    assert [item.name for item in tmp_path.iterdir()] == ["grasps.toml"]
