"""The link to Universal Robots: the foreign client, and a controller's twin that it accepts."""

import re
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from twins import PATIENT, approved_for, twin_of
from waiting import PATIENCE, wait_until

import workbench
from workbench.devices.universal_robots.link import UrRtde
from workbench.devices.universal_robots.program import ProgramSettings, program_of
from workbench.devices.universal_robots.rtde import PAUSED, PLAYING, STOPPING
from workbench.devices.universal_robots.twin import SimulatedUr
from workbench.devices.universal_robots.urscript import read_program, seconds_of
from workbench.devices.universal_robots.ways import UrWay
from workbench.model.errors import CommandRefused, InputError, JobCancelled, LinkError
from workbench.model.load import Load, Loads
from workbench.model.robot import Tcp
from workbench.plugins.misfit import link_problem, misfit
from workbench.plugins.robot_link import Simulation, controller_by, send
from workbench.testing import check_robot_link

pytest.importorskip(
    "rtde_receive", reason="ur-rtde is not installed: pip install 'workbench[ur-rtde]'"
)


@pytest.fixture(scope="module")
def planned():
    """A cell with six axes, spoken to by this link, a plan, and its approval."""
    return approved_for("ur-rtde")


def plans(twin) -> list[str]:
    return [text for text in twin.programs if "workbench_plan" in text]


@pytest.mark.timeout(1800)
def test_it_keeps_the_promises_of_every_link(planned, host):
    check_robot_link(UrRtde(), *planned, host=host)


def test_the_program_is_the_plan_waypoint_by_waypoint(planned):
    cell, plan, approval = planned
    arm = cell.arms[0]
    text = program_of(cell, plan, approval, ProgramSettings(3, 0.25, 2.0)).text
    moves = [line for line in read_program(text) if line.name == "movej"]
    legs = [plan.arm(name).leg(leg) for step in plan.sequence for name, leg in step.runs]
    waypoints = [q for leg in legs for q in leg.q[1:]]
    assert len(moves) == len(waypoints) > 10
    _, _, velocity = cell.robot.limits(arm.joints)
    q = legs[0].q[0]
    for line, waypoint in zip(moves, waypoints, strict=True):
        sent = arm.from_axes(line.q)
        assert np.abs(sent - waypoint).max() < 1e-9, "what is sent is what was proven"
        share = np.abs(sent - q) / np.abs(sent - q).max()
        assert np.all(share * line.v <= velocity + 1e-9)
        assert np.all(share * line.a <= arm.acceleration + 1e-9)
        q = waypoint
    ways = np.array([np.abs(np.diff(leg.q, axis=0)).max(axis=1) for leg in legs], dtype=object)
    seconds = np.concatenate([np.diff(leg.t) for leg in legs])
    takes = [
        seconds_of(way, line.v, line.a)
        for way, line in zip(np.concatenate(list(ways)), moves, strict=True)
    ]
    assert np.all(np.array(takes) >= seconds - 2e-3), "no faster than the plan was timed"
    hands = re.findall(r"set_standard_digital_out\(3, (\w+)\)", text)
    assert hands == ["False", "True", "False"], "open, closed on the part, open at the place"


def with_outputs(cell, *outputs):
    """The cell with a tool whose TCPs have outputs of their own, or none."""
    (arm,) = cell.arms
    T = arm.tool.T_flange_tcp
    tcps = tuple(Tcp(f"tcp{k}", T, (), output) for k, output in enumerate(outputs, start=1))
    tool = replace(arm.tool, tcps=tcps, tcp=tcps[0].name)
    return replace(cell, arms=(replace(arm, tool=tool),))


@pytest.mark.parametrize(("tcp", "output"), [("", 3), ("tcp1", 3), ("tcp2", 5), ("tcp3", 0)])
def test_the_program_switches_the_output_of_the_tcp_that_takes_the_part(planned, tcp, output):
    cell, plan, approval = planned
    cell = with_outputs(cell, None, 5, 0)
    plan = replace(plan, arms=tuple(replace(arm, tcp=tcp) for arm in plan.arms))
    text = program_of(cell, plan, approval, ProgramSettings(3, 0.25, 2.0)).text
    hands = re.findall(r"set_standard_digital_out\((\d), (\w+)\)", text)
    assert hands == [(str(output), state) for state in ("False", "True", "False")]


