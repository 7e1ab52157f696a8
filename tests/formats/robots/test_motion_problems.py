"""Motion problems in files: what is in them, and what is refused."""

import json
from copy import deepcopy

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from motion_stand_in import BALL, BEHIND, POST, make_motion_problems, problem, write_set
from mutations import mutated, only_file_errors
from stand_ins import DATA, sources

from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Box, Cylinder, Sphere


@pytest.fixture
def folder(tmp_path):
    make_motion_problems(tmp_path / "problems")
    return tmp_path / "problems"


def test_sets_come_in_the_order_of_their_files(folder):
    sets = read_motion_problems(folder)
    assert [one.name for one in sets] == ["free", "in_the_way"]
    assert [one.robot for one in sets] == ["planar", "planar"]
    assert [one.name for one in sets[1].problems] == ["past the ball", "into the ball", "beyond"]


def test_shapes_lie_where_both_poses_together_put_them(folder):
    write_set(folder / "free.json", "planar", "free", [problem("all", [BEHIND, POST, BALL])])
    box, post, ball = read_motion_problems(folder)[0].problems[0].obstacles
    assert isinstance(box.shape, Box) and box.shape.size.tolist() == [0.1, 0.1, 0.1]
    assert isinstance(post.shape, Cylinder)
    assert (post.shape.length, post.shape.radius) == (1.0, 0.08)
    assert isinstance(ball.shape, Sphere) and ball.shape.radius == 0.1
    # Half a turn about z: what lies at -0.3 in the object's frame is beyond its origin at 0.5.
    assert np.allclose(post.T_owner_shape.translation, (0.8, 0, 0))
    assert np.allclose(ball.T_owner_shape.translation, (0.9, 0, 0))


def test_joints_that_are_not_planned_are_fixed_where_the_problem_has_them(folder):
    one = read_motion_problems(folder)[0].problems[0]
    assert one.joints == ("turn1", "turn2", "turn3")
    slide = one.robot.joint("slide")
    assert slide.kind == "fixed"
    assert np.allclose(slide.T_parent_joint.translation, (0.41, 0, 0))
    assert np.allclose(one.start, (1.2, -0.3, -0.2))


def test_one_robot_of_a_folder_with_several(tmp_path):
    make_motion_problems(tmp_path / "a", "first")
    make_motion_problems(tmp_path / "b", "second")
    assert [one.robot for one in read_motion_problems(tmp_path)] == ["first"] * 2 + ["second"] * 2
    assert [one.robot for one in read_motion_problems(tmp_path, "second")] == ["second"] * 2
    with pytest.raises(InputError, match=r"no problems for robot 'third'.*first, second"):
        read_motion_problems(tmp_path, "third")


def test_a_folder_that_is_missing_or_empty_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        read_motion_problems(tmp_path / "nowhere")
    with pytest.raises(InputError, match="no motion problems"):
        read_motion_problems(tmp_path)


def changed(content: dict, keys: tuple, value: object) -> dict:
    content = deepcopy(content)
    place = content["problems"][0]
    for key in keys[:-1]:
        place = place[key]
    if value is None:
        del place[keys[-1]]
    else:
        place[keys[-1]] = value
    return content


@pytest.mark.parametrize(
    ("keys", "value", "sentence"),
    [
        (("start",), None, r"problems\[1\].start: is missing"),
        (("start", "turn2"), None, "start: joint 'turn2' is missing"),
        (("goal", "turn2"), None, "goal: the joints of start are expected"),
        (("goal", "elbow"), 0.1, "goal.elbow: robot planar has no such joint"),
        (("start", "turn1"), "left", "start.turn1: a number is expected"),
        (("start", "turn1"), 90.0, "start.turn1: 90 is not between"),
        (("others",), None, "start: joint 'slide' is missing, here and in others"),
        (("obstacles", 0, "shape"), "cone", "shape: 'cone' is not one of box, cylinder, sphere"),
        (("obstacles", 0, "dimensions"), [0.1], "dimensions: 3 numbers are expected, 1 are given"),
        (("obstacles", 0, "dimensions"), [0.1, 0.0, 1], "dimensions: all have to be larger"),
        (("obstacles", 0, "pose", "orientation"), [0, 0, 0, 0], "orientation: is not a unit"),
        (("obstacles", 0, "pose"), None, "pose: is missing"),
    ],
)
def test_a_wrong_value_is_refused_with_its_file_and_key(folder, keys, value, sentence):
    path = folder / "free.json"
    path.write_text(json.dumps(changed(json.loads(path.read_text()), keys, value)))
    with pytest.raises(FileError, match=sentence) as refused:
        read_motion_problems(folder)
    assert str(refused.value).startswith(str(path))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('"turn1": NaN', "NaN is not a JSON number"),
        ('"turn1": 1e999', "a finite number is expected"),
    ],
)
def test_a_number_that_is_not_finite_is_refused(folder, text, sentence):
    path = folder / "free.json"
    path.write_text(path.read_text().replace('"turn1": 1.2', text))
    with pytest.raises(FileError, match=sentence):
        read_motion_problems(folder)


def test_a_set_without_problems_or_robot_is_refused(folder):
    write_set(folder / "free.json", "planar", "free", [])
    with pytest.raises(FileError, match="key problems: there are none"):
        read_motion_problems(folder)
    write_set(folder / "free.json", "stranger", "free", [problem("one", [])])
    with pytest.raises(FileError, match=r"stranger\.urdf is not beside"):
        read_motion_problems(folder)
    write_set(folder / "free.json", "../planar", "free", [problem("one", [])])
    with pytest.raises(FileError, match="is not the name of a robot"):
        read_motion_problems(folder)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=mutated(json.dumps({"format": "motion-problems/1", "robot": "planar", "set": "s",
       "problems": [problem("one", [BEHIND, POST, BALL])]}).encode()))  # fmt: skip
def test_a_broken_file_is_read_or_refused_in_one_sentence(folder, content):
    only_file_errors(folder / "free.json", content, lambda path: read_motion_problems(path.parent))


@pytest.mark.parametrize("source", sources("motion_problems"))
def test_every_problem_names_the_joints_of_one_arm(source, folder):
    sets = read_motion_problems(DATA / "motion_problems" if source == "real" else folder)
    for one in (one for each in sets for one in each.problems):
        movable = [joint.name for joint in one.robot.joints if joint.kind != "fixed"]
        assert list(one.joints) == movable
        assert one.start.shape == one.goal.shape == (len(movable),)
        assert one.obstacles
