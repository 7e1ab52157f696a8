"""Plan files that somebody has made to do harm: a sentence and an exit code, and none ever holds.

Each stands in a file without a digest, as another program would write it, so that what is wrong has
to be found and not that the file was changed.
"""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.cli.exits import BAD_INPUT, SUCCESS
from workbench.cli.exits import NO_PLAN as NO_PROOF
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import plan_content
from workbench.model.geometry import pose_from_rpy
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import Plan
from workbench.model.scan import Detection

LONGEST = 600
"""Characters of a line that is still a sentence."""

Content = dict[str, Any]


@pytest.fixture(scope="module")
def made() -> Plan:
    """A plan of two arms that holds."""
    cell = read_cell("yumi")
    floor = cell.bin.T_world_bin.translation
    pile = tuple(
        Detection(
            "keyed_cylinder", pose_from_rpy(floor + [x, 7 * x, 0.0191], (np.pi / 2, 0, -40 * x))
        )
        for x in (-0.01, 0.01)
    )
    plan = plan_pick(cell, pile, "scan", strategy="alternated").plan
    assert plan is not None
    return plan


@pytest.fixture(scope="module")
def good(made: Plan) -> str:
    """It, as another program would write it."""
    content = plan_content(made)
    for key in ("digest", "proof", "seconds"):
        del content[key]
    return json.dumps(content)


def sentence_of(said) -> str:
    """What was said of a plan that is refused: one line, or the violations of its proof."""
    assert "Traceback" not in said.out + said.err
    if said.code == BAD_INPUT:
        text = said.problem
    else:
        assert said.code == NO_PROOF and said.err == ""
        assert "the proof does not hold:" in said.out
        text = said.out
    assert all(len(line) <= LONGEST for line in text.splitlines())
    return text


def leg_of(content: Content, name: str, arm: int = 0) -> Content:
    return content["arms"][arm]["legs"][LEG_NAMES.index(name)]


def way(q: list[list[float]], name: str = "reach") -> Callable[[Content], None]:
    """A leg with these waypoints between where it begins and ends, slowly."""

    def edit(content: Content) -> None:
        leg = leg_of(content, name)
        leg["q"] = [leg["q"][0], *q, leg["q"][-1]]
        leg["t"] = [1000.0 * k for k in range(len(leg["q"]))]

    return edit


def legs_at_once(content: Content) -> None:
    """Both arms at the same time from the first leg to the last."""
    first, second = content["arms"]
    content["sequence"] = [
        {"runs": [[first["arm"], name], [second["arm"], name]]} for name in LEG_NAMES
    ]


def times(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Content], None]:
    def edit(content: Content) -> None:
        leg = leg_of(content, "return")
        leg["t"] = change(np.array(leg["t"])).tolist()

    return edit


def all_openings(opening: float) -> Callable[[Content], None]:
    def edit(content: Content) -> None:
        for leg in content["arms"][0]["legs"]:
            leg["opening"] = opening

    return edit


def with_tcp(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Content], None]:
    def edit(content: Content) -> None:
        arm = content["arms"][0]
        arm["T_tcp_part"] = change(np.array(arm["T_tcp_part"])).tolist()

    return edit


def shifted(x: float) -> Callable[[np.ndarray], np.ndarray]:
    def change(T: np.ndarray) -> np.ndarray:
        T[0, 3] += x
        return T

    return change


LONG = "y" * 200_000

TURNS = [[0.0] * 7, [0.1] * 7]