def test_a_link_that_switches_no_outputs_refuses_them(planned):
    cell, plan, _ = planned
    assert misfit(plan, with_outputs(cell, None, 5)) is None
    other = replace(cell, controller=controller_by("abb-socket"))
    assert misfit(plan, with_outputs(other, None, None)) != misfit(
        plan, with_outputs(other, None, 5)
    )
    assert link_problem(with_outputs(other, None, None)) is None
    assert str(link_problem(with_outputs(other, None, 5))) == (
        "the robot link abb-socket cannot switch the output of TCP tcp2; leave `output` out"
    )


def with_loads(plan):
    loads = Loads(
        Load(0.8, np.array([0.0, 0.0, 0.05]), np.diag([0.002, 0.002, 0.001])),
        Load(0.2, np.array([0.0, 0.01, 0.15]), np.diag([1e-4, 1e-4, 1e-4])),
    )
    return replace(plan, arms=tuple(replace(one, loads=loads) for one in plan.arms)), loads


def test_the_program_tells_what_the_arm_carries_whenever_the_gripper_has_moved(planned):
    cell, plan, approval = planned
    plan, loads = with_loads(plan)
    lines = read_program(program_of(cell, plan, approval, ProgramSettings(3, 0.25, 2.0)).text)
    told = [tuple(map(float, one.words)) for one in lines if one.name == "set_target_payload"]
    for numbers, holding in zip(told, (False, True, False), strict=True):
        load = loads.carried(holding)
        inertia = load.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        assert numbers == pytest.approx((load.mass, *load.centre, *inertia), abs=1e-6)
    old = program_of(cell, plan, approval, ProgramSettings(3, 0.25, 2.0, sends_inertia=False)).text
    assert old.count("set_payload(0.8") == 2 and old.count("set_payload(1.0") == 1
    assert read_program(old)
    none = program_of(cell, planned[1], approval, ProgramSettings(3, 0.25, 2.0)).text
    assert ("payload" in none) == (planned[1].arms[0].loads is not None)


@pytest.mark.parametrize(
    "call",
    [
        "set_target_payload(-1.0, [0, 0, 0.1], [0, 0, 0, 0, 0, 0])",
        "set_target_payload(1.0, [0, 0], [0, 0, 0, 0, 0, 0])",
        "set_target_payload(1.0, [0, 0, 0.1], [-1, 0, 0, 0, 0, 0])",
        "set_target_payload(1.0, [0, 0, 0.1])",
        "set_payload(1.0, [0, 0, nan])",
    ],
)
def test_a_payload_that_cannot_be_is_not_taken(call):
    with pytest.raises(InputError, match="not known"):
        read_program(f"def one():\n  {call}\nend\n")


def test_a_plan_is_carried_out_once_and_leg_by_leg(planned, host):
    cell, plan, approval = planned
    shown = []
    with twin_of(cell, host) as (twin, there):
        receipts = list(send(plan, approval, there, show=shown.append, patience=PATIENT))
        legs = [leg for step in plan.sequence for _, leg in step.runs]
        assert [one.kind for one in receipts] == ["program", *legs, "end"]
        assert receipts[0].sent == plans(twin)[0] and len(plans(twin)) == 1
        end = plan.arms[0].legs[-1].q[-1]
        assert np.abs(cell.arms[0].from_axes(twin.q) - end).max() < 1e-6
        assert twin.outputs == {0: False}
        assert shown[-1].joints is not None and shown[-1].steps == len(legs)
        # The controller remembers the ticket: the same approval moves nothing again.
        with pytest.raises(LinkError, match="has begun this plan already"):
            list(send(plan, approval, there, patience=PATIENT))
        assert len(plans(twin)) == 1


def test_an_approval_that_ran_out_while_connecting_moves_nothing(planned, host):
    cell, plan, approval = planned
    asked = []

    def now() -> float:
        asked.append(1)
        return approval.at + (0 if len(asked) < 3 else 1e6)

    with twin_of(cell, host) as (twin, there), pytest.raises(CommandRefused, match="ran out"):
        list(send(plan, approval, there, now=now, patience=PATIENT))
    assert twin.programs == [] or plans(twin) == []


def test_a_robot_that_stands_elsewhere_is_not_moved(planned, host):
    cell, plan, approval = planned
    start = cell.arms[0].to_axes(cell.arms[0].home)
    start[1] += np.deg2rad(0.5)
    with (
        twin_of(cell, host, start=start.tolist()) as (twin, there),
        pytest.raises(LinkError, match=r"stands 0\.5 deg from the start of the plan"),
    ):
        list(send(plan, approval, there, patience=PATIENT))
    assert plans(twin) == []


