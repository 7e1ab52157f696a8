"""A plan streamed to the twin of a controller: all of it, once, on its way; any doubt ends it."""

import json
import threading
import time
from collections.abc import Sequence
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from egm_scenes import PATIENT, plan_of_two, twin_of
from waiting import wait_until

from workbench.devices.abb_egm import twin as abb_twin
from workbench.devices.abb_egm import wire
from workbench.devices.abb_egm.channel import Channel
from workbench.devices.abb_egm.link import AbbEgm
from workbench.devices.abb_egm.orders import LegRun, score_of
from workbench.devices.abb_egm.twin import SimulatedEgm
from workbench.devices.abb_egm.twin_arm import TwinArm
from workbench.model.errors import CommandRefused, InputError, JobCancelled, LinkError
from workbench.plugins.robot_link import Simulation, send
from workbench.testing import check_robot_link

pytest.importorskip(
    "google.protobuf", reason="protobuf is not installed: pip install 'workbench[egm]'"
)


def off_the_way(cell, plan, approval, q, arm):
    """How far [rad] a configuration is from anything that this arm does in the plan."""
    ways = [one.way for one in score_of(cell, plan, approval).items if isinstance(one, LegRun)]
    ways = [way for way in ways if way.path.shape[1] == len(q)]
    names = [one.arm for one in score_of(cell, plan, approval).items if isinstance(one, LegRun)]
    fine = [
        way.at(s)[0]
        for way, name in zip(ways, names, strict=True)
        if name == arm
        for s in np.linspace(0, way.s[-1], 400)
    ]
    return float(np.abs(np.array(fine) - q).max(axis=1).min())


@pytest.mark.timeout(1800)
def test_it_keeps_the_promises_of_every_link(planned):
    check_robot_link(AbbEgm(), *planned)


def test_a_plan_is_streamed_once_with_its_grips_between_and_each_arm_ends_where_it_should(
    planned, tmp_path
):
    cell, plan, approval = planned
    shown, record = [], tmp_path / "orders.jsonl"
    with twin_of(cell, record=record) as (twin, there):
        receipts = list(send(plan, approval, there, show=shown.append, patience=PATIENT))
        legs = [leg for step in plan.sequence for _, leg in step.runs]
        assert [one.kind for one in receipts if one.kind != "order"] == legs
        assert [one.done for one in receipts] == list(range(1, receipts[-1].total + 1))
        for arm in twin.arms:
            end = plan.arm(arm.arm.name).legs[-1].q[-1]
            assert np.abs(arm.arm.from_axes(arm.axes) - end).max() < np.deg2rad(0.1)
            words = [order[3] for order in arm.orders]
            assert words == [wire.BEGIN, *[wire.GRIP] * (len(words) - 2), wire.END]
            closed = [bool(order[5]) for order in arm.orders if order[3] == wire.GRIP]
            assert closed == [False, True, False], "open, closed on the part, open at the place"
            numbers = [order[2] for order in arm.orders]
            assert numbers == [float(n) for n in range(1, len(numbers) + 1)]
        assert len(record.read_text().splitlines()) == sum(len(arm.orders) for arm in twin.arms)
        assert json.loads(record.read_text().splitlines()[0])["order"][0] == wire.VERSION
        assert shown[-1].phase == "ended" and set(shown[-1].joints) == {"right", "left"}
        # Modules in RAPID remember the ticket: the same approval moves nothing again.
        before = [arm.orders[:] for arm in twin.arms]
        with pytest.raises(LinkError, match="has begun this plan already"):
            list(send(plan, approval, there, patience=PATIENT))
        assert [arm.orders for arm in twin.arms] == before


def test_an_arm_whose_plan_has_ended_does_not_keep_the_other_waiting(planned, monkeypatch):
    twin = SimulatedEgm(planned[0], Simulation(speed=20.0))
    passed, answers = [0.0], [twin._sockets[0]]

    def select(_, __, ___, seconds):
        if answers:
            return [answers.pop()], [], []
        passed[0] += seconds
        return [], [], []

    monkeypatch.setattr(abb_twin, "select", SimpleNamespace(select=select))
    monkeypatch.setattr(abb_twin, "time", SimpleNamespace(monotonic=lambda: passed[0]))
    monkeypatch.setattr(twin, "_take", lambda k, one: None)
    twin._listen([0, 1], 0.0)
    for one in twin._sockets:
        one.close()
    shortest = next(one for one in fields(AbbEgm.Options) if one.name == "silence_ms")
    assert 0 < passed[0] * 1000 < shortest.metadata["low"]


