"""The pick server on TCP: a plan goes out leg by leg, once, and any doubt ends it."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from pick_scenes import PATIENT, Program, Sent, another, elsewhere, program, spoiled
from waiting import PATIENCE, wait_until

from workbench.devices.pick_server import server as serving
from workbench.devices.pick_server.link import PickServer
from workbench.model.errors import CommandRefused, InputError, JobCancelled, LinkError
from workbench.model.robot import AxisMapping
from workbench.plugins.misfit import link_problem
from workbench.plugins.robot_link import send, spoken_to_by
from workbench.testing import check_robot_link


@pytest.mark.timeout(1800)
def test_it_keeps_the_promises_of_every_link(planned):
    check_robot_link(PickServer(), *planned)


def legs_of(plan):
    return [plan.arm(arm).leg(leg) for step in plan.sequence for arm, leg in step.runs]


def test_what_arrives_is_what_was_proven_value_by_value(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent, robot = Sent(there, plan, approval), Program(there, there.controller.port)
    robot.cycle()
    receipts, error = sent.ended()
    robot.close()
    assert error is None
    _, _, fastest = cell.robot.limits(cell.arms[0].joints)
    waypoints = [words for job, _, words in robot.got if job == "point"]
    proven = [q for leg in legs_of(plan) for q in leg.q[1:]]
    before = [q for leg in legs_of(plan) for q in leg.q[:-1]]
    least = [t for leg in legs_of(plan) for t in np.diff(leg.t)]
    assert len(waypoints) == len(proven) > 10
    for words, q, last, seconds in zip(waypoints, proven, before, least, strict=True):
        got = cell.arms[0].from_axes(np.deg2rad([float(word) for word in words[1:7]]))
        assert np.abs(got - q).max() < 1e-9
        assert float(words[8]) >= seconds - 1e-9, "no quicker than it was planned"
        share = np.abs(q - last) / fastest / float(words[8])
        assert float(words[7]) <= max(100 * share.max() + 1e-6, 0.1)
        assert words[9] == "0", "it stops at each waypoint"
    told = [receipt for receipt in receipts if receipt.sent.startswith(("LEG", "TO", "PLAN"))]
    assert len(told) == 1 + len(legs_of(plan)) + len(proven)
    assert [receipt.part.is_picked for receipt in receipts if receipt.part] == [True]


def test_at_a_share_of_the_speed_every_waypoint_takes_longer(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent = Sent(there, plan, replace(approval, speed_share=0.5))
    robot = Program(there, there.controller.port)
    robot.cycle()
    assert sent.ended()[1] is None
    robot.close()
    seconds = [float(words[8]) for job, _, words in robot.got if job == "point"]
    planned_for = [t for leg in legs_of(plan) for t in np.diff(leg.t)]
    for took, least in zip(seconds, planned_for, strict=True):
        assert took >= 2 * least - 1e-9


@pytest.mark.parametrize(
    ("fault", "words"),
    [("stray@2", "stands elsewhere"), ("anew@2", "began anew"), ("silent@2", "was silent")],
)
def test_a_doubt_ends_the_sending(planned, fault, words):
    cell, plan, approval = planned
    there = elsewhere(cell, silence_s=1.0) if fault == "silent@2" else elsewhere(cell)
    with program(there, fault, port=there.controller.port):
        receipts, error = Sent(there, plan, approval).ended()
    assert isinstance(error, LinkError) and words in str(error), error
    assert not any(receipt.heard.startswith("leg 3") for receipt in receipts)


def test_a_connection_that_ends_costs_nothing_and_an_empty_hand_is_reported(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    with program(there, "cut@3", "empty-hand", port=there.controller.port) as robot:
        receipts, error = Sent(there, plan, approval).ended()
        assert error is None
        reports = [(r.part.is_picked, r.part.is_missed) for r in receipts if r.part]
        assert reports == [(False, True)]
        assert len(robot.tickets) == 1
    heard = [r.heard for r in receipts if r.heard.startswith(("leg", "point", "done"))]
    assert len(heard) == len(set(heard)), "nothing is on record twice"


def test_a_stop_is_answered_at_the_next_request_and_acknowledged(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    stop = []
    sent = Sent(there, plan, approval, cancelled=lambda: bool(stop))
    robot = Program(there, there.controller.port)
    robot.begin()
    robot.leg(1)
    stop.append(True)
    wait_until(lambda: robot.ask("state")[0] == "STOP")
    assert robot.ask("done", "1", *robot.joints())[0] == "STOP"
    assert robot.ask("stop") == ("OK", "stop")
    receipts, error = sent.ended()
    assert isinstance(error, JobCancelled) and "acknowledged the stop" in str(error)
    assert robot.ask("leg", "2")[0] == "NO"
    robot.close()
    assert not any(receipt.heard.startswith("leg 2") for receipt in receipts)


def test_what_ended_before_its_end_is_answered_by_stop_until_the_program_has_stopped(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent, robot = Sent(there, plan, approval), Program(there, there.controller.port)
    robot.begin()
    robot.leg(1)
    assert robot.ask("leg", "1")[0] == "STOP", "no leg goes out twice"
    assert "does not follow" in str(sent.ended()[1])
    assert robot.ask("next", *robot.joints())[0] == "STOP"
    assert robot.ask("stop") == ("OK", "stop")
    assert robot.ask("next", *robot.joints())[0] == "WAIT"
    robot.close()


def test_a_program_inside_an_ended_plan_is_stopped_though_the_next_one_waits(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent, robot = Sent(there, plan, approval), Program(there, there.controller.port)
    robot.begin()
    robot.leg(1)
    assert robot.ask("leg", "1")[0] == "STOP"
    sent.ended()
    following = Sent(there, plan, another(approval, 1))
    wait_until(lambda: following.shown)
    for words in (("state",), ("done", "1", *robot.joints()), ("next", *robot.joints())):
        assert robot.ask(*words) == ("STOP", "ended")
    assert robot.ask("stop") == ("OK", "stop")
    assert robot.ask("state") == ("OK", "offered")
    robot.close()
    following.close()


def test_no_leg_goes_out_after_a_stop_while_the_disk_holds_up_the_receipts(planned):
    cell, plan, approval = planned
    there, stop = elsewhere(cell), threading.Event()
    taken, may_go_on = threading.Event(), threading.Event()

    def held_up():
        with pytest.raises(JobCancelled):
            for _ in send(plan, approval, there, cancelled=stop.is_set, patience=PATIENT):
                taken.set()
                may_go_on.wait(PATIENCE)

    thread = threading.Thread(target=held_up)
    thread.start()
    robot = Program(there, there.controller.port)
    robot.begin()
    assert taken.wait(PATIENCE)
    robot.leg(1)
    stop.set()
    assert robot.ask("done", "1", *robot.joints())[0] == "STOP"
    assert robot.ask("stop") == ("OK", "stop")
    robot.close()
    may_go_on.set()
    thread.join(PATIENCE)
    assert not thread.is_alive()


def test_an_approval_that_runs_out_before_the_first_leg_gives_none(planned):
    cell, plan, approval = planned
    there, late = elsewhere(cell), []

    def now():
        return approval.at + (1e9 if late else 0)

    sent, robot = Sent(there, plan, approval, now=now), Program(there, there.controller.port)
    robot.begin()
    late.append(True)
    assert robot.ask("leg", "1")[0] == "STOP"
    assert isinstance(sent.ended()[1], CommandRefused)
    robot.close()


def test_a_plan_that_nobody_asks_for_is_not_sent(planned):
    cell, plan, approval = planned
    receipts, error = Sent(elsewhere(cell, ask_s=1.0), plan, approval).ended()
    assert receipts == [] and "no robot program asked" in str(error)


def test_a_robot_that_stands_elsewhere_gets_no_plan(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    sent, robot = Sent(there, plan, approval), Program(there, there.controller.port)
    robot.q = robot.q + np.deg2rad(0.6)
    while (answer := robot.ask("next", *robot.joints()))[0] == "WAIT":
        time.sleep(0.01)
    assert answer[0] == "STOP"
    robot.close()
    assert "stands elsewhere" in str(sent.ended()[1])


def test_a_program_that_only_says_that_it_lives_does_not_keep_a_plan(planned):
    cell, plan, approval = planned
    there = elsewhere(cell, silence_s=5.0)
    sent, robot = Sent(there, plan, approval), Program(there, there.controller.port)
    robot.begin()
    wait_until(lambda: robot.ask("state", *robot.joints())[0] == "STOP")
    robot.close()
    assert "made no progress" in str(sent.ended()[1])


def test_bytes_that_come_late_twice_or_never_change_nothing(planned):
    cell, plan, approval = planned
    there = elsewhere(cell)
    with spoiled(there.controller.port, 3, often=1e-3) as (port, counts):
        robot = Program(there, port)
        # What is spoiled depends on how bytes come together: on until each kind has happened.
        for number in range(60):
            sent = Sent(there, plan, another(approval, number))
            robot.cycle()
            receipts, error = sent.ended()
            assert error is None
            heard = [r.heard for r in receipts]
            assert len(heard) == len(set(heard)) and receipts[-1].done == receipts[-1].total
            if number >= 4 and min(counts.values()) > 0:
                break
        robot.close()
    assert len(set(robot.plans)) == number + 1 and min(counts.values()) > 0, counts


def test_a_server_is_there_for_its_next_user_whenever_the_one_before_last_had_ended(
    planned, monkeypatch
):
    cell, ends = elsewhere(planned[0]), []

    class Timer:
        def __init__(self, seconds, end, given):
            ends.append(lambda: end(*given))

        def start(self):
            pass

    monkeypatch.setattr(serving.threading, "Timer", Timer)
    with PickServer().server_of(cell) as first:
        pass
    with PickServer().server_of(cell) as second:
        pass
    ends[0]()
    with PickServer().server_of(cell) as third:
        pass
    assert first is second is third
    ends[2]()
    with PickServer().server_of(cell) as fourth:
        assert fourth is not third
    ends[3]()


def test_another_link_refuses_a_controller_that_counts_otherwise(planned):
    cell = planned[0]
    arm = replace(cell.arms[0], mapping=AxisMapping(np.eye(6), np.zeros(6)))
    assert link_problem(replace(cell, arms=(arm,))) is None
    other = spoken_to_by(replace(cell, arms=(arm,)), "abb-socket")
    assert "axis_coupling" in str(link_problem(other))


def test_two_arms_are_refused(planned):
    cell = planned[0]
    with pytest.raises(InputError, match="moves one arm"):
        PickServer().check(replace(cell, arms=cell.arms * 2))


@pytest.mark.parametrize("host", ["0.0.0.0", "10.0.0.7", "::"])
def test_a_server_on_the_network_names_its_robot(planned, host):
    cell = planned[0]
    controller = replace(cell.controller, host=host)
    with pytest.raises(InputError, match=f"on {host} could be used by anybody"):
        PickServer().check(replace(cell, controller=controller))
    known = replace(controller, options={**controller.options, "client": "10.0.0.8"})
    PickServer().check(replace(cell, controller=known))
