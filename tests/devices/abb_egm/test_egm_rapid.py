"""The modules in RAPID for EGM, executed: led by the link, and statement by statement."""

import re
import socket
import threading
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from egm_scenes import PATIENT
from waiting import PATIENCE, wait_until

from workbench.devices.abb_egm import rapid_controller, wire
from workbench.devices.abb_egm.link import AbbEgm
from workbench.devices.abb_egm.rapid_controller import GuidedController
from workbench.formats.rapid.check import check
from workbench.formats.rapid.setup import read_setup
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.plugins.robot_link import Simulation, send
from workbench.testing import check_robot_link

pytest.importorskip(
    "google.protobuf", reason="protobuf is not installed: pip install 'workbench[egm]'"
)

FOLDER = Path(__file__).resolve().parents[3] / "robots" / "yumi" / "rapid_egm"
TASKS = {"right": "T_ROB_R", "left": "T_ROB_L"}

NOT_EXECUTED = {
    ("WbEgm.mod", "RAISE;"): "no other error is known of these instructions",
    ("WbEgm.mod", "DEFAULT:\nRETURN;"): "the link gives no other order",
}
"""Statements that no run reaches, each with its reason."""


@contextmanager
def modules_run(cell, folder=FOLDER, speed=50.0):
    """A controller that runs modules, and the cell with its controller there."""
    one = GuidedController(cell, read_setup(folder), speed=speed)
    thread = threading.Thread(target=one.run)
    thread.start()
    options = {"silence_ms": 1000}
    at = replace(cell.controller, port=one.port, state_port=one.state_port, options=options)
    try:
        wait_until(lambda: all(arm.is_guided for arm in one.mechanisms.values()))
        yield one, replace(cell, controller=at)
    finally:
        one.stop()
        thread.join(PATIENCE)
        assert not thread.is_alive()


def answers(one, arm):
    """What the module of an arm has told last: ticket and order."""
    holder, at = one.tasks[TASKS[arm]].loaded.find("wb_to").place
    return holder[at][1:3]


def stands_at(one, cell, arm, q):
    here = one.mechanisms[TASKS[arm]].here
    return np.abs(cell.arm(arm).from_axes(np.deg2rad(here)) - q).max()


def test_nothing_speaks_against_the_modules():
    assert check([FOLDER]).problems == []


def test_a_plan_is_led_through_the_modules_and_not_begun_again(planned):
    cell, plan, approval = planned
    with modules_run(cell) as (one, there):
        receipts = list(send(plan, approval, there, patience=PATIENT))
        legs = [leg for step in plan.sequence for _, leg in step.runs]
        assert [each.kind for each in receipts if each.kind != "order"] == legs
        for arm in TASKS:
            assert stands_at(one, cell, arm, plan.arm(arm).legs[-1].q[-1]) < np.deg2rad(0.1)
            ticket, done = answers(one, arm)
            assert ticket == float(int(approval.digest[:12], 16))
            orders = [each for each in receipts if each.kind == "order" and each.arm == arm]
            assert done == len(orders) == 5, "begin, three grips, end"
        # Silence after the end is no fault: EGM is taken up again, and the ticket is kept.
        wait_until(lambda: all(arm.is_guided for arm in one.mechanisms.values()))
        with pytest.raises(LinkError, match="has begun this plan already"):
            list(send(plan, approval, there, patience=PATIENT))
        assert one.written == []


def begun_and_stopped(plan, approval, there):
    """Both arms have begun it, and were told to end."""
    sending = send(plan, approval, there, patience=PATIENT)
    assert [next(sending).heard for _ in TASKS] == ["done: begin"] * 2
    sending.close()


def test_a_plan_that_was_begun_before_others_is_not_begun_again(planned):
    cell, plan, approval = planned
    with modules_run(cell) as (one, there):
        for earlier in (0, 1):
            begun_and_stopped(plan, replace(approval, at=approval.at - earlier), there)
            wait_until(lambda: all(arm.is_guided for arm in one.mechanisms.values()))
        with pytest.raises(LinkError, match="has begun this plan already; nothing runs twice"):
            list(send(plan, approval, there, patience=PATIENT))