def test_the_twin_reports_to_no_port_of_its_own(planned, monkeypatch):
    make = abb_twin._socket
    port, states = (abb_twin.free_ports("127.0.0.1", 2) for _ in range(2))
    wanted = [states, port + 1]
    monkeypatch.setattr(abb_twin, "_socket", lambda host: make(host, wanted.pop() if wanted else 0))
    twin = SimulatedEgm(planned[0], Simulation(port=port, state_port=states))
    own = {one.getsockname()[1] for one in twin._sockets}
    for one in twin._sockets:
        one.close()
    assert wanted == [] and len(own) == 2
    assert not own & {port, port + 1, states, states + 1}


def test_ports_are_given_out_once_though_nobody_listens_on_them_yet():
    given = [abb_twin.free_ports("127.0.0.1", 2) for _ in range(500)]
    assert len({first + k for first in given for k in range(2)}) == 1000


def test_a_plan_with_limits_of_jerk_is_streamed_to_its_end():
    cell, plan, approval = plan_of_two(jerk=20.0)
    with twin_of(cell) as (twin, there):
        list(send(plan, approval, there, patience=PATIENT))
        for arm in twin.arms:
            end = plan.arm(arm.arm.name).legs[-1].q[-1]
            assert np.abs(arm.arm.from_axes(arm.axes) - end).max() < np.deg2rad(0.1)


def test_an_approval_that_ran_out_before_anything_was_sent_moves_nothing(planned):
    cell, plan, approval = planned
    asked = []

    def now() -> float:
        asked.append(1)
        return approval.at + (0 if len(asked) < 3 else 1e6)

    with twin_of(cell) as (twin, there), pytest.raises(CommandRefused, match="ran out"):
        list(send(plan, approval, there, now=now, patience=PATIENT))
    assert all(not arm.is_attached and arm.orders == [] for arm in twin.arms)


def test_a_robot_that_stands_elsewhere_is_told_nothing(planned):
    cell, plan, approval = planned
    with twin_of(cell) as (twin, there):
        twin.arms[0]._target = twin.arms[0].axes = twin.arms[0].axes + np.deg2rad(0.5)
        with pytest.raises(LinkError, match=r"stands 0\.5 deg from the start of the plan"):
            list(send(plan, approval, there, patience=PATIENT))
        assert not twin.arms[0].is_attached and twin.arms[0].orders == []


def test_a_module_that_takes_up_egm_anew_before_anything_is_sent_is_waited_for(
    planned, monkeypatch
):
    cell, plan, approval = planned
    asked, hear_first = [], Channel.hear_first

    def upset_once(channel):
        asked.append(channel)
        if len(asked) == 4:
            raise LinkError("report 1 came after 250: twice, or out of order")
        return hear_first(channel)

    monkeypatch.setattr(Channel, "hear_first", upset_once)
    with twin_of(cell) as (_, there):
        sending = send(plan, approval, there, patience=PATIENT)
        next(one for one in sending if one.kind != "order")
        sending.close()
    assert len(asked) > 4


