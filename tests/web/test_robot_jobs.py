"""What a robot program may ask of a bench: jobs under an operator's rules, never an approval."""

import json
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import six_axes_cell
from waiting import PATIENCE, wait_until

import workbench
from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.unapproved import SwitchApproval
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Role
from workbench.app.core.state import Phase
from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.app.runtime.bench import Bench
from workbench.devices.pick_server.conversation import POSES_VERSION
from workbench.devices.pick_server.lines import Form
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.model.recipes.kit import KitItem
from workbench.model.recipes.recipe import Recipe
from workbench.plugins.robot_link import controller_by
from workbench.web.robot_jobs import ACTOR, robot_jobs

sys.path.append(str(Path(__file__).parents[1] / "devices"))

from pick_scenes import Program
from ports import free_port

JOBS = ("TakeScan", "FindParts", "MakePlan", "SendPlan")


@pytest.fixture
def bench(tmp_path):
    cell = workbench.read_cell("tx2_90")
    cell = replace(cell, controller=controller_by("pick-server", port=free_port()))
    bench = Bench(cell, Journal(tmp_path / "session"))
    with robot_jobs(bench):
        yield bench
        bench.close()


@pytest.fixture
def robot(bench):
    one = Program(bench.cell, bench.cell.controller.port)
    yield one
    one.close()


def until_done(robot, job, *words, until=""):
    """The answer to a job that takes long, or the one that it waits for `until`."""
    began = time.monotonic()
    while (answer := robot.ask(job, *words))[0] == "WAIT" and answer[1] != until:
        assert time.monotonic() - began < PATIENCE
        time.sleep(0.05)
    return answer


def approve(bench):
    plan = bench.state.plan
    bench.do(WatchPlan(plan.digest, is_reported=True), "anna")
    bench.do(Approve(plan.digest), "anna")


@pytest.mark.timeout(1800)
def test_a_robot_program_runs_whole_cycles_and_only_a_person_approves(bench, robot):
    assert robot.ask("next", *robot.joints()) == ("NO", "find")
    for cycle in range(2):
        assert until_done(robot, "scan") == ("OK", "scan")
        answer = until_done(robot, "find")
        assert answer[0] == "OK" and int(answer[1]) == len(bench.state.detections)
        while (answer := robot.ask("next", *robot.joints())) != ("WAIT", "approval"):
            assert answer == ("WAIT", "plan"), answer
            time.sleep(0.05)
        assert bench.state.phase is Phase.PLANNED, "nobody has approved"
        wait_until(lambda: robot.ask("state", *robot.joints()) and bool(bench.live.joints))
        approve(bench)
        robot.cycle()
        wait_until(lambda: bench.state.phase is Phase.DONE)
        assert bench.state.parts_placed == 1
        assert len(robot.plans) == cycle + 1
    rows = [(row.kind, json.loads(row.body).get("actor")) for row in bench.entries()]
    assert [actor for kind, actor in rows if kind == "Approve"] == ["anna", "anna"]
    assert {actor for kind, actor in rows if kind in JOBS} == {ACTOR}