def test_whoever_goes_away_leaves_an_arm_that_stands_until_a_person_has_looked(planned):
    cell, plan, approval = planned
    with modules_run(cell) as (one, there):
        sending = send(plan, approval, there, patience=PATIENT)
        next(each for each in sending if each.kind != "order")
        # Nobody asks for the next receipt: nobody answers.
        wait_until(lambda: len(one.written) == 2)
        assert {"Workbench: nothing was heard, the right arm stands"} < set(one.written)
        stopped = [one.tasks[task] for task in TASKS.values()]
        wait_until(lambda: not any(task.is_running for task in stopped))
        with pytest.raises(LinkError):
            list(sending)
        one.do(one.start_anew)
        wait_until(lambda: all(arm.is_guided for arm in one.mechanisms.values()))
        ticket = float(int(approval.digest[:12], 16))
        assert answers(one, "right")[0] == ticket, "remembered when the pointer is set to main"


def test_a_hand_that_fails_ends_the_plan(planned):
    cell, plan, approval = planned
    with modules_run(cell) as (one, there):
        name = plan.sequence[0].runs[0][0]
        one.moving[TASKS[name]].hand.has_fault = True
        patience = replace(PATIENT, answer=20.0)
        with pytest.raises(LinkError, match=f"has not carried out: {name} gripper"):
            list(send(plan, approval, there, patience=patience))
        assert one.written == [f"Workbench: the hand of the {name} arm has a fault"]
        assert stands_at(one, cell, name, plan.arm(name).legs[0].q[0]) < np.deg2rad(0.1)


def test_an_arm_whose_plan_has_ended_does_not_keep_the_other_waiting(planned, monkeypatch):
    monkeypatch.setattr(rapid_controller, "LOCKSTEP", 5.0)
    cell, plan, approval = planned
    with modules_run(cell) as (_, there):
        receipts = list(send(plan, approval, there, patience=PATIENT))
    assert [one.sent for one in receipts[-2:]] == ["end", "end"]


@pytest.mark.parametrize("done", [1, 6], ids=["before the other arm has begun", "on the way"])
def test_a_stop_brakes_and_ends(planned, done):
    cell, plan, approval = planned
    with modules_run(cell) as (one, there):
        taken = []
        with pytest.raises(JobCancelled, match="reported that it stands after"):
            for receipt in send(
                plan, approval, there, cancelled=lambda: len(taken) >= done, patience=PATIENT
            ):
                taken.append(receipt)
        assert one.written == [], "the module was told to end"


def test_an_emergency_stop_is_reported_and_the_arm_stands(planned):
    cell, plan, approval = planned
    with modules_run(cell) as (one, there):
        sending, name = send(plan, approval, there, patience=PATIENT), plan.sequence[0].runs[0][0]
        next(each for each in sending if each.kind != "order")
        one.do(one.emergency_stop)
        with pytest.raises(LinkError, match="the motors are off"):
            list(sending)
        stood = np.array(one.mechanisms[TASKS[name]].here)
        one.do(lambda: None)
        assert np.array_equal(one.mechanisms[TASKS[name]].here, stood)


def test_states_are_streamed_beside_it(planned):
    cell, _, _ = planned
    with modules_run(cell, speed=20.0) as (_, there):
        states = AbbEgm().states(there, lambda: False)
        state = next(states)
        assert state.joints["left"] == pytest.approx(cell.arm("left").home.tolist(), abs=1e-6)
        assert state.fault == "" and state.moving == ""
        states.close()


def test_every_statement_of_the_modules_is_executed(planned):
    cell, plan, approval = planned
    covered, keys = set(), set()
    for scene in ("whole", "left alone", "broken hand"):
        with modules_run(cell) as (one, there):
            name = plan.sequence[0].runs[0][0]
            one.moving[TASKS[name]].hand.has_fault = scene == "broken hand"
            patience = replace(PATIENT, answer=20.0) if scene == "broken hand" else PATIENT
            sending = send(plan, approval, there, patience=patience)
            if scene == "left alone":
                next(sending)
                wait_until(lambda: len(one.written) > 0)
                one.do(one.start_anew)
            elif scene == "broken hand":
                with pytest.raises(LinkError):
                    list(sending)
            else:
                carried = []
                for _ in sending:
                    payload = one.mechanisms[TASKS[name]].payload
                    if round(payload[0], 3) not in carried:
                        carried.append(round(payload[0], 3))
                loads = plan.arm(name).loads
                assert carried[-2:] == [0.23, round(loads.carried(True).mass, 3)]
                assert payload[0] == pytest.approx(0.23), "the part is put down"
                begun_and_stopped(plan, replace(approval, at=approval.at - 1), there)
                wait_until(lambda: all(arm.is_guided for arm in one.mechanisms.values()))
                with pytest.raises(LinkError, match="already"):
                    list(send(plan, approval, there, patience=PATIENT))
            covered, keys = covered | one.covered, keys | one.keys
    lines = {path.name: path.read_text().splitlines() for path in FOLDER.glob("*.mod")}
    left = {(module, line) for module, line, _ in keys - covered}
    told = set()
    for module, line in left:
        text, before = lines[module][line - 1].strip(), lines[module][line - 2].strip()
        told.add((module, f"{before}\n{text}" if before == "DEFAULT:" else text))
    assert told == set(NOT_EXECUTED)


