"""`workbench plan --picks` and `workbench study emptying --picks`: several plans after one look."""

import json

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan
from workbench.formats.plans.pose_files import write_poses
from workbench.model.derived.row_parts import parts_taken
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The TX2-90 with a conveyor behind its place, and 10 mm between parts of one heap."""
    shipped = find("robots", "tx2_90")
    text = (shipped / "cell.toml").read_text()
    text = text.replace('tool = "suction_cup"', 'tool = "suction_cup"\npasses_parts_on = true')
    text = text.replace("[policy]", "[policy]\npair_gap_mm = 10")
    for name in ("tx2_90.urdf", "tx2_90.srdf"):
        text = text.replace(f'"{name}"', f'"{shipped / name}"')
    path = tmp_path_factory.mktemp("row") / "cell.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def poses(path):
    cell = read_cell(path)
    assert cell.policy.pair_gap == 0.01 and all(arm.passes_parts_on for arm in cell.arms)
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2 + 0.0005
    places = ((-0.08, -0.05), (0.0, 0.05), (0.08, -0.05))
    T_world_bin = cell.bin.T_world_bin
    parts = [Detection("puck", T_world_bin * pose_from_rpy((x, y, height))) for x, y in places]
    file = path.with_name("poses.json")
    write_poses(file, parts)
    return file


def test_each_plan_of_a_row_is_a_file_of_its_own_that_is_proven(say, path, poses, tmp_path):
    out = tmp_path / "plan.json"
    told = say("plan", path, "--poses", poses, "--out", out, "--picks", 2, "--json")
    assert told.code == 0, told.err
    form = json.loads(told.out)
    (second,) = form["row"]
    assert second["file"] == str(tmp_path / "plan-2.json") and second["proof"]["holds"]
    assert form["row_ends"] is None
    plans = [read_plan(file)[0] for file in (out, tmp_path / "plan-2.json")]
    assert [plan.digest for plan in plans] == [form["plan"]["digest"], second["plan"]["digest"]]
    taken = [parts_taken(plans[0], plan) for plan in plans]
    assert len({number for one in taken for number in one}) == 2
    assert second["parts"] == list(taken[1])
    assert [len(plan.detections) for plan in plans] == [3, 2]
    assert say("prove", tmp_path / "plan-2.json", "--cell", path).code == 0


def test_it_says_by_the_numbers_of_the_scan_what_follows_and_why_no_more(
    say, path, poses, tmp_path
):
    out = tmp_path / "plan.json"
    told = say("plan", path, "--poses", poses, "--out", out, "--picks", 4)
    assert told.code == 0, told.err
    for number in (1, 2, 3):
        assert len([line for line in told.out.splitlines() if f"part-{number} by" in line]) == 1
    assert f"then {tmp_path / 'plan-3.json'}: " in told.out
    assert "nothing in a row after that: no part is left" in told.out


def test_where_nobody_says_another_number_it_is_the_cells(say, path, poses, tmp_path):
    cell = tmp_path / "cell.toml"
    text = path.read_text()
    assert text.count("[policy]") == 1
    cell.write_text(text.replace("[policy]", "[policy]\npicks = 2"))
    out = tmp_path / "plan.json"
    told = say("plan", cell, "--poses", poses, "--out", out, "--json")
    assert told.code == 0, told.err
    assert len(json.loads(told.out)["row"]) == 1
    told = say("plan", cell, "--poses", poses, "--out", out, "--picks", 1, "--json")
    assert told.code == 0 and json.loads(told.out)["row"] == []


def test_without_being_asked_there_is_one_plan(say, path, poses, tmp_path):
    out = tmp_path / "plan.json"
    told = say("plan", path, "--poses", poses, "--out", out, "--json")
    assert told.code == 0 and json.loads(told.out)["row"] == []
    assert [file.name for file in tmp_path.glob("*.json")] == ["plan.json"]


@pytest.mark.parametrize("picks", [0, 11])
def test_too_many_or_none_are_refused(say, path, poses, tmp_path, picks):
    out = tmp_path / "plan.json"
    told = say("plan", path, "--poses", poses, "--out", out, "--picks", picks)
    assert told.code == 2 and "--picks" in told.problem


def test_a_cell_that_does_not_say_what_moves_is_refused(say, poses, tmp_path):
    for typed in (
        ("plan", "tx2_90", "--poses", poses, "--out", tmp_path / "plan.json"),
        ("study", "emptying", "tx2_90", "--parts", 2, "--scenes", 1),
    ):
        told = say(*typed, "--picks", 2)
        assert told.code == 2 and "need a pair_gap_mm in [policy]" in told.problem


@pytest.mark.extensive
def test_a_bin_is_emptied_by_rows_and_by_single_picks_to_compare(say, path):
    typed = ("study", "emptying", path, "--parts", 4, "--scenes", 1, "--seed", 3)
    told = say(*typed, "--picks", 3, "--json")
    assert told.code == 0, told.err
    found = json.loads(told.out)
    single = found["one_pick"]
    assert found["taken"] + sum(len(one["left"]) for one in found["scenes"]) == 4
    assert 0 < found["cycles"] < single["cycles"] and found["scans"] < single["scans"]
    assert found["failed_picks"] == single["failed_picks"] == 0
    assert found["touches"] == single["touches"] == 0
    assert len(found["scenes"]) == 1, "the single picks are only compared with"
    said = say(*typed, "--picks", 3).out
    assert f"with {found['cycles']} approvals and {found['scans']} scans; with one pick" in said