@pytest.mark.timeout(1800)
def test_poses_go_out_without_approval_only_while_an_engineer_has_switched_it_off(tmp_path):
    cell = workbench.read_cell("tx2_90")
    options = {"poses": "staubli", "longest": 128}
    link = controller_by("pick-server", port=free_port(), options=options)
    bench = Bench(replace(cell, controller=link), Journal(tmp_path / "session"))
    robot = Program(bench.cell, link.port, Form(longest=128), version=POSES_VERSION)
    with robot_jobs(bench):
        assert until_done(robot, "scan") == ("OK", "scan")
        assert until_done(robot, "find")[0] == "OK"
        assert until_done(robot, "next", until="approval") == ("WAIT", "approval")
        assert "nothing of the robot's motion is proven" in str(bench.state.message)
        # Whatever the robot's program is, it switches nothing.
        with pytest.raises(CommandRefused):
            bench.do(SwitchApproval(True), ACTOR, Role.OPERATOR)
        assert robot.ask("next") == ("WAIT", "approval")
        bench.do(SwitchApproval(True), "anna")
        assert until_done(robot, "next")[:2] == ("PICK", "unproven")
        poses = [robot.ask("pose", str(number)) for number in (1, 2, 3)]
        assert all(words[:2] == ("POSE", "unproven") for words in poses)
        assert robot.ask("picked") == ("OK", "picked")
        assert robot.ask("placed") == ("OK", "end")
        wait_until(lambda: bench.state.phase is Phase.DONE)
        approval, digest = bench.state.approval, bench.state.plan.digest
        assert approval.is_switched_off and approval.people == ()
        bench.do(SwitchApproval(False), "anna")
        robot.close()
        bench.close()
    journal = Journal(tmp_path / "session")
    rows = [(row.kind, json.loads(row.body).get("actor")) for row in journal.entries()]
    states = [state for _, state in replay(journal, cell_of(journal))]
    journal.close()
    assert [row for row in rows if row[0] in ("SwitchApproval", "ReleasePoses", "Approve")] == [
        ("SwitchApproval", "anna"),
        ("ReleasePoses", ACTOR),
        ("SwitchApproval", "anna"),
    ]
    let_out = [state.approval for state in states if state.approval]
    assert {one.plan_digest for one in let_out} == {digest}
    assert all(one.is_switched_off for one in let_out)
    assert states[-1].unapproved_by == "" and states[-1].parts_placed == 1


@pytest.mark.timeout(1800)
def test_a_robot_program_gets_a_proven_path_to_the_view_and_scans_there(tmp_path):
    cell = six_axes_cell("pick-server")
    cell = replace(cell, controller=replace(cell.controller, port=free_port()))
    bench, carrier = Bench(cell, Journal(tmp_path / "session")), cell.scanner.on_arm
    robot = Program(cell, cell.controller.port)
    at_view = robot.joints()
    with robot_jobs(bench):
        assert robot.ask("view") == ("OK", *at_view)
        assert robot.ask("view", *at_view) == ("OK", "view")
        robot.q = np.asarray(carrier.home) + 0.3
        assert robot.ask("view", *robot.joints()) == ("NO", "home")
        robot.q = np.asarray(carrier.home)
        answer = until_done(robot, "view", *robot.joints(), until="approval")
        assert answer == ("WAIT", "approval")
        assert bench.state.phase is Phase.PLANNED and bench.state.plan.is_view_plan
        assert robot.ask("next", *robot.joints()) == ("WAIT", "approval")
        approve(bench)
        assert robot.begin() == 1
        assert robot.leg(1)[1] == "view"
        assert robot.ask("done", "1", *robot.joints()) == ("OK", "end")
        wait_until(lambda: bench.state.phase is Phase.DONE)
        wait_until(lambda: robot.ask("view", *robot.joints()) == ("OK", "view"))
        assert until_done(robot, "scan") == ("OK", "scan")
        assert bench.state.scan is not None
        at_home = robot.ask("home")[1:]
        assert until_done(robot, "home", *robot.joints(), until="approval") == ("WAIT", "approval")
        approve(bench)
        assert robot.begin() == 1
        robot.leg(1)
        assert robot.ask("done", "1", *robot.joints()) == ("OK", "end")
        assert tuple(robot.joints()) == at_home
        wait_until(lambda: robot.ask("home", *robot.joints()) == ("OK", "home"))
        robot.q = np.asarray(carrier.home) + 0.3
        assert robot.ask("home", *robot.joints()) == ("NO", "view")
        robot.close()
        bench.close()
    journal = Journal(tmp_path / "session")
    states = [state for _, state in replay(journal, cell_of(journal))]
    journal.close()
    assert any(state.scan is not None for state in states)
    assert any(state.plan is not None and state.plan.is_view_plan for state in states)


