"""A session as an MCAP file, opened by somebody else's reader and judged by the session."""

import base64
import json
import shutil
from collections import defaultdict
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.records.replay import replay
from workbench.app.records.session_archive import open_journal
from workbench.app.records.sessions import cell_of
from workbench.planning.kinematics.robot import Kinematics

pytest.importorskip("mcap", reason="mcap is not installed: pip install 'workbench[mcap]'")

from mcap.reader import make_reader

from workbench.extras.mcap.session import export_mcap

EXAMPLE = Path(__file__).resolve().parents[3] / "sessions" / "example"


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """The example with what was written of it: folder, entries with states, cell, file."""
    folder = Path(shutil.copytree(EXAMPLE, tmp_path_factory.mktemp("mcap") / "example"))
    journal = open_journal(folder)
    try:
        cell = cell_of(journal)
        path = folder.parent / "x.mcap"
        export_mcap(journal, path)
        return list(replay(journal, cell)), cell, path
    finally:
        journal.close()


@pytest.fixture(scope="module")
def messages(session):
    """Topic -> (time [ns], schema's name, content), in the order of time."""
    found = defaultdict(list)
    with session[2].open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
            found[channel.topic].append((message.log_time, schema.name, json.loads(message.data)))
    return dict(found)


@pytest.mark.extensive
def test_every_message_is_what_its_schema_says(session):
    jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")
    judges, count = {}, 0
    with session[2].open("rb") as file:
        for schema, _, message in make_reader(file).iter_messages():
            if schema.id not in judges:
                content = json.loads(schema.data)
                jsonschema.Draft202012Validator.check_schema(content)
                judges[schema.id] = jsonschema.Draft202012Validator(content)
                assert content["title"] == schema.name
            judges[schema.id].validate(json.loads(message.data))
            count += 1
    assert count > 400 and len(judges) == 7


def test_the_log_is_that_of_the_session(session, messages):
    entries, _, _ = session
    log = [content for _, _, content in messages["/log"]]
    assert [one["line"] for one in log] == [entry.number for entry, _ in entries]
    assert [one["name"] for one in log] == [entry.actor for entry, _ in entries]
    assert log[-1]["message"] == "ReportPick: Ada reports: part-1 was picked"
    for (at, schema, content), (entry, _) in zip(messages["/log"], entries, strict=True):
        assert schema == "foxglove.Log" and content["level"] == 2
        assert at == content["timestamp"]["sec"] * 10**9 + content["timestamp"]["nsec"]
        assert at / 1e9 == pytest.approx(entry.at, abs=1e-6)


def test_a_scan_is_its_points_in_the_world(session, messages):
    scan = next(state.scan for _, state in session[0] if state.scan is not None)
    [(_, schema, content)] = messages["/scan"]
    assert schema == "foxglove.PointCloud" and content["point_stride"] == 12
    assert [(one["name"], one["offset"]) for one in content["fields"]] == [
        ("x", 0),
        ("y", 4),
        ("z", 8),
    ]
    points = np.frombuffer(base64.b64decode(content["data"]), "<f4").reshape(-1, 3)
    T = posed(content["pose"]["position"], content["pose"]["orientation"])
    seen = points @ T.rotation.T + T.translation
    assert content["frame_id"] == "cell_world"
    assert np.abs(seen - scan.points_world).max() < 1e-6


def test_parts_and_verdicts_and_plan_are_told_when_they_were_made(session, messages):
    entries, _, _ = session
    state = entries[-1][1]
    assert [len(content["poses"]) for _, _, content in messages["/parts"]] == [0, 2]
    pose = messages["/parts"][-1][2]["poses"][0]
    found = posed(pose["position"], pose["orientation"])
    assert found.isApprox(state.detections[0].T_world_part, 1e-9)

    [(at, _, judged)] = messages["/verdicts"]
    made = next(entry for entry, one in entries if one.plan is not None)
    assert at / 1e9 == pytest.approx(made.at, abs=1e-6)
    assert judged["verdict"]["reason"] == "ok"
    assert [one["says"] for one in judged["candidates"]] == [
        str(one.verdict) for one in state.candidates
    ]
    assert len({one["reason"] for one in judged["candidates"]}) > 1

    [(_, _, plan)] = messages["/plan"]
    assert plan["digest"] == state.plan.digest and plan["proof"]["holds"] is True
    legs = [leg for arm in plan["arms"] for leg in arm["legs"]]
    assert [leg["q"] for leg in legs] == [
        leg.q.tolist() for arm in state.plan.arms for leg in arm.legs
    ]


def test_joints_are_those_that_the_controller_had_reported(session, messages):
    reported = [entry for entry, _ in session[0] if entry.joints]
    assert len(messages["/joints"]) == len(reported) == 2
    for (_, _, content), entry in zip(messages["/joints"], reported, strict=True):
        assert {one["name"]: one["position"] for one in content["joints"]} == entry.joints


def test_frames_are_those_of_the_planned_motion(session, messages):
    entries, cell, _ = session
    sent = next(entry for entry, _ in entries if type(entry.command).__name__ == "SendPlan")
    plan = entries[-1][1].plan
    joints = {at: content for at, _, content in messages["/planned_joints"]}
    frames = dict((at, content) for at, _, content in messages["/tf"])
    motion = sorted(at for at in joints if at / 1e9 >= sent.at - 1e-6)
    assert (motion[-1] - motion[0]) / 1e9 == pytest.approx(plan.cycle_seconds, abs=1e-5)
    assert max(np.diff(motion)) < 0.051e9
    kinematics = Kinematics(cell)
    for at in motion[::20]:
        values = {one["name"]: one["position"] for one in joints[at]["joints"]}
        poses = kinematics.link_poses(values)
        seen = {"cell_world": pin.SE3.Identity()}
        for one in frames[at]["transforms"]:
            T = posed(one["translation"], one["rotation"])
            seen[one["child_frame_id"]] = seen[one["parent_frame_id"]] * T
        assert set(seen) == {"cell_world", *poses}
        for link, T in poses.items():
            assert seen[link].isApprox(T, 1e-6), link
    # What the plan says of an arm's last leg is where it stands at the end.
    last = {one["name"]: one["position"] for one in joints[motion[-1]]["joints"]}
    for arm in plan.arms:
        assert [last[joint] for joint in cell.arm(arm.arm).joints] == pytest.approx(
            arm.legs[-1].q[-1].tolist()
        )


def posed(vector, turn) -> pin.SE3:
    quaternion = pin.Quaternion(turn["w"], turn["x"], turn["y"], turn["z"])
    return pin.SE3(quaternion.matrix(), np.array([vector["x"], vector["y"], vector["z"]]))
