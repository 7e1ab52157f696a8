import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors
from scipy.spatial import ConvexHull

from workbench.formats.files.shipped import find
from workbench.formats.meshes.mesh_cache import cache_folder
from workbench.formats.parts.reading import read_grasps, read_part
from workbench.model.errors import FileError
from workbench.model.geometry import finest
from workbench.model.part import Grasp, GraspPattern

SHIPPED = find("parts", "keyed_cylinder")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the shipped part to spoil."""
    return Path(shutil.copytree(SHIPPED, tmp_path / "part"))


def changed(path: Path, old: str, new: str) -> Path:
    text = path.read_text(encoding="utf-8")
    assert text.count(old) >= 1, f"{old!r} is not in {path.name}"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def library(tmp_path: Path, text: str) -> tuple[Grasp | GraspPattern, ...]:
    (tmp_path / "grasps.toml").write_text(text, encoding="utf-8")
    return read_grasps(tmp_path / "grasps.toml").entries


TOP = """[[grasp]]
name = "top"
position_mm = [0, 0, 30]
points_along = [0, 0, -2]
closes_along = [0, 1, 0]
opening_mm = 40
grip_mm = 30
"""


def test_a_part_is_found_by_name_by_folder_and_by_file(folder: Path) -> None:
    digest = read_part("keyed_cylinder").digest
    assert read_part(folder).digest == digest
    assert read_part(str(folder / "part.toml")).digest == digest


def test_grasps_are_counted_with_the_symmetry(folder: Path) -> None:
    """Written out they would take minutes, and more memory than there is."""
    changed(folder / "part.toml", "fold = 1\n", "fold = 60\n")
    pattern = f"[grasp.pattern]\nangles_deg = [{', '.join(map(str, range(180)))}]\n"
    (folder / "grasps.toml").write_text(TOP + pattern)
    expected = "grasps.toml: stands for 10,800 grasps with the symmetry written out; 10,000 are all"
    with pytest.raises(FileError, match=expected):
        read_part(folder)


def test_what_stays_upright_is_read_and_changes_the_digest(folder: Path) -> None:
    plain = read_part(folder)
    assert plain.upright is None
    path = folder / "part.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "\n[upright]\naxis = [0, 0, -2]\ntilt_deg = 10\n", encoding="utf-8")
    stated = read_part(folder)
    assert stated.upright is not None and stated.upright.tolist() == [0.0, 0.0, -1.0]
    assert stated.tilt == pytest.approx(np.deg2rad(10)) and stated.digest != plain.digest


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [
        ("tilt_deg = 0", "tilt_deg"),
        ("tilt_deg = 90", "tilt_deg"),
        ("axis = [0, 0, 1]", "tilt_deg"),
        ("tilt_deg = 10\naxis = [0, 0, 0]", "axis"),
        ("tilt_deg = 10\nup = 1", "up"),
    ],
)
def test_a_wrong_tilt_is_one_sentence(folder: Path, keys: str, wrong: str) -> None:
    path = folder / "part.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text + f"\n[upright]\n{keys}\n", encoding="utf-8")
    with pytest.raises(FileError, match=wrong):
        read_part(folder)


def test_friction_is_read_and_changes_the_digest_only_where_it_is_stated(folder: Path) -> None:
    plain = read_part(folder)
    assert plain.friction is None
    path = changed(folder / "part.toml", "mass_g = 120\n", "mass_g = 120\nfriction = 0.4\n")
    stated = read_part(folder)
    assert stated.friction == 0.4 and stated.digest != plain.digest
    changed(path, "friction = 0.4", "friction = 40")
    with pytest.raises(FileError, match="friction"):
        read_part(folder)


def test_a_part_without_grasps_is_a_part(folder: Path) -> None:
    (folder / "grasps.toml").unlink()
    assert read_part(folder).library.grasps == ()


@pytest.mark.extensive
def test_a_part_without_pieces_is_divided(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
    cache_folder.cache_clear()
    whole = read_part(folder)
    toml = folder / "part.toml"
    toml.write_text(toml.read_text().partition("[[piece]]")[0])
    divided = read_part(folder)
    cache_folder.cache_clear()
    pieces = finest(divided.pieces)
    assert len(divided.pieces) <= 16 and len(pieces) > 1
    assert all(piece.shape.is_convex for piece in pieces)
    volume = sum(ConvexHull(piece.shape.points).volume for piece in pieces)
    cylinder, collar = (s.shape.radius**2 * s.shape.length * np.pi for s in whole.pieces[:2])
    assert 0.9 < volume / (cylinder + 0.4 * collar) < 1.6


def test_a_grasp_is_read_in_metres_and_radians(tmp_path: Path) -> None:
    more = 'free_rotation_deg = 90\npriority = 2\nenabled = false\narms = ["left"]\n'
    (top,) = library(tmp_path, TOP + more)
    assert isinstance(top, Grasp)
    assert top.T_part_tcp.translation.tolist() == [0, 0, 0.03]
    assert top.T_part_tcp.rotation.tolist() == [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]
    assert (top.opening, top.grip, top.approach_length) == (0.04, 0.03, 0.06)
    assert top.free_rotation == pytest.approx(np.pi / 2)
    assert (top.priority, top.is_enabled, top.arms, top.retreat) == (2, False, ("left",), None)


def test_a_pattern_turns_about_its_axis_and_moves_along_it(tmp_path: Path) -> None:
    pattern = "[grasp.pattern]\naxis = [0, 0, 5]\nangles_deg = [0, 90]\noffsets_mm = [-10, 0, 10]\n"
    side = TOP.replace("[0, 0, 30]", "[20, 0, 0]").replace("[0, 0, -2]", "[-1, 0, 0]")
    (entry,) = library(tmp_path, side + pattern)
    assert isinstance(entry, GraspPattern)
    assert [grasp.name for grasp in entry.grasps] == [
        "top-1-1",
        "top-1-2",
        "top-2-1",
        "top-2-2",
        "top-3-1",
        "top-3-2",
    ]
    T = entry.grasps[3].T_part_tcp
    np.testing.assert_allclose(T.translation, [0, 0.02, 0], atol=1e-15)
    np.testing.assert_allclose(T.rotation[:, 2], [0, -1, 0], atol=1e-15)
    last = entry.grasps[5].T_part_tcp.translation
    np.testing.assert_allclose(last, [0, 0.02, 0.01], atol=1e-15)


WRONG_GRASPS = {
    "unknown key": (TOP + "opening = 3\n", r"grasp\[1\]\.opening: is not known here; did you mean"),
    "no position": (TOP.replace("position_mm", "positon_mm"), r"position_mm: is missing"),
    "no direction": (TOP.replace("[0, 0, -2]", "[0, 0, 0]"), "points_along: has no direction"),
    "not across": (TOP.replace("[0, 1, 0]", "[0, 1, 1]"), "closes_along: must be perpendicular"),
    "grip": (TOP.replace("grip_mm = 30", "grip_mm = 41"), "grip_mm: is wider than opening_mm"),
    "opening": (TOP.replace("opening_mm = 40", "opening_mm = -1"), "-1 is not between 0 and 1000"),
    "name twice": (TOP + TOP, "the grasp name 'top' is used 2 times"),
    "empty pattern": (TOP + "[grasp.pattern]\nangles_deg = []\n", "angles_deg: is an empty list"),
    "flat pattern": (TOP + "pattern = 5\n", "pattern: a table is expected, 5"),
    "too many": (
        TOP + f"[grasp.pattern]\nangles_deg = {[0] * 200}\noffsets_mm = {[0] * 200}\n",
        "stands for more than 10000 grasps",
    ),
}


@pytest.mark.parametrize("wrong", WRONG_GRASPS)
def test_wrong_grasps_are_refused_with_their_key(tmp_path: Path, wrong: str) -> None:
    text, message = WRONG_GRASPS[wrong]
    with pytest.raises(FileError, match=rf"grasps\.toml: .*{message}"):
        library(tmp_path, text)


WRONG_PARTS: dict[str, tuple[Callable[[Path], object], str]] = {
    "unknown key": (
        lambda f: changed(f / "part.toml", "mass_g", "mass_kg"),
        "key mass_g: is missing; a number is expected",
    ),
    "mass": (lambda f: changed(f / "part.toml", "mass_g = 120", "mass_g = 0"), "0 is not between"),
    "shape": (lambda f: changed(f / "part.toml", '"box"', '"cone"'), r"piece\[3\]\.shape: 'cone'"),
    "fold": (lambda f: changed(f / "part.toml", "fold = 1", "fold = -1"), r"symmetry\.fold: -1"),
    "unit": (lambda f: changed(f / "part.toml", '"mm"', '"cm"'), "unit: 'cm' is not one of mm, m"),
    "no mesh": (lambda f: (f / "keyed_cylinder.stl").unlink(), "there is no such file"),
    "broken mesh": (lambda f: (f / "keyed_cylinder.stl").write_bytes(b"solid"), "keyed_cylinder"),
    "grasps": (lambda f: changed(f / "grasps.toml", "[0, 1, 0]", "[1, 1, 0]"), "perpendicular"),
}


@pytest.mark.parametrize("wrong", WRONG_PARTS)
def test_a_wrong_part_is_refused_with_file_and_key(folder: Path, wrong: str) -> None:
    spoil, message = WRONG_PARTS[wrong]
    spoil(folder)
    with pytest.raises(FileError, match=message):
        read_part(folder)


def test_an_unknown_part_is_refused_with_those_that_are_there() -> None:
    with pytest.raises(FileError, match=r"under parts/ \(there is .*keyed_cylinder"):
        read_part("cube")


@settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_only_file_errors_come_out_of_broken_parts(tmp_path: Path, data: st.DataObject) -> None:
    folder = Path(shutil.copytree(SHIPPED, tmp_path / "part", dirs_exist_ok=True))
    name = data.draw(st.sampled_from(["part.toml", "grasps.toml", "keyed_cylinder.stl"]))
    content = data.draw(mutated((SHIPPED / name).read_bytes()))
    only_file_errors(folder / name, content, lambda _: read_part(folder))
