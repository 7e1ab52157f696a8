"""Two plans over a station go out together or not at all, by a simulated controller."""

import json
import subprocess
import sys

import numpy as np
import pytest

from workbench.cli.main import main
from workbench.cli.serving.approving import row_digest
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.certificates import write_certificate
from workbench.formats.plans.plan_files import read_plan
from workbench.formats.plans.pose_files import write_poses
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.proof.claims.prove import prove

CELL = find("robots", "yumi") / "regrasp.toml"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("station")
    cell = read_cell(CELL)
    place = cell.bin.T_world_bin.translation + np.array([0.03, -0.05, 0.0191])
    part = Detection("keyed_cylinder", pose_from_rpy(place, (np.pi / 2, 0.0, 0.4)))
    write_poses(folder / "poses.json", [part])
    words = ("--poses", folder / "poses.json", "--out", folder / "plan.json")
    assert main(["plan", str(CELL), *map(str, words)]) == 0
    return folder


@pytest.fixture
def robot(tmp_path):
    record = tmp_path / "arrived.jsonl"
    options = ["--port", "0", "--state-port", "0", "--speed", "50", "--until-eof", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "controller", "--cell", str(CELL)]
        + [*options, "--record", str(record)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    ports = json.loads(process.stdout.readline())
    address = ("--host", "127.0.0.1", "--port", ports["port"], "--state-port", ports["state_port"])
    record_words = ("--record", tmp_path / "approvals", "--cell", CELL)
    yield (*address, "--approve-as", "Ada", *record_words), record
    process.stdin.close()
    assert process.wait(timeout=300) == 0
    process.stdout.close()


@pytest.mark.extensive
def test_both_are_told_approved_and_sent(files, robot, say):
    plans = [files / "plan.json", files / "plan-2.json"]
    words, record = robot
    told = say("send", *plans, *words)
    assert "part-1 (keyed_cylinder)" in told.out and "to station post" in told.out
    assert told.code == 2 and "this is no terminal" in told.problem
    digest = row_digest([read_plan(plan)[0] for plan in plans])
    went = say("send", *plans, *words, "--digest", digest, "--json")
    assert went.code == 0, went.problem
    form = json.loads(went.out)
    assert [one["is_picked"] for one in (*form["parts"], *form["row"][0]["parts"])] == [True] * 2
    assert record.read_text()


@pytest.mark.extensive
@pytest.mark.parametrize(
    ("names", "problem"),
    [
        (("plan.json",), "no plan that follows takes it from there: send both in a row"),
        (("plan-2.json",), "not where a plan before puts it"),
        (("plan-2.json", "plan.json"), "no plan that follows takes it from there"),
        (("plan.json", "plan.json"), "no plan that follows takes it from there"),
    ],
)
def test_neither_goes_out_without_the_other(files, robot, say, names, problem):
    words, record = robot
    told = say("send", *[files / name for name in names], *words)
    assert told.code == 2 and problem in told.problem
    assert not record.exists() or not record.read_text()


def test_no_file_proves_the_second_alone(files, say):
    for more in ((), ("--poses", files / "poses.json")):
        told = say("verify", files / "plan-2.json", "--cell", CELL, *more)
        assert told.code == 3
        assert "part-1 of the plan is not where a plan before puts it" in told.out


def test_a_file_of_poses_does_not_say_what_a_plan_has_put_somewhere(files, say, tmp_path):
    plan, _ = read_plan(files / "plan-2.json")
    write_poses(tmp_path / "poses.json", plan.detections)
    told = say("verify", files / "plan-2.json", "--cell", CELL, "--poses", tmp_path / "poses.json")
    assert told.code == 2 and "T_world_found" in told.problem


def test_a_certificate_of_the_second_says_that_it_holds_after_the_first(files, say, tmp_path):
    plan, _ = read_plan(files / "plan-2.json")
    proof = prove(read_cell(CELL), plan.scene, plan)
    write_certificate(tmp_path / "certificate.json", plan, plan.scene, proof)
    told = say("prove", "--check", tmp_path / "certificate.json", "--cell", CELL)
    assert told.code == 0
    assert "holds only after a plan that puts part-1 where it stands" in told.out