@pytest.mark.timeout(1800)
def test_the_modules_keep_the_promises_of_the_link(planned):
    class OverRapid(AbbEgm):
        def serve(self, cell, simulation, ready):
            super().serve(cell, replace(simulation, rapid=FOLDER), ready)

    check_robot_link(OverRapid(), *planned)


def test_where_nobody_answers_egm_ends_and_is_taken_up_anew(planned):
    cell, _, _ = planned
    heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with heard, modules_run(cell, speed=1.0) as (one, _):
        heard.bind(("127.0.0.1", one.port))
        heard.settimeout(PATIENCE)
        numbers = [wire.read_feedback(heard.recv(wire.LONGEST_MESSAGE), 7).number]
        while numbers[-1] >= numbers[0]:
            numbers.append(wire.read_feedback(heard.recv(wire.LONGEST_MESSAGE), 7).number)
        assert one.written == [], "outside of a plan it is no fault"


READY = """EGMGetId id;
EGMSetupUC ROB_R,id,"default","Here"\\Joint;
EGMActJoint id\\J1:=w\\J2:=w\\J3:=w\\J4:=w\\J5:=w\\J6:=w\\J7:=w\\SampleRate:=4;
"""
RUN = "EGMRunJoint id,EGM_STOP_HOLD\\J1\\J2\\J3\\J4\\J5\\J6\\J7"


@pytest.mark.parametrize(
    ("body", "says"),
    [
        (READY + RUN + "\\CondTime:=0.2;", "the program has ended"),
        (READY + "EGMReset id;\n" + RUN + ";", "EGMGetId comes first"),
        ("EGMGetId id;\n" + RUN + ";", "EGMActJoint comes first"),
        (READY.replace("ROB_R", "ROB_L"), "T_ROB_R does not move ROBL"),
        (READY.replace("Here", "There"), "there is no UDPUC device 'There'"),
        (READY.replace("\\SampleRate:=4", "\\SampleRate:=8"), "another \\\\SampleRate than 4"),
        (READY.replace("\\J7:=w", ""), "EGMActJoint without"),
        (READY + RUN.replace("\\J7", "") + ";", "does not lead all axes"),
        (READY + "EGMStreamStart id;", "configured for motion"),
        ("FOR k FROM 1 TO 5 DO\nEGMGetId id;\nENDFOR", "all identities of EGM are taken"),
    ],
)
def test_instructions_do_what_is_known_of_them(planned, tmp_path, body, says):
    cell, _, _ = planned
    head = "MODULE m\nVAR egmident id;\nCONST egm_minmax w:=[-1,1];\nPROC main()\n"
    (tmp_path / "m.mod").write_text(f"{head}{body}\nENDPROC\nENDMODULE\n")
    (tmp_path / "controller.toml").write_text(
        '[tasks.T_ROB_R]\nmodules = ["m"]\narm = "right"\n[outputs]\n'
        '[devices]\nHere = ["motion", "right"]\n'
    )
    one = GuidedController(cell, read_setup(tmp_path), speed=50.0)
    thread = threading.Thread(target=one.run)
    thread.start()
    task = one.tasks["T_ROB_R"]
    wait_until(lambda: task.stopped_by != "")
    assert re.search(says, task.stopped_by), task.stopped_by
    one.stop()
    thread.join(PATIENCE)


def test_a_device_of_no_arm_is_refused_with_its_name(planned, tmp_path):
    cell, _, _ = planned
    for file in FOLDER.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    setup = tmp_path / "controller.toml"
    setup.write_text(setup.read_text().replace('["states", "left"]', '["states", "middle"]'))
    with pytest.raises(InputError, match=r"device WbLeftStates: .* not states, middle"):
        GuidedController(cell, read_setup(tmp_path))


def test_what_only_the_twin_can_do_is_refused(planned):
    cell, _, _ = planned
    wanted = Simulation("127.0.0.1", 0, 0, 1.0, None, None, ("cut",), float("inf"), FOLDER)
    with pytest.raises(InputError, match="--fault are of the twin"):
        AbbEgm().serve(cell, wanted, lambda running: None)
