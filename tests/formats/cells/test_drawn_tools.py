"""Tools from CAD: made as described, written into a cell's file, taken out again."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from cad_tools import BAR, CUP, PALM, WITH_BAR, drawn_gripper, stl

from workbench.app.core.cell.making import carrying
from workbench.formats.cells.drawn_tools import CadDrawing, SuctionLip, TwoFingers, made_of
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.errors import InputError
from workbench.model.geometry import Box, pose_from_rpy


@pytest.fixture(params=["yumi", "tx2_90"])
def path(request, tmp_path):
    shutil.copytree(find("robots", request.param), tmp_path / request.param)
    return tmp_path / request.param / "cell.toml"


def test_fingers_stand_on_the_body_and_close_at_the_tcp():
    tool = made_of(drawn_gripper())
    assert tool.stroke == (0.0, 0.05) and tool.force == 20.0
    np.testing.assert_allclose(tool.T_flange_tcp.translation, (0, 0, 0.1213), atol=1e-6)
    one, other = tool.fingers
    assert isinstance(one.solid.shape, Box)
    np.testing.assert_allclose(one.solid.T_owner_shape.translation, (0.003, 0, 0.0963), atol=1e-6)
    np.testing.assert_allclose(
        other.solid.T_owner_shape.translation, (-0.003, 0, 0.0963), atol=1e-6
    )
    np.testing.assert_allclose(one.direction, (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(other.direction, (-1, 0, 0), atol=1e-12)


def test_a_drawn_finger_is_turned_for_the_other():
    one, other = made_of(drawn_gripper(takes_by=WITH_BAR)).fingers
    for finger, sides in ((one, (0, 0.007)), (other, (-0.007, 0))):
        T = finger.solid.T_owner_shape
        x = (finger.solid.shape.points @ T.rotation.T + T.translation)[:, 0]
        np.testing.assert_allclose((x.min(), x.max()), sides, atol=1e-6)


def test_a_drawing_lies_where_it_is_said_to():
    T = pose_from_rpy((0, 0, 0.02), (0, 0, np.pi / 2))
    tool = made_of(drawn_gripper(T_flange_drawing=T, begins=0.06, takes_by=CUP))
    np.testing.assert_allclose(tool.T_flange_tcp.translation, (0, 0, 0.11), atol=1e-9)
    assert tool.fingers == () and tool.press == CUP.press
    turned = made_of(drawn_gripper(T_flange_drawing=T))
    np.testing.assert_allclose(turned.fingers[0].direction, (0, 1, 0), atol=1e-12)


def test_a_body_with_a_gap_is_cut():
    """A hull would fill the room between two pillars, in which a part may be."""
    feet = (
        ((-40, -25, 0), (40, 25, 20)),
        ((-40, -25, 20), (-20, 25, 80)),
        ((20, -25, 20), (40, 25, 80)),
    )
    fork = trimesh.util.concatenate([trimesh.creation.box(bounds=one) for one in feet])
    file = np.frombuffer(fork.export(file_type="stl"), np.uint8)
    tool = made_of(drawn_gripper(body=CadDrawing("fork.stl", file), takes_by=CUP))
    hulls = [trimesh.convex.convex_hull(np.asarray(one.shape.points)) for one in tool.body[:-1]]
    assert len(hulls) > 1
    middle = [[0.0, 0.0, 0.06]]
    assert not any(hull.contains(middle)[0] for hull in hulls)


@pytest.mark.parametrize("takes_by", [drawn_gripper().takes_by, WITH_BAR, CUP])
def test_what_is_saved_is_read_again_and_taken_out(path, takes_by):
    before, cell = path.read_text(), read_cell(path)
    arm = cell.arms[0].name
    tool = made_of(drawn_gripper(takes_by=takes_by))
    save_cell(path, carrying(cell, arm, tool))
    again = read_cell(path).arm(arm)
    assert [one.name for one in again.tools] == [cell.arm(arm).tool.name, "drawn"]
    assert again.tool.name == "drawn" and again.tool.stroke == tool.stroke
    assert again.tool.reach == pytest.approx(tool.reach, abs=1e-6)
    assert (again.tool.press, again.tool.force) == (tool.press, tool.force)
    for line in before.splitlines():
        assert line in path.read_text() or line.startswith("tool = ")
    save_cell(path, cell)
    assert path.read_text() == before
    assert read_cell(path).digest == cell.digest


def test_meshes_of_two_tools_of_one_name_do_not_mix(path):
    cell = read_cell(path)
    arm = cell.arms[0].name
    for top in (50, 60):
        body = CadDrawing("palm.stl", stl((PALM[0], (40, 25, top))))
        tool = made_of(drawn_gripper(body=body, takes_by=CUP))
        save_cell(path, carrying(cell, arm, tool))
        assert read_cell(path).arm(arm).tool.reach == pytest.approx(tool.reach, abs=1e-6)
        save_cell(path, cell)


def test_another_mesh_under_the_name_of_its_file_is_not_taken_for_it(path):
    cell = read_cell(path)
    arm = cell.arms[0].name
    tool = made_of(drawn_gripper())
    grown = replace(tool, T_flange_tcp=tool.T_flange_tcp, press=0.01)
    save_cell(path, carrying(cell, arm, tool))
    with pytest.raises(InputError, match="not written"):
        save_cell(path, carrying(cell, arm, grown))


def _open_box() -> np.ndarray:
    box = trimesh.creation.box(bounds=PALM).subdivide().subdivide().subdivide()
    box.faces = box.faces[:-1]
    return np.frombuffer(box.export(file_type="stl"), np.uint8)


OTHER_SIDE = CadDrawing("bar.stl", stl(((-7, -5, 70), (0, 5, 120))))

BAD = [
    ({"name": "../../etc/passwd"}, "letters, digits"),
    ({"body": CadDrawing("palm.rar", stl(PALM))}, "is no CAD file"),
    ({"body": CadDrawing("palm.stl")}, "has 0 bytes"),
    ({"body": CadDrawing("palm.stl", stl(PALM), "furlong")}, "unit 'furlong'"),
    ({"body": CadDrawing("palm.stl", stl(PALM), "m")}, "another unit"),
    ({"body": CadDrawing("palm.stl", stl(PALM), "inch")}, "would reach 2[0-9]{3} mm"),
    ({"body": CadDrawing("palm.stl", stl(PALM, 0.1))}, "does not say its unit"),
    ({"body": CadDrawing("palm.stl", np.frombuffer(b"no mesh" * 99, np.uint8))}, "palm.stl: "),
    ({"body": CadDrawing("../../palm.stl", _open_box())}, "is not the name of a file"),
    ({"body": CadDrawing("palm.stl", _open_box())}, "^palm.stl: .*not closed"),
    ({"takes_by": TwoFingers(np.full(3, np.nan), 0.05)}, "a finger must lie between"),
    ({"takes_by": TwoFingers(np.full(3, 0.01), 9.0)}, "the stroke must lie between"),
    ({"takes_by": TwoFingers(np.full(3, 0.01), 0.05, -1.0)}, "the force must lie between"),
    ({"takes_by": SuctionLip(0.0, 0.03)}, "radius of the cup"),
    ({"takes_by": replace(WITH_BAR, drawing=OTHER_SIDE)}, "on the side of x above 0"),
    ({"begins": float("inf")}, "the beginning of fingers or cup"),
    ({"T_flange_drawing": pose_from_rpy((0, 0, 0.99))}, "would reach 1[0-9]{3} mm"),
]  # fmt: skip


@pytest.mark.parametrize(("changed", "says"), BAD)
def test_what_cannot_be_meant_is_refused_in_a_sentence(changed, says):
    given = {"name": "drawn", **changed}
    with pytest.raises(InputError, match=says) as refused:
        made_of(drawn_gripper(**given))
    assert "\n" not in str(refused.value) and "/tmp" not in str(refused.value)


def test_an_open_body_is_mended_where_that_is_wanted():
    body = CadDrawing("palm.stl", _open_box())
    assert made_of(drawn_gripper(body=body, is_mended=True)).body
    assert BAR[0][2] == PALM[1][2]
