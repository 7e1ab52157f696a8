"""Bad input: an exit code and one clear line, never a traceback."""

import json
import shutil
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from ports import free_port
from waiting import PATIENCE

from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.geometry import pose_from_rpy
from workbench.planning.kinematics.chain import chain_of, is_solution

POSES = Path(__file__).resolve().parents[1] / "cells" / "public_yumi" / "Poses.txt"

PLAN = ("plan", "yumi", "--poses", str(POSES))

PLY = """ply
format ascii 1.0
element vertex {count}
property float x
property float y
property float z
end_header
{rows}"""


def changed_plan(line, tmp_path: Path, change: Callable[[dict], None]) -> Path:
    content = json.loads(line.plan.read_text())
    change(content)
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(content))
    return path


def leg_of(content: dict, name: str) -> dict:
    return next(leg for leg in content["arms"][0]["legs"] if leg["name"] == name)


# -- scans ----------------------------------------------------------------------------------


def test_a_truncated_scan_is_refused(line, say, tmp_path):
    cut = tmp_path / "cut.ply"
    cut.write_bytes(line.scan.read_bytes()[:-1000])
    said = say("localize", "yumi", "--scan", cut, "--out", tmp_path / "p.json")
    assert said.code == 2
    assert "cut.ply" in said.problem
    assert not (tmp_path / "p.json").exists()


@pytest.mark.parametrize(
    ("rows", "count"), [("", 0), ("nan nan nan\n" * 5, 5)], ids=["no points", "only NaN"]
)
def test_a_scan_without_points_finds_nothing_or_is_refused(say, tmp_path, rows, count):
    path = tmp_path / "empty.ply"
    path.write_text(PLY.format(count=count, rows=rows))
    said = say("localize", "yumi", "--scan", path, "--out", tmp_path / "p.json")
    assert said.code == 2
    assert "empty.ply" in said.problem


def test_a_scan_of_something_else_finds_nothing(say, tmp_path):
    path = tmp_path / "far.ply"
    rows = "".join(f"{x} {y} 2.0\n" for x in range(20) for y in range(20))
    path.write_text(PLY.format(count=400, rows=rows))
    out = tmp_path / "p.json"
    assert say("localize", "yumi", "--scan", path, "--out", out).code == 0
    said = say("plan", "yumi", "--poses", out, "--out", tmp_path / "plan.json")
    assert said.code == 2
    assert "p.json" in said.problem or "no part" in said.problem


# -- poses ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda text: text.replace("24", "23", 1), "23"),
        (lambda text: text.replace("24", "36", 1), "36"),
        (lambda text: text.replace("24", "many", 1), "many"),
        (lambda text: "\n".join([*text.splitlines()[:-1], "2 nan"]), "nan"),
        (lambda text: "\n".join([*text.splitlines()[:-1], "4 wall"]), "25"),
        (lambda text: text.replace("2 1\n", "2 1e300\n", 1), "rotation"),
        (lambda text: "", "empty"),
        (lambda text: "\x00\x01\x02", "Poses.txt"),
    ],
    ids=[
        "count too small",
        "count too large",
        "no count",
        "NaN",
        "text",
        "huge",
        "empty",
        "binary",
    ],
)
def test_wrong_halcon_poses_are_refused(say, tmp_path, change, expected):
    path = tmp_path / "Poses.txt"
    path.write_text(change(POSES.read_text()))
    said = say("plan", "yumi", "--poses", path, "--out", tmp_path / "plan.json")
    assert said.code == 2
    assert "Poses.txt" in said.problem
    assert expected in said.problem


def test_nothing_in_reach_is_no_plan_and_says_why(say, tmp_path):
    path = tmp_path / "Poses.txt"
    path.write_text(POSES.read_text().replace("2 400\n", "2 2400\n").replace("2 420\n", "2 2420\n"))
    said = say("plan", "yumi", "--poses", path, "--out", tmp_path / "plan.json")
    assert said.code == 3
    assert "every candidate" in said.out
    assert "unreachable" in said.out
    assert not (tmp_path / "plan.json").exists()
    said = say("plan", "yumi", "--poses", path, "--out", tmp_path / "plan.json", "--json")
    assert said.code == 3
    told = json.loads(said.out)
    assert told["ok"] is False
    assert {one["reason"] for one in told["candidates"]} >= {"OUT_OF_REACH"}


# -- cells and options -----------------------------------------------------------------------


