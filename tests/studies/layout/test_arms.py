"""Arms found by their chains, and what stands still while they move."""

from itertools import pairwise

import made_arm
import numpy as np
import pytest

from workbench.formats.robots.descriptions import read_description
from workbench.model.errors import InputError
from workbench.studies.layout.arms import ends_of, right_first, standing, without_hands

FINGER = '<link name="{0}"/>'
TORSO = made_arm.turning("turn", "foot", "waist")


@pytest.fixture
def described(tmp_path):
    return lambda text: read_description(made_arm.written(tmp_path / "arm.urdf", text))


def moving(found, flanges, **fixed):
    robot, _ = without_hands(found.robot, flanges)
    there = {joint.name for joint in robot.joints}
    followers = [one for one in found.followers if one.joint.name in there]
    return standing(robot, followers, flanges, fixed)


def fingers(*names: str, mimic: str = "") -> str:
    links = "".join(FINGER.format(name) for name in names)
    first, *others = names
    follows = f'<mimic joint="{mimic}"/>' if mimic else ""
    return (
        links
        + made_arm.turning(f"j_{first}", "tool0", first)
        + "".join(made_arm.turning(f"j_{name}", "tool0", name, follows) for name in others)
    )


def long_finger(name: str) -> str:
    """As many joints as an arm needs at least."""
    links = ["tool0", *(f"{name}_{number}" for number in range(4))]
    return "".join(
        FINGER.format(link) + made_arm.turning(f"j_{link}", before, link)
        for before, link in pairwise(links)
    )


@pytest.mark.parametrize(
    "hand",
    [
        "",
        fingers("one", "two", mimic="j_one"),
        fingers("one", "two", "three"),
        fingers("finger"),
        fingers("gripper_left")
        + made_arm.turning("j_tip", "gripper_left", "tip")
        + '<link name="tip"/>',
        "".join(long_finger(name) for name in ("one", "two", "three")),
    ],
    ids=["no hand", "a follower", "three fingers", "one finger", "two joints", "long fingers"],
)
def test_the_arm_ends_before_its_hand(described, hand):
    found = described(made_arm.arm(more=hand))
    assert ends_of(found.robot, found.followers) == ("s6",)


def test_the_last_axis_belongs_to_the_arm_though_it_turns_a_link_named_gripper(described):
    fingers = "".join(
        FINGER.format(name) + made_arm.turning(f"j_{name}", "s6", name) for name in ("up", "down")
    )
    text = made_arm.arm(more=fingers).replace('"s6"', '"gripper_link"')
    assert ends_of(described(text).robot) == ("gripper_link",)


@pytest.mark.parametrize(
    ("flanges", "ordered"),
    [
        (("L_link7", "R_link7"), ("R_link7", "L_link7")),
        (("left_tool0", "right_tool0"), ("right_tool0", "left_tool0")),
        (("link_l", "link_r"), ("link_r", "link_l")),
        (("tool0", "tool_1"), ("tool0", "tool_1")),
    ],
)
def test_the_right_arm_comes_first_however_sides_are_written(flanges, ordered):
    assert right_first(flanges) == ordered


@pytest.mark.parametrize("at", ["s1", "s2", "s3"])
def test_rods_beside_an_arm_do_not_end_it(described, at):
    rod = FINGER.format("rod") + made_arm.turning("j_rod", at, "rod", '<mimic joint="a3"/>')
    found = described(made_arm.arm(more=rod))
    assert ends_of(found.robot, found.followers) == ("s6",)
    told = moving(found, ["tool0"])
    assert any("rod (follows a3)" in note for note in told.notes)
    assert [j.name for j in told.robot.joints if j.kind != "fixed"] == [
        f"a{k}" for k in range(1, 7)
    ]


def test_an_arm_whose_own_joint_follows_another_is_refused(described):
    text = made_arm.arm().replace(
        '<axis xyz="1 0 0"/>', '<axis xyz="1 0 0"/><mimic joint="a2" multiplier="-1"/>', 1
    )
    found = described(text)
    with pytest.raises(
        InputError, match=r"joint a4 follows joint a2 \(mimic\) and carries the tool"
    ):
        moving(found, ["tool0"])
    still = moving(found, ["tool0"], a4=0.5)
    assert [j.name for j in still.robot.joints if j.kind != "fixed"] == [
        "a1",
        "a2",
        "a3",
        "a5",
        "a6",
    ]


def test_two_arms_on_a_torso_are_found_and_the_torso_stands(described):
    found = described(made_arm.two_arms(TORSO))
    assert set(ends_of(found.robot)) == {"left_s6", "right_s6"}
    told = moving(found, ["right_s6", "left_s6"])
    assert all(joint.kind == "fixed" for joint in told.robot.joints if joint.name == "turn")
    (note,) = told.notes
    assert "joint turn moves both arms and stands at 0 degrees: --fix turn=VALUE" in note
    assert "its range: -57.2958 to 114.592 degrees" in note


def test_a_torso_stands_where_a_person_says_and_takes_along_what_follows_it(described):
    other = FINGER.format("other") + made_arm.turning(
        "back", "foot", "other", '<mimic joint="turn" multiplier="-1"/>'
    )
    found = described(made_arm.two_arms(TORSO + other))
    told = moving(found, ["right_s6", "left_s6"], turn=0.5)
    assert told.notes == ()
    for name, angle in (("turn", 0.5), ("back", -0.5)):
        R = next(j.T_parent_joint.rotation for j in told.robot.joints if j.name == name)
        assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(angle)


def test_a_torso_that_one_arm_only_follows_stands_as_well(described):
    text = made_arm.two_arms(
        TORSO
        + FINGER.format("back")
        + made_arm.turning("follow", "foot", "back", '<mimic joint="turn"/>')
    )
    text = text.replace(
        '<parent link="waist"/><child link="left_base"/>',
        '<parent link="back"/><child link="left_base"/>',
    )
    told = moving(described(text), ["right_s6", "left_s6"])
    assert any("joint turn moves both arms" in note for note in told.notes)


def test_what_belongs_to_no_arm_stands_and_is_named(described):
    head = FINGER.format("head") + made_arm.turning("nod", "base", "head")
    told = moving(described(made_arm.arm(more=head)), ["tool0"])
    assert any("belong to no arm and stand: nod at 0 degrees" in note for note in told.notes)


@pytest.mark.parametrize(
    ("fixed", "problem"),
    [
        ({"nobody": 0.0}, "robot made has no joint 'nobody'"),
        ({"tool0_mount": 0.0}, "--fix tool0_mount: the joint cannot move"),
        ({"a1": 4.0}, "--fix a1=229.183: its range is -170.168 to 170.168 degrees"),
    ],
)
def test_a_joint_is_not_fixed_where_it_cannot_be(described, fixed, problem):
    with pytest.raises(InputError, match=problem):
        moving(described(made_arm.arm()), ["tool0"], **fixed)


def test_an_arm_of_four_axes_is_found_where_there_is_no_longer_one(described):
    names = ("b", "c", "d", "e")
    links = "".join(FINGER.format(name) for name in ("a", *names))
    turns = "".join(made_arm.turning(f"j{n}", p, n) for p, n in zip("abcd", names, strict=True))
    turns = turns.replace('name="jd" type="revolute"', 'name="jd" type="prismatic"')
    assert ends_of(described(f'<robot name="scara">{links}{turns}</robot>').robot) == ("e",)
    short = turns.replace('name="je" type="revolute"', 'name="je" type="fixed"')
    with pytest.raises(InputError, match="name the links that carry tools with --flange"):
        ends_of(described(f'<robot name="scara">{links}{short}</robot>').robot)