def test_a_robot_in_local_control_is_not_moved(planned, host):
    cell, plan, approval = planned
    with (
        twin_of(cell, host, faults=["local"]) as (twin, there),
        pytest.raises(LinkError, match="choose remote control"),
    ):
        list(send(plan, approval, there, patience=PATIENT))
    assert plans(twin) == []


def test_a_protective_stop_ends_the_sending(planned, host):
    cell, plan, approval = planned
    receipts = []
    with (
        twin_of(cell, host, faults=["protective-stop@3"]) as (twin, there),
        pytest.raises(LinkError, match="protective stop"),
    ):
        for receipt in send(plan, approval, there, patience=PATIENT):
            receipts.append(receipt)
    assert receipts[-1].done <= 3 and len(plans(twin)) == 1


def test_a_cable_that_is_cut_is_noticed_and_the_robot_stops_by_itself(planned, host):
    cell, plan, approval = planned
    with twin_of(cell, host, faults=["cut@2"], speed=0.3) as (twin, there):
        patience = replace(PATIENT, silence=1.0)
        with pytest.raises(LinkError):
            list(send(plan, approval, there, patience=patience))
        wait_until(lambda: twin._runtime != PLAYING)
        stood = twin.q
        time.sleep(0.1)
        assert twin.q == stood


def test_whoever_goes_away_leaves_a_robot_that_stands(planned, host):
    cell, plan, approval = planned
    with twin_of(cell, host, speed=0.05) as (twin, there):
        sending = send(plan, approval, there, patience=PATIENT)
        next(sending)
        wait_until(lambda: twin._runtime == PLAYING)
        sending.close()
        wait_until(lambda: twin._runtime != PLAYING)
        far = plan.arms[0].legs[-1].q[-1]
        assert len(plans(twin)) == 1 and twin.q != tuple(far)


def test_a_client_too_slow_to_be_there_is_stopped_by_the_controller(planned, host):
    cell, plan, approval = planned
    with twin_of(cell, host, speed=0.05) as (twin, there):
        sending = send(plan, approval, there, patience=replace(PATIENT, silence=0.5))
        next(sending)
        # Nobody asks for the next receipt: nobody is there.
        wait_until(lambda: twin.is_protective)
        assert not twin.is_playing
        with pytest.raises(LinkError):
            list(sending)


def test_a_stop_is_acknowledged(planned, host):
    cell, plan, approval = planned
    shown, taken = [], []
    with twin_of(cell, host, speed=0.05) as (twin, there):
        with pytest.raises(JobCancelled, match="reported that it stands after"):
            for receipt in send(
                plan,
                approval,
                there,
                cancelled=lambda: len(taken) > 1,
                show=shown.append,
                patience=PATIENT,
            ):
                taken.append(receipt)
        assert twin._runtime != PLAYING
        assert shown[-1].phase == "stopped" and shown[-1].stopped is not None


def test_a_robot_that_still_brakes_does_not_stand(planned, host):
    cell, plan, approval = planned
    shown, taken = [], []
    with twin_of(cell, host, speed=0.05, faults=["brakes"]) as (twin, there):
        sending = send(
            plan,
            approval,
            there,
            cancelled=lambda: len(taken) > 1,
            show=shown.append,
            patience=replace(PATIENT, stop=1.0),
        )
        with pytest.raises(JobCancelled, match="did not report that it stands: use the emergency"):
            for receipt in sending:
                taken.append(receipt)
        assert twin._runtime == STOPPING
        assert all(status.stopped is None for status in shown)
        states = UrRtde().states(there, lambda: False)
        assert next(states).moving == "right"
        states.close()


def test_a_paused_program_of_somebody_else_is_not_replaced(planned, host):
    cell, plan, approval = planned
    with twin_of(cell, host) as (twin, there):
        twin._runtime = PAUSED
        with pytest.raises(LinkError, match="holds one that is paused"):
            list(send(plan, approval, there, patience=PATIENT))
    assert plans(twin) == []


def test_states_are_reported_also_while_nothing_is_sent(planned, host):
    cell, _, _ = planned
    with twin_of(cell, host) as (twin, there):
        states = UrRtde().states(there, lambda: False)
        state = next(states)
        assert state.joints["right"] == pytest.approx(cell.arms[0].home.tolist())
        assert state.moving == "" and state.fault == ""
        twin._safety = 1 << 2
        assert next(states).fault == "protective stop"
        states.close()


