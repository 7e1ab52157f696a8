import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors

from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.digest import digest_of
from workbench.model.errors import FileError
from workbench.model.messages.plans import PlanNote
from workbench.model.plan import UNSIGNED, Leg, Plan, Proof, Step, Strategy
from workbench.model.scan import Detection


def edited(path: Path, plan: Plan, edit: Callable[[dict[str, Any]], Any]) -> Path:
    """The plan's file after somebody has changed something in it."""
    write_plan(path, plan)
    content = json.loads(path.read_text(encoding="utf-8"))
    edit(content)
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def test_a_plan_comes_back_with_its_digest(plan: Plan, proof: Proof, tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.json", plan, proof)
    found, stated = read_plan(tmp_path / "plan.json")
    assert found.digest == stated == plan.digest
    assert found.seconds == plan.seconds


def test_a_plan_of_an_arm_of_any_name_comes_back(plan: Plan, tmp_path: Path) -> None:
    arm = replace(plan.arms[0], arm="manipulator")
    steps = tuple(Step((("manipulator", leg.name),)) for leg in arm.legs)
    alone = replace(plan, strategy=Strategy.single("manipulator"), arms=(arm,), sequence=steps)
    write_plan(tmp_path / "plan.json", alone)
    assert json.loads((tmp_path / "plan.json").read_text())["strategy"] == "manipulator"
    found, stated = read_plan(tmp_path / "plan.json")
    assert (found.strategy, found.strategy.arm) == (alone.strategy, "manipulator")
    assert found.digest == stated


@pytest.mark.parametrize("arm", ["right", "left"])
def test_what_files_have_always_called_an_arm_alone_is_that_arm(
    plan: Plan, tmp_path: Path, arm: str
) -> None:
    path = edited(tmp_path / "plan.json", plan, lambda c: c.update(strategy=arm))
    strategy = read_plan(path)[0].strategy
    assert strategy == Strategy.single(arm)
    assert (strategy.arm, strategy.words) == (arm, f"{arm} arm only")


def test_anybody_can_recompute_the_digest(plan: Plan, proof: Proof, tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.json", plan, proof)
    content = json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))
    stated = content["digest"]
    for key in ("format", "proof", "seconds", "notes", "digest"):
        content.pop(key, None)
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    assert hashlib.sha256(text.encode()).hexdigest() == stated


def test_computing_time_and_proof_are_outside_the_digest(
    plan: Plan, proof: Proof, tmp_path: Path
) -> None:
    slow = replace(plan, seconds={"route": 99.0})
    write_plan(tmp_path / "with.json", plan, proof)
    write_plan(tmp_path / "without.json", slow)
    assert read_plan(tmp_path / "with.json")[1] == read_plan(tmp_path / "without.json")[1]


def test_an_edited_waypoint_is_read_and_shows_in_the_digest(plan: Plan, tmp_path: Path) -> None:
    path = edited(
        tmp_path / "plan.json", plan, lambda c: c["arms"][0]["legs"][2]["q"][1].__setitem__(3, 1)
    )
    found, stated = read_plan(path)
    assert stated == plan.digest != found.digest
    assert found.arms[0].legs[2].q[1, 3] == 1.0