AS_READ: dict[str, tuple[Callable[[Content], Any], str]] = {
    "no arms": (lambda c: c.update(arms=[]), "there is no leg 'reach' of an arm"),
    "arms of null": (lambda c: c.update(arms=None), "key arms: an array of tables is expected"),
    "an arm that is a number": (lambda c: c.update(arms=[3, 4]), "entry 1 is 3"),
    "no joints": (lambda c: c["arms"][0].update(joints=[]), "joints: 0 are given"),
    "a key too few": (lambda c: c["arms"][0].pop("grasp"), "arms[1].grasp: is missing"),
    "a key too many": (lambda c: c["arms"][0].update(speed=9), "arms[1].speed: is not known here"),
    "an empty step": (lambda c: c["sequence"][0].update(runs=[]), "a step runs at least one leg"),
    "a step of three": (
        lambda c: c["sequence"][0].update(runs=[["right", "reach", "fast"]]),
        "2 texts are expected, 3 are given",
    ),
    "100,000 waypoints": (way(TURNS * 50_000), "100002 waypoints; expected 1 to 585"),
    "100,000 steps": (
        lambda c: c.update(sequence=c["sequence"][:1] * 100_000),
        "100000 are given, at most 1000 are read",
    ),
    "a whole number of 400 digits": (lambda c: c.update(seed=10**400), "key seed:"),
    "a waypoint of 400 digits": (way([[10**400] * 7]), "a finite number is expected"),
    "a joint at 1e308": (way([[1e308] * 7]), "1e+308, no joint turns so far"),
    "a joint beyond all": (way([[1001.0] * 7]), "no joint turns so far"),
    "a true for a number": (way([[True] * 7]), "a number is expected, True is given"),
    "a time of 1e308": (times(lambda t: t + 1e308), "1e+308 is not between 0 and 1e+06"),
    "times before the start": (times(lambda t: t - 1.0), "-1 is not between 0 and 1e+06"),
    "fingers beyond all": (all_openings(1e308), "1e+308 is not between 0 and 1"),
    "fingers further than closed": (all_openings(-0.01), "-0.01 is not between 0 and 1"),
    "a part far away": (with_tcp(shifted(500.0)), "500 m away"),
    "a part mirrored": (with_tcp(lambda T: np.diag([1.0, 1.0, -1.0, 1.0]) @ T), "not a rotation"),
    "a part blown up": (with_tcp(lambda T: np.diag([1e200, 1.0, 1.0, 1.0]) @ T), "not a rotation"),
    "a detection before the first": (lambda c: c["arms"][0].update(detection=-1), "from 0 to 1"),
    "a detection of a half": (lambda c: c["arms"][0].update(detection=0.5), "a whole number"),
    "a cell of nothing": (lambda c: c.update(cell=""), "key cell: is an empty text"),
    "a cell that is not there": (lambda c: c.update(cell="../../no such"), "no such"),
    "a cell that is a device": (lambda c: c.update(cell="/dev/zero"), "/dev/zero"),
    "a cell of a long name": (lambda c: c.update(cell=LONG), "has 200000 characters"),
    "a part of a long name": (
        lambda c: c["detections"][0].update(part=LONG),
        "has 200000 characters",
    ),
    "a grasp of a long name": (lambda c: c["arms"][0].update(grasp=LONG), "has 200000 characters"),
    "a leg of a long name": (
        lambda c: c["sequence"][0].update(runs=[[LONG, "reach"]]),
        "there is no leg",
    ),
}
"""What the file itself is refused for."""