@pytest.mark.timeout(1800)
def test_a_robot_program_fills_a_kit_and_begins_a_new_one(tmp_path):
    cell = workbench.read_cell("tx2_90")
    one = Recipe(3, "one puck", items=(KitItem("puck", 1),))
    link = controller_by("pick-server", port=free_port())
    bench = Bench(replace(cell, controller=link, recipes=(one,)), Journal(tmp_path / "session"))
    with robot_jobs(bench):
        robot = Program(bench.cell, link.port)
        assert robot.ask("recipe", "3") == ("OK", "3")
        assert robot.ask("kit")[0] == "NO", "it has no part yet"
        assert until_done(robot, "scan") == ("OK", "scan")
        assert until_done(robot, "find")[0] == "OK"
        assert until_done(robot, "next", *robot.joints(), until="approval")[0] == "WAIT"
        wait_until(lambda: robot.ask("state", *robot.joints()) and bool(bench.live.joints))
        approve(bench)
        robot.cycle()
        wait_until(lambda: bench.state.phase is Phase.DONE)
        assert until_done(robot, "scan") == ("OK", "scan")
        assert until_done(robot, "find")[0] == "OK"
        assert robot.ask("next", *robot.joints()) == ("NO", "kit"), "it is complete"
        assert robot.ask("kit") == ("OK", "kit")
        assert bench.state.kit.complete == 1
        assert robot.ask("next", *robot.joints()) == ("WAIT", "plan")
        robot.close()
        bench.close()


def test_a_robot_program_that_begins_anew_gets_no_scan_of_the_run_before(bench, robot):
    assert robot.ask("scan") == ("WAIT", "scan")
    wait_until(lambda: bench.state.phase is Phase.SCANNED and bench.state.job is None)
    before = bench.state.number
    robot.close()
    again = Program(bench.cell, bench.cell.controller.port, run=2)
    assert again.ask("scan") == ("WAIT", "scan")
    assert until_done(again, "scan") == ("OK", "scan")
    assert bench.state.number == before + 2
    again.close()


def test_whoever_is_in_control_is_not_overruled(bench, robot):
    bench.do(TakeControl(), "anna")
    assert robot.ask("scan") == ("NO", "control")
    assert robot.ask("recipe", "1") == ("NO", "control")
    assert bench.state.phase is Phase.IDLE


def test_a_bin_is_chosen_by_its_number(tmp_path):
    cell = workbench.read_cell("tx2_90")
    one = replace(cell.bin, name="near", number=1)
    aside = pin.SE3(np.eye(3), np.array([0.0, 2.0, 0.0]))
    other = replace(one, name="far", number=2, T_world_bin=aside * one.T_world_bin)
    controller = controller_by("pick-server", port=free_port())
    cell = replace(cell, controller=controller, bin=one, other_bins=(other,))
    bench = Bench(cell, Journal(tmp_path / "session"))
    with robot_jobs(bench):
        robot = Program(cell, cell.controller.port)
        assert robot.ask("bin", "2") == ("OK", "2")
        assert bench.state.cell.bin.name == "far"
        assert robot.ask("bin", "3") == ("NO", "bin")
        assert robot.ask("bin", "0") == ("OK", "1")
        assert bench.state.cell.bin.name == "near"
        assert robot.ask("new-bin", "2") == ("OK", "2")
        assert str(bench.state.message) == "bin far is new"
        assert (robot.ask("new-bin", "3"), robot.ask("new-bin", "0")) == (("NO", "bin"),) * 2
        robot.close()
        bench.close()


def test_what_the_cell_does_not_have_is_answered_by_no(bench, robot):
    assert robot.ask("view") == ("NO", "view")
    assert robot.ask("recipe", "7")[0] == robot.ask("recipe", "65535")[0] == "NO"
    assert robot.ask("recipe", "65536")[0] == "ERR"
    assert robot.ask("kit")[0] == "NO"
    assert (robot.ask("bin", "1"), robot.ask("bin", "2")) == (("OK", "1"), ("NO", "bin"))
    assert robot.ask("leg", "1") == ("NO", "plan")
    assert robot.ask("scan", "x")[0] == "ERR"
    assert robot.ask("state") == ("OK", "idle")
    assert robot.ask("stop") == ("OK", "stop")
