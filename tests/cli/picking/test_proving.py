"""Certificates of proofs, and plans that other programs have made."""

import json
from pathlib import Path

import pytest

POSES = Path(__file__).resolve().parents[2] / "cells" / "public_yumi" / "Poses.txt"


@pytest.fixture
def certificate(line, say, tmp_path):
    path = tmp_path / "proof.json"
    said = say("prove", line.plan, "--poses", line.poses, "--certificate", path)
    assert said.code == 0, said.err
    return path


def changed(path, change):
    """The file with its content changed, under another name."""
    content = json.loads(path.read_text())
    change(content)
    other = path.with_name("changed.json")
    other.write_text(json.dumps(content))
    return other


def resigned(path, change):
    """The same, by somebody who knows how digests are made."""
    from workbench.model.digest import digest_of

    def change_and_sign(content):
        change(content)
        del content["digest"]
        content["digest"] = digest_of(content)

    return changed(path, change_and_sign)


def test_a_certificate_is_checked_and_says_what_it_holds_for(line, say, certificate):
    said = say("prove", "--check", certificate)
    plan = json.loads(line.plan.read_text())
    assert said.code == 0 and "the proof holds" in said.out
    for digest in (plan["digest"], plan["cell_digest"], plan["scan_digest"]):
        assert digest in said.out
    assert "pin " in said.out and "coal " in said.out and "workbench " in said.out
    found = json.loads(say("prove", line.plan, "--poses", line.poses, "--json").out)
    checked = json.loads(say("prove", "--check", certificate, "--json").out)
    assert checked["ok"]
    assert checked["proof"]["clearance_mm"] == pytest.approx(found["proof"]["clearance_mm"])
    assert checked["proof"]["checks"] < found["proof"]["checks"]


def test_nothing_in_a_certificate_is_believed(say, certificate):
    def more(content):
        content["proof"]["clearance"] += 0.001

    def nearer(content):
        content["proof"]["clearances"][0]["at_least"][2] += 0.05

    def none(content):
        content["proof"]["clearances"] = []

    for change in (more, nearer, none):
        said = say("prove", "--check", changed(certificate, change))
        assert said.code == 2 and "was changed after" in said.err
        said = say("prove", "--check", resigned(certificate, change))
        assert said.code == 3 and "than was stated" in said.out


def test_a_certificate_is_refused_where_the_cell_or_the_scan_is_another(say, line, certificate):
    said = say("prove", "--check", certificate, "--cell", "tx2_90")
    assert said.code == 3 and "another cell" in said.out

    def without_a_part(content):
        content["scene"]["detections"].pop()

    said = say("prove", "--check", resigned(certificate, without_a_part))
    assert said.code == 3 and "is not in the scan" in said.out


def test_what_does_not_hold_is_not_certified(say, line, tmp_path):
    def through(content):
        content["arms"][0]["legs"][0]["q"][1][1] += 1.0
        for key in ("digest", "proof"):
            del content[key]

    plan = tmp_path / "plan.json"
    plan.write_text(line.plan.read_text())
    certificate = tmp_path / "none.json"
    said = say("prove", changed(plan, through), "--certificate", certificate)
    assert said.code == 3 and not certificate.exists()


def test_a_plan_of_another_program_is_proven_like_any_other(say, line, tmp_path):
    """It knows neither digests nor what this program took how long for."""
    plan, own = tmp_path / "plan.json", tmp_path / "own.json"
    plan.write_text(line.plan.read_text())

    def foreign(content):
        for key in ("digest", "proof", "seconds", "seed", "note", "cell_digest", "scan_digest"):
            del content[key]

    other = changed(plan, foreign)
    said = say("verify", other, "--poses", line.poses)
    assert said.code == 0 and "by another program" in said.out
    said = say("prove", other, "--poses", line.poses, "--out", own)
    assert said.code == 0
    assert json.loads(own.read_text())["digest"] in said.out
    assert say("verify", own, "--poses", line.poses).code == 0

    def moves_a_part(content):
        content["detections"][0]["T_world_part"][0][3] += 0.003

    said = say("verify", changed(other, moves_a_part), "--poses", line.poses)
    assert said.code == 3 and "leaves out part-1 of the scan, or moves it" in said.out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), "name the file of a plan"),
        (("--check", "no such.json"), "no such.json"),
        (("--check", "PLAN"), "workbench-certificate/1"),
        (("PLAN", "--check", "PLAN"), "--check takes a certificate"),
        (("--check", "PLAN", "--out", "own.json"), "--check takes a certificate"),
    ],
)
def test_what_was_typed_wrongly_is_said_in_a_sentence(say, line, words, says):
    said = say("prove", *(line.plan if word == "PLAN" else word for word in words))
    assert said.code == 2 and says in said.err and "Traceback" not in said.err


@pytest.mark.parametrize("command", ["prove", "verify", "send"])
def test_what_the_poses_of_a_halcon_file_are_of_can_be_said(say, line, command, tmp_path):
    robot = ("--host", "127.0.0.1", "--port", "1", "--approve-as", "Ada", "--record", tmp_path)
    words = (line.plan, "--poses", POSES, "--part", "washer")
    said = say(command, *words, *(robot if command == "send" else ()))
    assert said.code == 2 and "no part 'washer'" in said.problem


@pytest.mark.extensive
def test_a_plan_for_another_way_to_move_is_refused_with_what_to_do(line, say, tmp_path):
    """It rounds corners, and takes less time than stops do."""
    plan, words = tmp_path / "plan.json", ("plan", "yumi", "--poses", line.poses)
    words = (*words, "--out", plan, "--strategy", "right")
    assert say(*words).code == 0
    robot = ("--host", "127.0.0.1", "--port", 9, "--protocol", "abb-socket")
    sending = ("send", plan, *robot, "--approve-as", "Ada", "--record", tmp_path)
    problem = say(*sending).problem
    assert "more acceleration than the arm has" in problem
    assert "otherwise than the cell's abb-socket/2: plan with --protocol abb-socket" in problem
    assert say(*words, "--protocol", "abb-socket").code == 0
    said = say(*sending)
    assert "holds" in said.out and "nobody has approved the plan" in said.problem
