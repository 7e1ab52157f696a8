"""Grippers of URDF files become tools: straight fingers, linkages, cups, and what is none."""

import shutil
from pathlib import Path

import made_arm
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.grippers.grippers import gripper_of, hand_beyond
from workbench.formats.robots.descriptions import read_description
from workbench.model.errors import InputError

BOX = '<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>'


def link(name: str, size: str = "", at: str = "0 0 0") -> str:
    return f'<link name="{name}">{BOX.format(at=at, size=size) if size else ""}</link>'


def joint(name: str, kind: str, parent: str, child: str, xyz: str, axis: str, more: str) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def limits(low: float, high: float) -> str:
    return f'<limit lower="{low}" upper="{high}" velocity="1" effort="1"/>'


def mimic(leader: str, factor: float) -> str:
    return f'{limits(-2, 2)}<mimic joint="{leader}" multiplier="{factor}"/>'


PALM = link("palm", "0.08 0.06 0.06", "0 0 0.03")
FINGERS = link("a", "0.01 0.02 0.05", "0.005 0 0.025") + link(
    "b", "0.01 0.02 0.05", "-0.005 0 0.025"
)
SLIDES = (
    PALM
    + FINGERS
    + joint("ja", "prismatic", "palm", "a", "0 0 0.06", "1 0 0", limits(0, 0.02))
    + joint("jb", "prismatic", "palm", "b", "0 0 0.06", "-1 0 0", "{follows}")
)


def crank(side: int) -> str:
    """A crank of 50 mm that swings, and a tip at its end that stays upright."""
    name, x = "ab"[side < 0], 0.03 * side
    leader = limits(0, 0.6) if side > 0 else mimic("crank_a", -1)
    return (
        link(f"crank_{name}", "0.01 0.02 0.05", "0 0 0.025")
        + link(f"tip_{name}", "0.01 0.02 0.03", f"{-0.005 * side - 0.02 * side} 0 0.015")
        + joint(
            f"crank_{name}", "revolute", "palm", f"crank_{name}", f"{x} 0 0.06", "0 1 0", leader
        )
        + joint(
            f"tip_{name}",
            "revolute",
            f"crank_{name}",
            f"tip_{name}",
            "0 0 0.05",
            "0 1 0",
            mimic("crank_a", -side),
        )
    )


LINKAGE = PALM + crank(1) + crank(-1)


def write(folder: Path, body: str) -> Path:
    path = folder / "gripper.urdf"
    path.write_text(f'<robot name="made up">{body}</robot>', encoding="utf-8")
    return path


def tool(folder: Path, body: str, widest: float | None = None):
    return gripper_of(read_description(write(folder, body)), "made-up", widest)


@pytest.mark.parametrize("follows", [mimic("ja", 1), limits(0, 0.02)])
def test_fingers_that_slide_open_by_both_their_travels(tmp_path, follows):
    made, notes = tool(tmp_path, SLIDES.format(follows=follows))
    assert made.stroke == pytest.approx((0.0, 0.04))
    assert made.T_flange_tcp.translation == pytest.approx([0, 0, 0.11])
    assert made.T_flange_tcp.rotation[:, 2] == pytest.approx([0, 0, 1])
    assert abs(made.T_flange_tcp.rotation[0, 1]) == pytest.approx(1), "fingers close along its y"
    assert [solid.name for solid in made.body] == ["palm_0"]
    for finger, sense in zip(made.fingers, (1, -1), strict=True):
        assert finger.direction == pytest.approx([sense, 0, 0])
        x = finger.solid.shape.points[:, 0] * sense
        assert (x.min(), x.max()) == pytest.approx((0, 0.01), abs=1e-6)
    assert "open by 0.0 to 40.0 mm" in notes[0]


def test_carriages_that_pass_the_middle_do_not_close_the_fingers(tmp_path):
    carriage = BOX.format(at="0 0 -0.005", size="0.04 0.02 0.01")
    body = SLIDES.format(follows=mimic("ja", 1)).replace("</link>", f"{carriage}</link>")
    made, _ = tool(tmp_path, body)
    assert made.stroke == pytest.approx((0.0, 0.04))


def inside(hull_points: np.ndarray, points: np.ndarray) -> bool:
    planes = ConvexHull(hull_points).equations
    return bool((points @ planes[:, :3].T + planes[:, 3] <= 1e-5).all())