def _stand(arms: Sequence[TwinArm]) -> bool:
    stood = [one.axes.copy() for one in arms]
    time.sleep(0.02)
    return all(np.array_equal(a, one.axes) for a, one in zip(stood, arms, strict=True))


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ("motors-off@1", r"at leg 1 of \d+: left: the motors are off"),
        ("stuck@1", "does not follow in leg 1"),
        ("twice@1", "twice, or out of order"),
        ("jitter@1", r"a report came \d+ ms late in leg 1|silent"),
        ("cut@1", "silent for 1.0 s"),
    ],
)
def test_a_doubt_ends_the_motion_on_the_way(planned, monkeypatch, fault, says):
    cell, plan, approval = planned
    taken = []
    # Held up for 600 ms: a twin in haste would make that up before anybody notices.
    speed = 1.0 if "jitter" in fault else 100.0
    monkeypatch.setattr(abb_twin, "HELD_UP", 150)
    # A busy machine is silent, too: where nothing else waits, a second lasts a minute.
    is_slow = "motors-off" in fault
    patience = replace(PATIENT, clock=lambda: time.monotonic() / 60) if is_slow else PATIENT
    # Who is not answered waits for half a second, which is too long where nobody answers any more.
    silence_ms = {"cut@1": 1000, "jitter@1": 500}.get(fault, 400)
    with twin_of(cell, silence_ms=silence_ms, speed=speed, faults=[fault]) as (robot, there):
        with pytest.raises(LinkError, match=says):
            for receipt in send(plan, approval, there, patience=patience):
                taken.append(receipt.kind)
        arm = robot.arms[0] if robot.arms[0].leg or robot.arms[0].orders[-1][3] else robot.arms[1]
        assert set(taken) == {"order"}, "no leg was told to be done"
        if "cut" in fault:
            wait_until(lambda: all(one.mci == wire.MCI_STOPPED for one in robot.arms))
        # Its filter still has 20 ms of the way to go, and a busy machine is late.
        wait_until(lambda: _stand(robot.arms), "the arms to stand")
        q = arm.arm.from_axes(arm.axes)
        assert off_the_way(cell, plan, approval, q, arm.arm.name) < np.deg2rad(0.5)


def test_reports_that_are_lost_now_and_then_make_it_later_and_leave_it_on_its_way(planned):
    cell, plan, approval = planned
    with twin_of(cell, faults=["lost@1"]) as (twin, there):
        sending = send(plan, approval, there, patience=PATIENT)
        name, leg = plan.sequence[0].runs[0]
        next(one for one in sending if one.kind == leg)
        arm = next(one for one in twin.arms if one.arm.name == name)
        end = plan.arm(name).leg(leg).q[-1]
        assert np.abs(arm.arm.from_axes(arm.axes) - end).max() < np.deg2rad(0.2)
        sending.close()


def test_a_stop_brakes_on_the_way_and_tells_that_the_robot_stands(planned):
    cell, plan, approval = planned
    shown = []
    with twin_of(cell) as (twin, there):
        with pytest.raises(JobCancelled, match=r"reported that it stands after \d+ ms"):
            list(
                send(
                    plan,
                    approval,
                    there,
                    cancelled=lambda: any(arm.leg == 2 for arm in twin.arms),
                    show=shown.append,
                    patience=PATIENT,
                )
            )
        assert shown[-1].phase == "stopped" and shown[-1].stopped is not None
        for arm in twin.arms:
            assert arm.orders[-1][3] == wire.END
            q = arm.arm.from_axes(arm.axes)
            assert off_the_way(cell, plan, approval, q, arm.arm.name) < np.deg2rad(0.2)


def test_whoever_goes_away_leaves_a_robot_that_stands(planned):
    cell, plan, approval = planned
    with twin_of(cell) as (twin, there):
        sending = send(plan, approval, there, patience=PATIENT)
        for receipt in sending:
            if receipt.kind != "order":
                break
        # Nobody asks for the next receipt: nobody answers, and EGM gives up.
        wait_until(lambda: any(arm.mci == wire.MCI_STOPPED for arm in twin.arms))
        with pytest.raises(LinkError):
            list(sending)


def test_where_nobody_leads_the_arms_any_more_they_go_home_when_asked_to(planned):
    cell, plan, approval = planned
    with twin_of(cell, home_after=0.5, faults=["motors-off@1"]) as (twin, there):
        with pytest.raises(LinkError, match="the motors are off"):
            list(send(plan, approval, there, patience=replace(PATIENT, stop=1.0)))
        homes = [one.arm.to_axes(one.arm.home) for one in twin.arms]

        def are_home():
            return all(np.array_equal(a.axes, q) for a, q in zip(twin.arms, homes, strict=True))

        wait_until(lambda: are_home() and all(one.motors == wire.MOTORS_ON for one in twin.arms))
        again = replace(approval, at=approval.at - 1)
        twin._faults.clear()
        receipts = list(send(plan, again, there, patience=PATIENT))
        assert receipts[-1].done == receipts[-1].total


