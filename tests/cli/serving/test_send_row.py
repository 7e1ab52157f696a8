"""Plans in a row are approved as one, sent one after the other, and end with the first doubt."""

import json
import sqlite3
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

import workbench.cli.serving.approving as approving
import workbench.cli.serving.send as sending
from workbench.cli.main import main
from workbench.cli.serving.approving import row_digest
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan
from workbench.formats.plans.pose_files import write_poses
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A cell whose place is emptied at once, and three plans in a row."""
    shipped, folder = find("robots", "tx2_90"), tmp_path_factory.mktemp("row")
    text = (shipped / "cell.toml").read_text()
    text = text.replace('tool = "suction_cup"', 'tool = "suction_cup"\npasses_parts_on = true')
    text = text.replace("[policy]", "[policy]\npair_gap_mm = 10")
    text = text.replace('protocol = "abb-socket"', 'protocol = "abb-socket/2"')
    for name in ("tx2_90.urdf", "tx2_90.srdf"):
        text = text.replace(f'"{name}"', f'"{shipped / name}"')
    path = folder / "cell.toml"
    path.write_text(text)
    cell = read_cell(path)
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2 + 0.0005
    T = cell.bin.T_world_bin
    places = ((-0.08, -0.05), (0.0, 0.05), (0.08, -0.05))
    parts = [Detection("puck", T * pose_from_rpy((x, y, height))) for x, y in places]
    write_poses(folder / "poses.json", parts)
    words = ("--poses", folder / "poses.json", "--out", folder / "plan.json", "--picks", 3)
    assert main(["plan", *map(str, (path, *words))]) == 0
    return path, [folder / name for name in ("plan.json", "plan-2.json", "plan-3.json")]


@pytest.fixture
def faults():
    return ()


@pytest.fixture
def robot(files, faults, tmp_path):
    """A simulated controller of that cell; where it is, and what has arrived."""
    options = ["--port", "0", "--state-port", "0", "--speed", "50", "--until-eof", "--json"]
    options += [word for fault in faults for word in ("--fault", fault)]
    record = tmp_path / "arrived.jsonl"
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "controller", "--cell", str(files[0])]
        + [*options, "--record", str(record)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    ports = json.loads(process.stdout.readline())
    address = ("--host", "127.0.0.1", "--port", ports["port"], "--state-port", ports["state_port"])
    yield address, lambda: len(record.read_text().splitlines()) if record.exists() else 0
    process.stdin.close()
    assert process.wait(timeout=300) == 0
    process.stdout.close()


@pytest.fixture
def words(files, robot, tmp_path):
    record = ("--record", tmp_path / "approvals", "--cell", files[0])
    return (*robot[0], "--approve-as", "Ada", *record)


def entries(folder):
    with closing(sqlite3.connect(folder / "approvals" / "journal.sqlite")) as connection:
        rows = connection.execute("SELECT kind, body FROM entries ORDER BY number").fetchall()
    return [(kind, json.loads(body)) for kind, body in rows]


def shown(say, plans, words):
    """The digest of the row, once a person was shown what it is."""
    told = say("send", *plans, *words)
    assert told.code == 2 and "this is no terminal" in told.problem
    digest = row_digest([read_plan(plan)[0] for plan in plans])
    assert f"{digest}: {len(plans)} plans by one approval" in told.out
    for number, plan in enumerate(plans[1:], 2):
        assert read_plan(plan)[0].digest in told.out and f"{number}. Proof" in told.out
    return digest


def test_a_row_is_approved_as_one_and_sent_plan_after_plan(files, robot, words, say, tmp_path):
    _, plans = files
    digest = shown(say, plans, words)
    assert robot[1]() == 0, "nothing is sent before it is approved"
    own = [read_plan(plan)[0].digest for plan in plans]
    for other in (own[0], own[1], row_digest([read_plan(plan)[0] for plan in plans[:2]])):
        told = say("send", *plans, *words, "--digest", other)
        assert told.code == 2 and "is not the digest of this row of plans" in told.problem
    told = say("send", *plans, *words, "--digest", digest, "--json")
    assert told.code == 0, told.err
    form = json.loads(told.out)
    assert [form["digest"], *(one["digest"] for one in form["row"])] == own
    assert all(one["parts"][0]["is_picked"] for one in (form, *form["row"]))
    found = entries(tmp_path)
    assert [kind for kind, _ in found] == ["Shown", *["Approval"] * 3, *["Ended"] * 3]
    first, *rest = [body for kind, body in found if kind == "Approval"]
    assert [one["plan_digest"] for one in (first, *rest)] == own
    assert [digest for digest, _ in first["row"]] == own[1:]
    assert len({one["first"] for one in rest}) == 1 and rest[0]["until"] == first["until"]
    assert all(one["is_unwatched"] is True for one in (first, *rest)), "nobody has seen any"
    assert [body["problem"] for kind, body in found if kind == "Ended"] == ["", "", ""]
    arrived = robot[1]()
    told = say("send", plans[1], *words)
    assert told.code == 2 and "before and has gone out" in told.problem
    assert robot[1]() == arrived


@pytest.mark.parametrize("faults", [("empty-hand:1",)])
def test_a_pick_that_fails_ends_the_row_and_the_approval_of_the_rest(
    files, robot, words, say, tmp_path, faults
):
    _, plans = files
    digest = shown(say, plans, words)
    told = say("send", *plans, *words, "--digest", digest)
    assert told.code == 2
    assert "the row has ended after 1 of 3 plans: the pick of arm right failed" in told.err
    ends = [body for kind, body in entries(tmp_path) if kind == "Ended"]
    assert [bool(one["receipts"]) for one in ends] == [True, False, False]
    assert ends[1]["problem"] == ends[2]["problem"] == "the row had ended before"
    arrived = robot[1]()
    told = say("send", *plans, *words, "--digest", digest)
    assert told.code == 2 and "before and has gone out" in told.problem
    assert robot[1]() == arrived, "nothing goes out twice"
    told = say("send", plans[1], *words)
    assert told.code == 2 and "this is no terminal" in told.problem, "it may be approved anew"


@pytest.mark.parametrize("begun", [0, 1])
def test_a_robot_that_stands_elsewhere_before_a_plan_is_not_sent_it(
    files, robot, words, say, tmp_path, monkeypatch, begun
):
    """Before the first nothing is approved; before the second the row ends."""
    _, plans = files
    digest, reported = shown(say, plans, words), approving.reported_joints
    seen = robot[1]()

    def elsewhere(cell):
        joints = reported(cell)
        is_due = begun == 0 or robot[1]() > seen
        return {name: q + np.deg2rad(3.0) for name, q in joints.items()} if is_due else joints

    for module in (approving, sending):
        monkeypatch.setattr(module, "reported_joints", elsewhere)
    told = say("send", *plans, *words, "--digest", digest)
    assert told.code == 2 and "the robot has moved" in told.err
    words_of = [kind for kind, _ in entries(tmp_path)]
    ends = [bool(body["receipts"]) for kind, body in entries(tmp_path) if kind == "Ended"]
    if begun:
        assert "the row has ended after 1 of 3 plans" in told.err
        assert ends == [True, False, False]
    else:
        assert words_of == ["Shown"] and robot[1]() == seen


@pytest.mark.parametrize("faults", [("drop:30",)])
def test_a_link_that_breaks_ends_the_row(files, robot, words, say, tmp_path, faults):
    _, plans = files
    digest = shown(say, plans, words)
    told = say("send", *plans, *words, "--digest", digest)
    assert told.code not in (0, None)
    ends = [body for kind, body in entries(tmp_path) if kind == "Ended"]
    broken = [bool(one["problem"]) and bool(one["receipts"]) for one in ends]
    assert len(ends) == 3 and broken.count(True) == 1
    after = ends[broken.index(True) + 1 :]
    assert all(not one["receipts"] for one in after)


def test_plans_in_another_order_or_twice_are_no_row(files, robot, words, say):
    _, (first, second, _) = files
    for plans in ((second, first), (first, first), (first, second, second)):
        told = say("send", *plans, *words)
        assert told.code == 2 and "the proof does not hold" in told.problem
    assert robot[1]() == 0


def test_a_link_that_tells_nothing_of_parts_takes_one_plan_at_a_time(files, robot, words, say):
    _, plans = files
    told = say("send", *plans, *words, "--protocol", "abb-socket")
    assert told.code == 2
    assert "does not report what became of each part, so only one plan" in told.problem


def test_a_row_has_an_end(files, robot, words, say):
    told = say("send", *[files[1][0]] * 11, *words)
    assert told.code == 2 and told.problem == "a row has at most 10 plans, not 11"