def test_a_linkage_is_never_larger_than_its_tool_says(tmp_path):
    made, notes = tool(tmp_path, LINKAGE, widest=0.2)
    assert made.stroke == pytest.approx((0.0, 0.1 * np.sin(0.6)), abs=1e-6)
    corners = np.array(np.meshgrid([-0.005, 0.005], [-0.01, 0.01], [0, 0.03])).reshape(3, -1).T
    by_side = {float(np.sign(f.direction[0])): f for f in made.fingers}
    for q in np.linspace(0, 0.6, 200):
        opening = 2 * 0.05 * np.sin(q)
        for side, finger in by_side.items():
            at = [side * (0.03 + 0.05 * np.sin(q) - 0.025), 0, 0.06 + 0.05 * np.cos(q)]
            tip = corners + at
            assert inside(finger.solid.shape.points + finger.direction * opening / 2, tip)
    assert made.T_flange_tcp.translation[2] == pytest.approx(0.06 + 0.05 * np.cos(0.6) + 0.03)
    assert {solid.name for solid in made.body} == {"palm_0", "crank_a", "crank_b"}
    assert any("counted as body at all places" in note for note in notes)


def test_unless_somebody_wants_more_tips_come_forward_by_five_millimetres(tmp_path):
    made, notes = tool(tmp_path, LINKAGE)
    z = [np.ptp(finger.solid.shape.points[:, 2]) - 0.03 for finger in made.fingers]
    assert max(z) <= 0.005
    assert 0.03 < made.stroke[1] < 0.1 * np.sin(0.6)
    assert any("--widest-mm takes more of it" in note for note in notes)


def test_what_does_not_move_sucks_by_its_end(tmp_path):
    cup = '<link name="cup"><collision><origin xyz="0.01 0 0.1"/><geometry>'
    cup += '<cylinder radius="0.01" length="0.04"/></geometry></collision></link>'
    fixed = joint("j", "fixed", "palm", "cup", "0 0 0", "0 0 1", "")
    made, (note,) = tool(tmp_path, PALM + cup + fixed)
    assert not made.fingers and made.T_flange_tcp.translation == pytest.approx([0.01, 0, 0.12])
    assert np.linalg.det(made.T_flange_tcp.rotation) == pytest.approx(1)
    assert "one lip of 20 mm" in note


def test_what_moves_without_a_body_sucks_too(tmp_path):
    wheel = '<link name="wheel"/>' + joint(
        "j", "revolute", "palm", "wheel", "0 0 0", "0 0 1", limits(0, 1)
    )
    made, _ = tool(tmp_path, PALM + wheel)
    assert not made.fingers


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ('<link name="nothing"/>', "has no solids"),
        (PALM + link("a", "0.01 0.02 0.05", "0.05 0 0.1")
         + joint("ja", "prismatic", "palm", "a", "0 0 0", "1 0 0", limits(0, 0.02)),
         "two fingers are expected, 1 link moves"),
        (SLIDES.format(follows=limits(0, 0.02)) + link("c", "0.01 0.01 0.01")
         + joint("jc", "revolute", "palm", "c", "0 0 0", "0 0 1", limits(0, 1)),
         "3 joints move on their own"),
        (SLIDES.format(follows=mimic("ja", 1)) + link("c", "0.02 0.01 0.05", "0 0.005 0.025")
         + joint("jc", "prismatic", "palm", "c", "0 0 0.06", "0 1 0", mimic("ja", 1)),
         "c is a third one"),
        (PALM + FINGERS
         + joint("ja", "prismatic", "palm", "a", "0 0 0.06", "1 0 0", limits(0, 0.02))
         + joint("jb", "prismatic", "palm", "b", "0 0 0.06", "-1 0 0", mimic("jb", 1)),
         "joint jb mimics itself"),
        (PALM + FINGERS
         + joint("ja", "prismatic", "palm", "a", "0 0 0.06", "1 0 0", mimic("jb", 1))
         + joint("jb", "prismatic", "palm", "b", "0 0 0.06", "-1 0 0", mimic("ja", 1)),
         "joint ja mimics itself"),
        (PALM + FINGERS
         + joint("ja", "prismatic", "palm", "a", "0 0 0.06", "0 0 1", limits(0, 0.02))
         + joint("jb", "prismatic", "palm", "b", "0 0 0.06", "0 0 1", mimic("ja", 1)),
         "do not move apart along a line"),
    ],
)  # fmt: skip
def test_what_is_no_gripper_is_refused_in_one_sentence(tmp_path, body, says):
    with pytest.raises(InputError, match=says):
        tool(tmp_path, body)


@pytest.mark.parametrize("widest", [1e-6, 0.004, 0.0449])
def test_what_is_never_opened_as_far_as_it_is_when_closed_is_refused(tmp_path, widest):
    apart = SLIDES.replace('xyz="0.005 0', 'xyz="0.025 0').replace('xyz="-0.005 0', 'xyz="-0.025 0')
    with pytest.raises(
        InputError, match=r"opens by 40.0 to 80.0 mm, so --widest-mm is more than 45"
    ):
        tool(tmp_path, apart.format(follows=mimic("ja", 1)), widest)