def test_an_unknown_key_of_a_cell_is_named(say, tmp_path):
    folder = find("robots", "yumi")
    text = (folder / "cell.toml").read_text().replace('"yumi.', f'"{folder}/yumi.')
    text = text.replace('"meshes/', f'"{folder}/meshes/').replace("margin_mm", "marign_mm", 1)
    (tmp_path / "cell.toml").write_text(text)
    said = say("scan", tmp_path / "cell.toml", "--out", tmp_path / "s.ply")
    assert said.code == 2
    assert "marign_mm" in said.problem
    assert "cell.toml" in said.problem


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("scan", "mars", "--out", "s.ply"), "mars"),
        (("scan", "yumi", "--out", "gone/s.ply"), "gone"),
        (("scan", "yumi", "--out", "s.ply", "--parts", "0"), "--parts"),
        (("scan", "yumi", "--out", "s.ply", "--seed", "-1"), "--seed"),
        (("localize", "yumi", "--scan", "gone.ply", "--out", "p.json"), "gone.ply"),
        (("plan", "yumi", "--poses", "gone.json", "--out", "plan.json"), "gone.json"),
        (
            ("plan", "yumi", "--poses", str(POSES), "--out", "x", "--threshold", "nan"),
            "--threshold",
        ),
        (("plan", "yumi", "--poses", str(POSES), "--out", "x", "--part", "bolt"), "bolt"),
        (("plan", "yumi", "--poses", str(POSES), "--out", "gone/plan.json"), "gone"),
        (("verify", "gone.json"), "gone.json"),
        (("verify", "."), "."),
        (("demo", "--cycles", "0"), "--cycles"),
        (("demo", "--speed", "0"), "--speed"),
        (("controller", "--port", "70000"), "--port"),
        (("serve", "--port", "-1"), "--port"),
        (("serve", "--cell", "mars"), "mars"),
        (("export-world", "mars", "--out", "w"), "mars"),
        (("bench", "planners", "--seed", "-1"), "--seed"),
        (("bench", "pick", "--seed", "-1"), "--seed"),
        (("study", "threshold", "--seed", "-1"), "--seed"),
        (("study", "localization", "--seed", "-1"), "--seed"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_what_cannot_be_is_named(say, tmp_path, monkeypatch, words, expected):
    monkeypatch.chdir(tmp_path)
    said = say(*words)
    assert said.code == 2
    assert expected in said.problem
    assert said.out == ""


@pytest.mark.parametrize(
    "words",
    [(), ("fly",), ("plan", "yumi"), ("scan", "yumi", "--out", "s.ply", "--seed", "two")],
    ids=" ".join,
)
def test_what_is_no_command_ends_with_2(words, capsys):
    from workbench.cli.main import main

    with pytest.raises(SystemExit) as ended:
        main(list(words))
    assert ended.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("asks", ["a plan", "help"])
def test_output_that_nobody_reads_is_no_error(line, tmp_path, asks):
    """As with `workbench plan ... | head -1`: the reader goes before all is printed."""
    words = ["plan", "yumi", "--poses", str(line.poses), "--out", str(tmp_path / "p.json")]
    words = ["evidence", "--help"] if asks == "help" else words
    command = [sys.executable, "-m", "workbench", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        errors = process.stderr.read()
        assert process.wait(timeout=600) == 141
    assert errors == b""


# -- plans ----------------------------------------------------------------------------------


def test_a_waypoint_in_the_bin_wall_fails_with_pair_leg_and_clearance(line, say, tmp_path):
    """By hand: the fingers' tips at waypoint 4 of the way back are put into the wall."""
    plan, _ = read_plan(line.plan)
    cell = read_cell("yumi")
    arm = cell.arm(plan.arms[0].arm)
    chain = chain_of(cell, arm)
    side = 1.0 if arm.name == "left" else -1.0
    T_world_wall = cell.bin.T_world_bin * pose_from_rpy(
        (0.0, side * cell.bin.size[1] / 2, 0.03), (np.pi, 0, 0)
    )
    q = np.asarray(plan.arms[0].leg("return").q)[4]
    starts = np.vstack([q, np.random.default_rng(0).uniform(chain.lower, chain.upper, (40, 7))])
    answers, residuals = chain.solve(T_world_wall, starts)
    in_wall = cell.controller.motion.rounded(answers[is_solution(residuals)][0])

    def bend(content: dict) -> None:
        leg_of(content, "return")["q"][4] = in_wall.tolist()

    said = say("verify", changed_plan(line, tmp_path, bend), "--json")
    assert said.code == 3
    proof = json.loads(said.out)["proof"]
    assert not proof["holds"]
    violation = next(one for one in proof["violations"] if one["pair"] is not None)
    assert violation["leg"] == "return"
    assert violation["arm"] == arm.name
    assert any(label.startswith("bin_wall") for label in violation["pair"])
    assert violation["distance_mm"] < cell.policy.margin * 1000
    assert "the file was changed" in proof["violations"][0]["problem"]
    said = say("verify", tmp_path / "changed.json")
    assert said.code == 3
    assert "bin_wall" in said.out
    assert "return" in said.out
    assert " mm" in said.out


def test_a_joint_beyond_its_limit_fails_and_is_not_sent(line, say, tmp_path):
    def bend(content: dict) -> None:
        leg_of(content, "reach")["q"][1][1] = 2.0

    path = changed_plan(line, tmp_path, bend)
    said = say("verify", path)
    assert said.code == 3
    assert "outside" in said.out
    said = say("send", path, "--host", "127.0.0.1", "--port", 9, "--approve-as", "Ada")
    assert said.code == 2
    assert "was changed" in said.problem


def test_a_plan_that_fails_its_proof_is_not_sent_even_with_a_fresh_digest(line, say, tmp_path):
    def bend(content: dict) -> None:
        leg_of(content, "reach")["q"][1][1] = 2.0

    bent, _ = read_plan(changed_plan(line, tmp_path, bend))
    write_plan(tmp_path / "bent.json", bent, prove(read_cell("yumi"), bent))
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        address = ["--host", "127.0.0.1", "--port", port]
        said = say("send", tmp_path / "bent.json", *address, "--approve-as", "Ada")
        server.settimeout(0.2)
        with pytest.raises(TimeoutError):
            server.accept()
    assert said.code == 2
    assert "proof" in said.problem


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda c: c.pop("arms"), "arms"),
        (lambda c: c.update(format="workbench-plan/9"), "workbench-plan/9"),
        (lambda c: c.update(strategy="both"), "both"),
        (lambda c: c["arms"][0].update(detection=-1), "detection"),
        (lambda c: leg_of(c, "reach").update(q=[["a"] * 7]), "q"),
        (lambda c: leg_of(c, "reach").update(q=[]), "q"),
        (lambda c: leg_of(c, "reach")["q"][0].pop(), "q"),
        (lambda c: leg_of(c, "reach")["q"][0].__setitem__(0, 1e400), "changed.json"),
        (lambda c: leg_of(c, "reach")["q"][0].__setitem__(0, 1e300), "1e+300"),
        (lambda c: c.update(extra=1), "extra"),
    ],
)
def test_a_plan_file_of_wrong_form_is_refused(line, say, tmp_path, change, expected):
    said = say("verify", changed_plan(line, tmp_path, change))
    assert said.code in (2, 3)
    assert expected in (said.problem if said.code == 2 else said.out)