AS_PROVEN: dict[str, tuple[Callable[[Content], Any], str]] = {
    "no steps": (lambda c: c.update(sequence=[]), "not every leg once, in order"),
    "no legs": (
        lambda c: (c["arms"][0].update(legs=[]), c.update(sequence=c["sequence"][6:])),
        "the legs are not reach, approach",
    ),
    "one arm left out": (lambda c: c.update(sequence=c["sequence"][:6]), "every leg once"),
    "times that go back": (times(lambda t: t[::-1]), "times that do not increase"),
    "times that stand still": (times(lambda t: t * 0.0), "times that do not increase"),
    "times of no length": (times(lambda t: np.arange(len(t)) * 5e-324), "faster than the joints"),
    "times that begin late": (times(lambda t: t + 1.0), "does not begin at 0 s"),
    "another cell's digest": (lambda c: c.update(cell_digest="5" * 64), "for another cell"),
    "a hand that holds the part elsewhere": (with_tcp(shifted(0.02)), "not where the hand closes"),
    "a hand that holds the part 15 m away": (with_tcp(shifted(15.0)), "not where the hand closes"),
    "one part for both arms": (
        lambda c: c["arms"][1].update(detection=c["arms"][0]["detection"]),
        "an arm or a part is used twice",
    ),
    "a part that is there twice": (
        lambda c: c["detections"].append(c["detections"][c["arms"][0]["detection"]]),
        "within the safety margin of",
    ),
    "a part that nobody knows": (
        lambda c: c["detections"].append({**c["detections"][0], "part": "brick"}),
        "the cell knows no part brick",
    ),
    "a grasp that nobody knows": (
        lambda c: c["arms"][0].update(grasp="by magic"),
        "the part has no grasp by magic",
    ),
    "joints in another order": (lambda c: c["arms"][0]["joints"].reverse(), "joints are not those"),
    "a long joint": (lambda c: c["arms"][0]["joints"].__setitem__(0, LONG), "joints are not those"),
    "an arm twice in a step": (
        lambda c: c["sequence"][0].update(runs=c["sequence"][0]["runs"] * 2),
        "an arm twice",
    ),
    "an arm a thousand times in a step": (
        lambda c: c["sequence"][0].update(runs=c["sequence"][0]["runs"] * 1000),
        "an arm twice",
    ),
    "both at once, called one at a time": (legs_at_once, "does not move one arm after the other"),
    "both at once, called alternated": (
        lambda c: (legs_at_once(c), c.update(guarantee="time-independent")),
        "move one after the other",
    ),
    "both at once, called coordinated": (
        lambda c: (
            legs_at_once(c),
            c.update(guarantee="synchronised", strategy="coordinated"),
            c["arms"][1].update(detection=c["arms"][0]["detection"]),
        ),
        "used twice",
    ),
    "one arm of two": (lambda c: c.update(strategy=c["arms"][0]["arm"]), "is not what the plan"),
    "fingers wider than the stroke": (all_openings(0.9), "outside the stroke"),
    "one waypoint": (
        lambda c: leg_of(c, "return").update(q=leg_of(c, "return")["q"][:1], t=[0.0]),
        "waypoints of shape (1, 7)",
    ),
    "a joint that turns 159 times": (way([[999.0] * 7]), "is outside"),
    "all joints to and fro between 1000 rad": (
        way([[1000.0] * 7, [-1000.0] * 7] * 290, "approach"),
        "is outside",
    ),
    "all joints to and fro": (way([[-0.9] * 7, [0.4] * 7] * 10), "leg reach"),
    "nothing said to be in the hand": (
        lambda c: leg_of(c, "return").update(holding=False),
        "states wrongly whether the part is in the hand",
    ),
    "a free way called straight": (
        lambda c: leg_of(c, "return").update(motion="linear"),
        "is called linear, which it is not",
    ),
    "a hundred boxes around everything": (
        lambda c: c.update(
            obstacles=[{"T_world_box": np.eye(4).tolist(), "size": [100.0] * 3}] * 100
        ),
        "within the safety margin of",
    ),
}
"""What is read, and what its proof says against it."""


def written(path: Path, good: str, edit: Callable[[Content], Any]) -> Path:
    content = json.loads(good)
    edit(content)
    path.write_text(json.dumps(content))
    return path


def refused(say, path: Path, code: int, says: str) -> None:
    """By all commands that take plans."""
    for words in (("verify", path), ("prove", path, "--out", path.with_name("own.json"))):
        said = say(*words)
        assert said.code == code
        assert says in sentence_of(said)
    said = say("send", path, "--approve-as", "Ada", "--host", "127.0.0.1", "--port", 9)
    assert said.code == BAD_INPUT and said.out == "" and said.problem
    assert not path.with_name("own.json").exists()


def test_what_is_bent_held_before(good, say, tmp_path):
    (tmp_path / "plan.json").write_text(good)
    assert say("verify", tmp_path / "plan.json").code == SUCCESS