def test_each_waypoint_stands_on_one_line(plan: Plan, tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.json", plan)
    lines = [line.strip(" ,") for line in (tmp_path / "plan.json").read_text().splitlines()]
    for q in plan.arms[0].legs[0].q:
        assert str(q.tolist()) in lines


def test_the_proof_in_the_file_says_what_was_found(
    plan: Plan, proof: Proof, tmp_path: Path
) -> None:
    write_plan(tmp_path / "plan.json", plan, proof)
    summary = json.loads((tmp_path / "plan.json").read_text())["proof"]
    assert summary["holds"] is True
    assert summary["digest"] == proof.digest
    assert summary["clearance"] == 0.0074
    assert summary["nearest"]["pair"] == ["right_link_5", "bin_wall_left"]


WRONG: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "format": (lambda c: c.update(format="workbench-plan/9"), "key format.*workbench-plan/1"),
    "unknown key": (lambda c: c.update(sead=1), r"key sead: is not known here; .*'seed'"),
    "missing key": (lambda c: c.pop("guarantee"), "key guarantee: is missing"),
    "missing key of a leg": (
        lambda c: c["arms"][1]["legs"][0].pop("holding"),
        r"key arms\[2\]\.legs\[1\]\.holding: is missing",
    ),
    "missing score": (lambda c: c["detections"][0].pop("score"), r"detections\[1\]\.score"),
    "strategy": (lambda c: c.update(strategy="both"), "'both' is not one of alternated, coord"),
    "guarantee": (lambda c: c.update(guarantee=3), "guarantee: a text is expected, 3"),
    "seed": (lambda c: c.update(seed=0.5), "seed: a whole number is expected"),
    "leg name": (lambda c: c["arms"][0]["legs"][0].update(name="go"), "'go' is not one of reach"),
    "short waypoint": (
        lambda c: c["arms"][0]["legs"][1]["q"][4].pop(),
        r"arms\[1\]\.legs\[2\]\.q\[5\]: 7 numbers are expected, 6 are given",
    ),
    "waypoint of a text": (
        lambda c: c["arms"][0]["legs"][1]["q"][4].__setitem__(0, "1"),
        r"q\[5\]: a number is expected, '1' is given",
    ),
    "no waypoints": (
        lambda c: c["arms"][0]["legs"][1].update(q=[], t=[]),
        "0 waypoints; expected 1 to 585",
    ),
    "times": (
        lambda c: c["arms"][0]["legs"][1]["t"].pop(),
        r"legs\[2\]\.t: 4 times for 5 waypoints",
    ),
    "NaN": (lambda c: c["arms"][0]["legs"][1]["t"].__setitem__(0, float("nan")), "NaN is not a"),
    "detection": (lambda c: c["arms"][0].update(detection=2), "from 0 to 1"),
    "arm twice": (lambda c: c["arms"][1].update(arm="right"), "'right' is there 2 times"),
    "joint twice": (
        lambda c: c["arms"][0]["joints"].__setitem__(0, "right_joint_2"),
        r"key arms\[1\]\.joints: 'right_joint_2' is there 2 times",
    ),
    "leg that is not there": (
        lambda c: c["sequence"][0].update(runs=[["right", "wave"]]),
        r"sequence\[1\]\.runs: there is no leg 'wave' of an arm 'right'",
    ),
    "no rotation": (
        lambda c: c["arms"][0]["T_tcp_part"][0].__setitem__(0, 5.0),
        r"arms\[1\]\.T_tcp_part: .* not a rotation",
    ),
    "millimetres": (
        lambda c: c["detections"][0]["T_world_part"][0].__setitem__(3, 410.0),
        r"T_world_part: is 410 m away",
    ),
    "proof": (lambda c: c.update(proof="sound"), "proof: a table is expected"),
    "digest": (lambda c: c.update(digest=None), "digest: a text is expected"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_wrong_plan_file_is_refused_with_its_key(plan: Plan, tmp_path: Path, wrong: str) -> None:
    edit, message = WRONG[wrong]
    path = edited(tmp_path / "plan.json", plan, edit)
    with pytest.raises(FileError, match=message):
        read_plan(path)


def test_a_number_beyond_all_floats_is_refused(plan: Plan, tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.json", plan)
    text = (tmp_path / "plan.json").read_text().replace('"opening": 0.04', '"opening": 1e999', 1)
    (tmp_path / "plan.json").write_text(text)
    with pytest.raises(FileError, match="opening: a finite number is expected, inf"):
        read_plan(tmp_path / "plan.json")


def test_a_key_that_is_there_twice_is_refused(plan: Plan, tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.json", plan)
    text = (tmp_path / "plan.json").read_text().replace('"seed": 7', '"seed": 7, "seed": 8')
    (tmp_path / "plan.json").write_text(text)
    with pytest.raises(FileError, match="'seed' is there twice"):
        read_plan(tmp_path / "plan.json")


def test_a_leg_too_long_for_the_file_is_not_written(plan: Plan, tmp_path: Path) -> None:
    long = Leg("reach", "joint", False, 0.04, np.zeros((600, 7)), np.arange(600.0))
    arms = (replace(plan.arms[0], legs=(long, *plan.arms[0].legs[1:])), plan.arms[1])
    with pytest.raises(FileError, match="leg reach of arm right has 4200 numbers"):
        write_plan(tmp_path / "plan.json", replace(plan, arms=arms))
    assert list(tmp_path.iterdir()) == []


def test_a_plan_that_is_not_finite_is_not_written(plan: Plan, tmp_path: Path) -> None:
    write_plan(tmp_path / "plan.json", plan)
    with pytest.raises(FileError, match="not finite"):
        write_plan(tmp_path / "plan.json", replace(plan, seconds={"route": float("nan")}))
    assert read_plan(tmp_path / "plan.json")[0].digest == plan.digest


finite = st.floats(-1e3, 1e3)


@settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    max_examples=60,
)
@given(
    q=st.lists(st.lists(finite, min_size=7, max_size=7), min_size=1, max_size=4),
    opening=st.one_of(st.floats(0, 1), st.integers(0, 1)),
    gap=st.none() | finite,
    score=st.one_of(finite, st.integers(-3, 3)),
    note=st.text(st.characters(exclude_categories=["C", "Z"])),
    seed=st.integers(0, 2**63 - 1),
    turn=st.integers(0, 2**32 - 1),
)
def test_any_plan_survives_its_file(
    plan: Plan,
    tmp_path: Path,
    q: list[list[float]],
    opening: float,
    gap: float | None,
    score: float,
    note: str,
    seed: int,
    turn: int,
) -> None:
    pin.seed(turn)
    leg = Leg("reach", "joint", True, opening, np.array(q), np.arange(float(len(q))))
    arm = replace(plan.arms[0], legs=(leg, *plan.arms[0].legs[1:]), T_tcp_part=pin.SE3.Random())
    found = Detection("part", pin.SE3.Random(), score=score, gap=gap)
    made = replace(plan, arms=(arm, plan.arms[1]), detections=(found, found), note=note, seed=seed)
    write_plan(tmp_path / "plan.json", made)
    read, stated = read_plan(tmp_path / "plan.json")
    assert read.digest == stated == made.digest == digest_of(made, without=UNSIGNED)


@settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    max_examples=300,
)
@given(data=st.data())
def test_only_file_errors_come_out_of_broken_plan_files(
    plan: Plan, tmp_path: Path, data: st.DataObject
) -> None:
    path = tmp_path / "plan.json"
    write_plan(path, plan)
    only_file_errors(path, data.draw(mutated(path.read_bytes())), read_plan)


def test_remarks_are_outside_the_digest_and_come_back(plan: Plan, tmp_path: Path) -> None:
    notes = (PlanNote.GOES_UNSEEN(), PlanNote.NEARER(distance=0.1, threshold=0.2))
    said = replace(plan, notes=notes)
    assert said.digest == plan.digest
    write_plan(tmp_path / "plan.json", said)
    again, stated = read_plan(tmp_path / "plan.json")
    assert again.notes == notes and again.digest == stated == plan.digest
    assert again.goes_unseen and not plan.goes_unseen


def test_the_note_of_an_older_version_stays_in_the_digest(plan: Plan) -> None:
    older = replace(plan, note="the parts lie 140 mm apart")
    assert older.digest != replace(plan, note="").digest
    assert [str(one) for one in older.remarks] == ["the parts lie 140 mm apart"]


@pytest.mark.parametrize(
    ("notes", "says"),
    [
        ([3], "messages with id and args, or texts, are expected"),
        ([{"id": "plan.nearer"}], "messages with id and args, or texts, are expected"),
        (["long" * 300], "at most 30 of 1000 characters"),
        (["a\x07b"], "a character that cannot be shown"),
    ],
)
def test_remarks_that_are_none_are_refused(plan: Plan, tmp_path: Path, notes, says) -> None:
    path = edited(tmp_path / "plan.json", plan, lambda c: c.update(notes=notes))
    with pytest.raises(FileError, match=says):
        read_plan(path)