def test_nobody_there_is_told_in_one_sentence(planned, host):
    cell, plan, approval = planned
    there = replace(cell, controller=replace(cell.controller, host=host))
    with pytest.raises(LinkError, match=f"no controller answers at {host}:30002"):
        list(send(plan, approval, there, patience=PATIENT))
    with pytest.raises(LinkError, match=f"no controller answers at {host}:30004"):
        next(UrRtde().states(there, lambda: False))


def test_cells_and_wishes_that_it_cannot_serve_are_refused(planned):
    cell, _, _ = planned
    link = UrRtde()
    with pytest.raises(InputError, match="one arm of six turning joints; this cell has 2 arms"):
        link.check(workbench.read_cell("yumi"))
    elsewhere = replace(cell, controller=replace(cell.controller, state_port=1026))
    with pytest.raises(InputError, match="state_port = 1026: ur-rtde reads states at 30004"):
        link.check(elsewhere)
    wanted = Simulation("127.0.0.1", 0, 0, 1.0, None, None, ("melts",), float("inf"))
    with pytest.raises(InputError, match="fault 'melts'"):
        link.serve(cell, wanted, lambda running: None)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("movej([1])\nend\n", "a program from `def` to `end`"),
        ("def a():\n  movej([1, 2], a=1.0, v=1.0)\nend\n", "line 2"),
        ("def a():\n  movel(p[1, 2], a=1.0, v=1.0)\nend\n", "line 2: 'movel"),
        ("def a():\n  movej([nan, 0, 0, 0, 0, 0], a=1.0, v=1.0)\nend\n", "line 2"),
        ("def a():\n  set_tcp(p[0.0, 0.0, 0.1, 0.0, 0.0, 0.0])\nend\n", "line 2: 'set_tcp"),
        ("def a():\n  sleep(1.0)\n  halt\nend\n", "line 3: 'halt'"),
        ("def a():\n  sleep(1.0)\n  end\nend\n", "line 3: 'end'"),
        ("def a():\n  if read_output_integer_register(1) == 2:\n    halt\nend\n", "no end"),
        ("def a():\n  if True:\n    halt\n  end\nend\n", "line 2: 'if True:'"),
        ("def a():\n  write_output_integer_register(1, 1e9)\nend\n", "line 2"),
    ],
)
def test_the_twin_refuses_what_it_does_not_know(text, says):
    with pytest.raises(InputError, match=re.escape(says)):
        read_program(text)


def test_axes_begin_and_end_together_and_keep_speed_and_acceleration():
    [line] = read_program("def a():\n  movej([1.0, -0.5, 0, 0, 0, 0], a=2.0, v=0.8)\nend\n")
    total = seconds_of(1.0, 0.8, 2.0)
    times = np.linspace(0, total, 2001)
    way = UrWay([0.0] * 6, [line], lambda axes: axes[:, :3])
    assert way.seconds == pytest.approx(total)
    q = np.array([way.at(t) for t in times])
    assert q[-1] == pytest.approx([1.0, -0.5, 0, 0, 0, 0])
    assert np.abs(q[:, 1] + q[:, 0] / 2).max() < 1e-12
    speed = np.diff(q[:, 0]) / np.diff(times)
    assert speed.max() == pytest.approx(0.8, abs=1e-3) and speed.min() > -1e-12
    assert np.abs(np.diff(speed) / np.diff(times)[1:]).max() < 2.0 + 1e-3


def test_programs_that_begin_while_others_are_stopped_leave_the_twin_whole(host, monkeypatch):
    start = threading.Thread.start

    def late(thread) -> None:
        time.sleep(0.001)
        start(thread)

    twin = SimulatedUr(Simulation(host), [0.0] * 6, positions=lambda axes: axes[:, :3])
    text = "def a():\n  sleep(0.0)\nend\n"

    def stopped() -> None:
        while len(twin.programs) < 50:
            twin._end_program()

    thread = threading.Thread(target=stopped)
    thread.start()
    monkeypatch.setattr(threading.Thread, "start", late)
    for _ in range(50):
        twin._begin(text)
    monkeypatch.undo()
    # What a thread raises fails the test.
    thread.join(PATIENCE)
    wait_until(lambda: twin._runtime != PLAYING)
    twin.stop()
    twin.run()