def test_states_are_reported_also_while_nothing_is_sent(planned):
    cell, _, _ = planned
    with twin_of(cell, speed=20.0) as (twin, there):
        states = AbbEgm().states(there, lambda: False)
        state = next(states)
        assert state.joints["left"] == pytest.approx(cell.arm("left").home.tolist())
        assert state.fault == "" and state.moving == ""
        twin.arms[1].motors = wire.MOTORS_OFF
        assert next(states).fault == f"{twin.arms[1].arm.name}: the motors are off"
        states.close()


def test_a_port_that_is_taken_and_one_where_nobody_reports_are_told_in_one_sentence(planned):
    cell, plan, approval = planned
    with twin_of(cell, speed=1.0) as (_, there):
        first = AbbEgm().states(there, lambda: False)
        next(first)
        with pytest.raises(LinkError, match="at UDP port"):
            next(AbbEgm().states(there, lambda: False))
        first.close()
        empty = replace(there.controller, port=there.controller.port + 40)
        with pytest.raises(LinkError, match="no controller reports"):
            list(send(plan, approval, replace(there, controller=empty), patience=PATIENT))


def test_a_slower_share_takes_as_much_longer(planned):
    cell, plan, approval = planned
    slow = replace(approval, speed_share=0.5)
    with twin_of(cell) as (twin, there):
        began = twin._tick
        sending = send(plan, slow, there, patience=PATIENT)
        name, leg = plan.sequence[0].runs[0]
        sent = next(one.sent for one in sending if one.kind == leg)
        planned_seconds = plan.arm(name).leg(leg).seconds
        assert sent == f"{planned_seconds * 2:.3f} s of references"
        assert (twin._tick - began) * 0.004 >= planned_seconds * 2
        sending.close()


def test_cells_and_wishes_that_it_cannot_serve_are_refused(planned):
    cell, _, _ = planned
    link = AbbEgm()
    near = replace(cell, controller=replace(cell.controller, state_port=cell.controller.port + 1))
    with pytest.raises(InputError, match="as many ports from each on as there are arms"):
        link.check(near)
    wanted = Simulation("127.0.0.1", 0, 0, 1.0, None, None, ("melts",), float("inf"))
    with pytest.raises(InputError, match="fault 'melts'"):
        link.serve(cell, wanted, lambda running: None)


@pytest.mark.parametrize("is_moving", [True, False])
def test_one_arm_that_falls_silent_ends_the_motion_of_both(planned, monkeypatch, is_moving):
    cell, plan, approval = planned
    first = next(k for k, arm in enumerate(cell.arms) if arm.name == plan.sequence[0].runs[0][0])
    silent = first if is_moving else 1 - first
    with twin_of(cell, silence_ms=400) as (twin, there):
        whole, cut = SimulatedEgm._say, threading.Event()

        def say(self, k, data, port):
            if twin.arms[first].leg:
                cut.set()
            if not (cut.is_set() and (k, port) == (silent, twin.port + silent)):
                whole(self, k, data, port)

        monkeypatch.setattr(SimulatedEgm, "_say", say)
        with pytest.raises(LinkError, match=r"silent for 0\.4 s"):
            list(send(plan, approval, there, patience=PATIENT))
        wait_until(lambda: _stand(twin.arms), "the arms to stand")
        assert twin.arms[first].leg <= 1, "no other leg has begun"


def test_states_end_where_one_arm_is_silent(planned, monkeypatch):
    cell, _, _ = planned
    with twin_of(cell, speed=20.0) as (twin, there):
        whole, cut = SimulatedEgm._say, threading.Event()

        def say(self, k, data, port):
            if not (cut.is_set() and (k, port) == (0, twin.state_port)):
                whole(self, k, data, port)

        monkeypatch.setattr(SimulatedEgm, "_say", say)
        states = AbbEgm().states(there, lambda: False)
        next(states)
        cut.set()
        with pytest.raises(LinkError, match="silent"):
            for _ in states:
                pass