@pytest.mark.parametrize("content", [b"", b"[]", b"nonsense", b"[" * 100_000, b"\xff\xfe\x00"])
def test_what_is_no_plan_file_is_refused(say, tmp_path, content):
    (tmp_path / "plan.json").write_bytes(content)
    said = say("verify", tmp_path / "plan.json")
    assert said.code == 2
    assert "plan.json" in said.problem


def test_a_plan_for_a_cell_that_has_changed_is_not_sent(line, say, tmp_path):
    folder = Path(shutil.copytree(find("robots", "yumi"), tmp_path / "yumi"))
    cell = (folder / "cell.toml").read_text().replace("wall_mm = 3", "wall_mm = 4")
    (folder / "cell.toml").write_text(cell)
    address = ["--host", "127.0.0.1", "--port", 9, "--cell", folder]
    said = say("send", line.plan, *address, "--approve-as", "Ada")
    assert said.code == 2
    assert "the cell has changed" in said.problem
    assert say("verify", line.plan, "--cell", folder).code == 3


@pytest.mark.parametrize("name", ["", "  ", "A\nda"])
def test_nobody_cannot_approve(line, say, name):
    said = say("send", line.plan, "--host", "127.0.0.1", "--port", 9, "--approve-as", name)
    assert said.code == 2


# -- the robot link --------------------------------------------------------------------------


def test_a_controller_that_is_not_there(line, send):
    port = free_port()
    said = send(line.plan, "--host", "127.0.0.1", "--port", port)
    assert said.code == 4
    assert str(port) in said.problem


def one_that(talks: Callable[[socket.socket], None]) -> tuple[socket.socket, threading.Thread]:
    """A controller for one conversation."""
    server = socket.create_server(("127.0.0.1", 0))

    def run() -> None:
        with server, server.accept()[0] as link:
            link.settimeout(PATIENCE)
            talks(link)

    thread = threading.Thread(target=run)
    thread.start()
    return server, thread


def closes_after_five(link: socket.socket) -> None:
    for _ in range(5):
        link.sendall(b"send")
        link.recv(200)


def resets_at_once(link: socket.socket) -> None:
    link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))


def sends_garbage(link: socket.socket) -> None:
    link.sendall(b"HTTP/1.1 400 Bad Request\r\n")
    link.recv(200)


@pytest.mark.extensive
@pytest.mark.parametrize(
    ("talks", "protocol"),
    [
        (closes_after_five, "abb-socket"),
        (resets_at_once, "abb-socket"),
        (resets_at_once, "abb-socket/2"),
        (sends_garbage, "abb-socket"),
        (sends_garbage, "abb-socket/2"),
    ],
)
def test_a_controller_that_breaks_off(line, say, send, tmp_path, talks, protocol):
    folder = Path(shutil.copytree(find("robots", "yumi"), tmp_path / "yumi"))
    text = (folder / "cell.toml").read_text()
    (folder / "cell.toml").write_text(text.replace('"abb-socket/2"', f'"{protocol}"'))
    one_arm = tmp_path / "one_arm.json"
    words = ("--poses", line.poses, "--out", one_arm, "--strategy", "right")
    assert say("plan", folder, *words).code == 0
    server, thread = one_that(talks)
    port = server.getsockname()[1]
    said = send(one_arm, "--cell", folder, "--host", "127.0.0.1", "--port", port)
    thread.join(PATIENCE)
    assert said.code == 4
    assert said.problem
    assert said.out == ""