@pytest.mark.parametrize("name", AS_READ)
def test_a_file_that_makes_no_sense_is_not_read(good, say, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    edit, says = AS_READ[name]
    refused(say, written(tmp_path / "plan.json", good, edit), BAD_INPUT, says)


@pytest.mark.parametrize("name", AS_PROVEN)
def test_a_plan_that_makes_no_sense_does_not_hold(good, say, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    edit, says = AS_PROVEN[name]
    refused(say, written(tmp_path / "plan.json", good, edit), NO_PROOF, says)


AS_TEXT = {
    "a key twice": ('"guarantee"', '"guarantee": "x", "guarantee"', "'guarantee' is there twice"),
    "a key of a leg twice": (
        '"holding": true',
        '"holding": true, "holding": false',
        "'holding' is there twice",
    ),
    "NaN": ('"seed": 0', '"seed": NaN', "NaN is not a JSON number"),
    "Infinity": ('"seed": 0', '"seed": -Infinity', "-Infinity is not a JSON number"),
    "beyond all": ('"seed": 0', '"seed": 1e999', "a whole number is expected, inf is given"),
    "5000 digits": ('"seed": 0', f'"seed": {"1" * 5000}', "is not valid JSON"),
    "very deep": ('"seed": 0', f'"seed": {"[" * 100_000}{"]" * 100_000}', "nested too deeply"),
    "deep": ('"seed": 0', f'"seed": {"[" * 200}{"]" * 200}', "a whole number is expected"),
    "a long key": ('"seed": 0', f'"{LONG}": 1, "seed": 0', "is not known here"),
    "half a letter": ('"note": "', '"note": "\\ud800', "cannot be printed"),
    "no letter": ('"note": "', '"note": "\\u0000', "cannot be printed"),
    "17 MB": ('"note": "', f'"note": "{"y" * 17_000_000}', "is longer than 16 MB"),
    "no beginning": ("{", "", "is not valid JSON"),
    "no end": ('{"', '[{"', "is not valid JSON"),
}


@pytest.mark.parametrize("name", AS_TEXT)
def test_what_no_json_library_writes_is_not_read(good, say, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    old, new, says = AS_TEXT[name]
    assert old in good
    (tmp_path / "plan.json").write_text(good.replace(old, new, 1))
    refused(say, tmp_path / "plan.json", BAD_INPUT, says)


def test_a_part_that_the_poses_do_not_have_is_found(good, say, made, tmp_path):
    """A plan taken at its word holds; beside what is known it does not."""

    def leaves_one_out(content: Content) -> None:
        content["detections"][1]["T_world_part"][2][3] += 0.0001

    path = written(tmp_path / "plan.json", good, leaves_one_out)
    poses = tmp_path / "poses.json"
    known = [{"part": d.part, "T_world_part": d.T_world_part.homogeneous.tolist()}
             for d in made.detections]  # fmt: skip
    poses.write_text(json.dumps({"format": "workbench-poses/1", "detections": known}))
    said = say("verify", path, "--poses", poses)
    assert said.code == NO_PROOF and "leaves out part-2 of the scan" in sentence_of(said)


def test_two_arms_at_once_are_refused_where_the_controller_moves_one(made, say, tmp_path):
    """Also by an alternated plan, whose second arm sets out while the first goes home.

    There is time for a stop at each waypoint.
    """
    folder = Path(shutil.copytree(find("robots", "yumi"), tmp_path / "yumi"))
    text = (folder / "cell.toml").read_text()
    assert '"abb-socket/2"' in text
    (folder / "cell.toml").write_text(text.replace('"abb-socket/2"', '"abb-socket"'))
    assert any(len(step.runs) == 2 for step in made.sequence)
    arms = (
        replace(one, legs=tuple(replace(leg, t=leg.t * 4) for leg in one.legs)) for one in made.arms
    )
    made = replace(made, arms=tuple(arms))
    plan, certificate = tmp_path / "plan.json", tmp_path / "certificate.json"
    plan.write_text(json.dumps(plan_content(made)))
    assert say("prove", plan, "--certificate", certificate).code == SUCCESS
    for words in (("verify", plan), ("prove", plan, "--out", tmp_path / "o.json"),
                  ("prove", "--check", certificate)):  # fmt: skip
        said = say(*words, "--cell", folder)
        assert said.code == NO_PROOF
        assert "moves one arm at a time" in sentence_of(said)
    assert not (tmp_path / "o.json").exists()
