"""The whole line by typing: scan, localize, plan, verify, send."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from workbench.formats.plans.plan_files import read_plan
from workbench.formats.plans.pose_files import read_poses


def test_found_parts_are_where_they_truly_are(line):
    truth = read_poses(line.truth, "keyed_cylinder")
    found = read_poses(line.poses, "keyed_cylinder")
    assert len(found) == len(truth) == 2
    for detection in found:
        off = [
            np.linalg.norm(detection.T_world_part.translation - one.T_world_part.translation)
            for one in truth
        ]
        assert min(off) < 0.001


def test_the_same_seed_gives_the_same_files(line, say, tmp_path):
    scan, poses, plan = (tmp_path / name for name in ("s.ply", "p.json", "plan.json"))
    assert say("scan", "yumi", "--out", scan, "--seed", 1).code == 0
    assert scan.read_bytes() == line.scan.read_bytes()
    said = say("localize", "yumi", "--scan", scan, "--out", poses, "--rejected")
    assert said.code == 0
    assert "Rejected" in said.out and "why it is none" in said.out
    assert poses.read_bytes() == line.poses.read_bytes()
    assert say("plan", "yumi", "--poses", poses, "--out", plan).code == 0
    assert read_plan(plan)[0].digest == read_plan(line.plan)[0].digest


def test_plan_tells_its_times_and_candidates(line, say, tmp_path):
    said = say("plan", "yumi", "--poses", line.poses, "--out", tmp_path / "plan.json", "--json")
    assert said.code == 0
    told = json.loads(said.out)
    assert told["ok"] is True
    assert len(told["candidates"]) == 60
    assert told["proof"]["holds"] is True
    assert told["planning_ms"] > 0
    assert told["start_ms"] > 0
    assert set(told["stages_ms"]) == {"propose", "resolve", "route", "prove"}


def test_what_only_the_scan_shows_is_kept_clear_of(line, say, tmp_path):
    poses, out = tmp_path / "one.json", tmp_path / "plan.json"
    content = json.loads(line.poses.read_text())
    content["detections"] = content["detections"][:1]
    poses.write_text(json.dumps(content))
    asked = ("--poses", poses, "--scan", line.scan)
    said = say("plan", "yumi", *asked, "--out", out)
    assert said.code == 0
    assert "only the scan shows" in said.out
    plan, _ = read_plan(out)
    other = read_poses(line.poses, "keyed_cylinder")[1].T_world_part.translation
    away = [np.linalg.norm(box.T_world_box.translation - other) for box in plan.obstacles]
    assert min(away) < 0.06
    assert say("verify", out).code == 0
    explained = json.loads(say("explain", "yumi", *asked, "--json").out)
    assert explained["ok"] is True


def test_one_arm_when_asked_for(line, say, tmp_path):
    for arm in ("right", "left"):
        out = tmp_path / f"{arm}.json"
        said = say("plan", "yumi", "--poses", line.poses, "--out", out, "--strategy", arm)
        if said.code == 0:
            assert [one.arm for one in read_plan(out)[0].arms] == [arm]
        else:
            assert said.code == 3
            assert not out.exists()


@pytest.mark.extensive
def test_a_second_opinion_is_asked_where_the_bin_is_known(line, say, tmp_path):
    """By the poses and the scan; a plan that knows less of the bin than they do is refused."""
    for known in (("--poses", line.poses), ("--scan", line.scan)):
        said = say("verify", line.plan, *known)
        assert said.code == 0, said.out
        assert "the proof holds" in said.out
    poses, plan = tmp_path / "one.json", tmp_path / "plan.json"
    content = json.loads(line.poses.read_text())
    content["detections"] = content["detections"][:1]
    poses.write_text(json.dumps(content))
    assert say("plan", "yumi", "--poses", poses, "--out", plan).code == 0
    assert say("verify", plan).code == 0, "the plan's own word"
    for known in (("--poses", line.poses), ("--scan", line.scan)):
        said = say("verify", plan, *known)
        assert said.code == 3
        assert "the plan leaves out" in said.out


def test_verify_holds_what_was_planned(line, say):
    said = say("verify", line.plan)
    assert said.code == 0
    assert "the proof holds" in said.out
    told = json.loads(say("verify", line.plan, "--json").out)
    assert (told["ok"], told["stated_digest"]) == (True, told["digest"])


def test_what_arrives_is_what_was_planned(line, send, robot):
    address = ["--host", "127.0.0.1", "--port", robot.port, "--state-port", robot.state_port]
    said = send(line.plan, *address, "--json")
    assert said.code == 0, said.err
    plan, _ = read_plan(line.plan)
    told = json.loads(said.out)
    assert (told["digest"], told["approved_by"]) == (plan.digest, "Ada")
    assert told["watched"] is False
    # The first waypoint of a leg is where the arm stands already.
    expected = [
        (arm, q)
        for step in plan.sequence
        for arm, leg in step.runs
        for q in np.asarray(plan.arm(arm).leg(leg).q)[1:]
    ]
    assert [one["arm"] for one in robot.arrived] == [arm for arm, _ in expected]
    np.testing.assert_allclose(
        [one["q"] for one in robot.arrived], [q for _, q in expected], atol=1e-9
    )


def test_worlds_are_exported_for_every_leg(line, say, tmp_path):
    said = say("export-world", "yumi", "--out", tmp_path / "worlds", "--plan", line.plan)
    assert said.code == 0
    plan, _ = read_plan(line.plan)
    *worlds, robot = map(Path, said.out.split())
    assert robot == tmp_path / "worlds" / "robot.rob"
    assert {world.name for world in worlds} == {"world.xml"}
    names = {world.parent.name for world in worlds}
    assert len(names) == 1 + len(plan.sequence)
    assert all(Path(word).is_file() for word in said.out.split())


def test_demo_prints_one_object_and_nothing_else(tmp_path):
    """In a process of its own: whatever a library prints at its end would show, too."""
    ended = subprocess.run(
        [sys.executable, "-m", "workbench", "demo", "--json", "--speed", "50", "--seed", "1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    at_work = r"demo: .* \((\d+% after )?\d+ s\)\n"
    assert re.fullmatch(f"({at_work})*", ended.stderr)
    told = json.loads(ended.stdout)
    assert told["ok"] is True
    assert [row["stage"] for row in told["stages"]] == [
        "scan",
        "find parts",
        "plan",
        "approve",
        "send",
    ]
    (cycle,) = told["cycles"]
    assert cycle["parts_placed"] == len(cycle["plan"]["arms"])
    assert (tmp_path / "sessions").is_dir()
    assert Path(tmp_path, told["session"]).is_dir()