def test_a_flat_finger_is_refused(tmp_path):
    mesh = tmp_path / "flat.stl"
    corners = "".join(
        f"vertex {x} {y} {z}\n" for x, y, z in ((0, 0, 0), (0, 0.02, 0), (0, 0, 0.05))
    )
    facet = f"facet normal 1 0 0\nouter loop\n{corners}endloop\nendfacet\n"
    mesh.write_text(f"solid x\n{facet}endsolid x\n", encoding="utf-8")
    drawn = f'<visual><geometry><mesh filename="file://{mesh}"/></geometry></visual>'
    body = PALM + f'<link name="a">{drawn}</link><link name="b">{drawn}</link>'
    body += joint("ja", "prismatic", "palm", "a", "0.01 0 0.06", "1 0 0", limits(0, 0.02))
    body += joint("jb", "prismatic", "palm", "b", "-0.01 0 0.06", "-1 0 0", mimic("ja", 1))
    with pytest.raises(InputError, match="link a is flat"):
        tool(tmp_path, body)


def test_a_cell_is_made_with_a_gripper_from_its_file_and_gets_another_one(
    tmp_path, monkeypatch, capsys
):
    shutil.copytree(find("robots", "yumi"), tmp_path / "robots" / "mine")
    cell = tmp_path / "robots" / "mine" / "cell.toml"
    file = write(tmp_path, SLIDES.format(follows=mimic("ja", 1)))
    assert main(["cell", "tool", str(cell), str(file), "--arm", "left"]) == 0
    assert "tool made_up, 1 solids and two fingers" in capsys.readouterr().out
    right, left = read_cell(cell).arms
    assert (right.tool.name, left.tool.name) == ("smart_gripper", "made_up")
    assert left.tool.stroke == pytest.approx((0.0, 0.04), abs=1e-6)
    assert main(["cell", "tool", str(cell), str(file)]) == 2
    assert "is there already" in capsys.readouterr().err
    assert main(["cell", "tool", str(cell), str(file), "--name", "x", "--widest-mm", "0"]) == 2


def with_hand(fingers: str) -> str:
    mounted = fingers.replace("palm", "hand") + joint(
        "hand_mount", "fixed", "tool0", "hand", "0 0 0", "0 0 1", ""
    )
    return made_arm.arm(more=mounted)


@pytest.mark.extensive
def test_a_robot_with_a_hand_in_its_file_gets_it_as_its_tool(tmp_path, capsys):
    robot = tmp_path / "arm.urdf"
    robot.write_text(with_hand(SLIDES.format(follows=mimic("ja", 1))), encoding="utf-8")
    assert main(["cell", "new", "own", "--urdf", str(robot), "--out", str(tmp_path / "own")]) == 0
    assert "open by 0.0 to 40.0 mm" in capsys.readouterr().out
    (arm,) = read_cell(tmp_path / "own" / "cell.toml").arms
    assert (arm.tool.name, len(arm.tool.fingers)) == ("hand", 2)


@pytest.mark.extensive
def test_a_hand_that_serves_nowhere_is_replaced_and_named(tmp_path, capsys):
    robot = tmp_path / "arm.urdf"
    short = SLIDES.replace("0.01 0.02 0.05", "0.01 0.02 0.004").replace("0.08 0.06", "0.3 0.3")
    robot.write_text(with_hand(short.format(follows=mimic("ja", 1))), encoding="utf-8")
    assert main(["cell", "new", "own", "--urdf", str(robot), "--out", str(tmp_path / "own")]) == 0
    assert "the arms carry a gripper of the usual size" in capsys.readouterr().out
    (arm,) = read_cell(tmp_path / "own" / "cell.toml").arms
    assert arm.tool.name == "gripper"


def test_coarse_models_of_a_hand_are_no_part_of_its_tool(tmp_path):
    coarse = link("palm_sc", "0.3 0.3 0.3", "0 0 0.1")
    coarse += joint("jsc", "fixed", "palm", "palm_sc", "0 0 0", "0 0 1", "")
    made, _ = tool(tmp_path, SLIDES.format(follows=mimic("ja", 1)) + coarse)
    assert [solid.name for solid in made.body] == ["palm_0"]


def test_of_a_whole_robot_only_what_moves_beyond_the_flange_is_a_hand(tmp_path):
    plate = link("plate", "0.1 0.1 0.01")
    fixed = joint("j", "fixed", "palm", "plate", "0 0 0.1", "0 0 1", "")
    found = read_description(write(tmp_path, PALM + plate + fixed))
    assert hand_beyond(found, found.robot, "palm") is None
