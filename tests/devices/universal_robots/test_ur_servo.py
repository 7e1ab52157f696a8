"""Streams to Universal Robots: the plan's curve, followed within what was proven; doubts stop."""

import json
import os
import signal
from dataclasses import replace

import numpy as np
import pytest
from twins import PATIENT, approved_for, legs_of, twin_of

from workbench.devices.streamed_way import way_of
from workbench.devices.universal_robots import talking
from workbench.devices.universal_robots.following import Following
from workbench.devices.universal_robots.link import UrRtdeServo
from workbench.devices.universal_robots.program import ProgramSettings, program_of
from workbench.devices.universal_robots.sending import FOLLOWING_TOLERANCE
from workbench.devices.universal_robots.servo import (
    FOLLOWS_WITHIN,
    PERIOD,
    Servo,
    off_the_references,
    stream_of,
)
from workbench.devices.universal_robots.urscript import read_program
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.plugins.robot_link import send
from workbench.testing import check_robot_link

SERVO = Servo(0.03, 2000)


@pytest.fixture(scope="module")
def planned():
    """A cell with six axes that is streamed, a plan, and its approval."""
    return approved_for("ur-rtde-servo")


def streams_of(text):
    """The calls of `servoj` of each leg."""
    found, before = [], None
    for line in read_program(text):
        if line.name == "servoj":
            if before is None or before.name != "servoj":
                found.append([])
            found[-1].append(line)
        before = line
    return found


def test_references_are_the_plans_curve_in_its_time(planned):
    cell, plan, approval = planned
    arm = cell.arms[0]
    program = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0, servo=SERVO))
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    streams = streams_of(program.text)
    for leg, stream, references in zip(legs_of(plan), streams, program.references, strict=True):
        sent = np.array([arm.from_axes(line.q) for line in stream])
        count = len(references)
        assert np.abs(sent[:count] - references).max() < 1e-6
        assert np.all(sent[count:] == sent[count - 1]), "then it comes to rest there"
        assert np.abs(sent[-1] - leg.q[-1]).max() < 1e-6
        slower = (count - 1) * PERIOD / leg.seconds
        assert 1.0 <= slower < 1.3, "never faster than planned"
        way = way_of(leg, velocity, np.asarray(arm.acceleration), cell.policy.zone)
        curve = np.array([way.at(s)[0] for s in np.linspace(0.0, way.s[-1], 2000)])
        for q in sent[:count:5]:
            assert np.abs(curve - q).max(axis=1).min() < 1e-3
        assert np.all(np.abs(np.diff(sent, axis=0)) / PERIOD <= velocity * 1.001)
    slow = program_of(
        cell, plan, approval, ProgramSettings(0, 0.5, 2.0, servo=replace(SERVO, share=0.5))
    )
    for leg, references in zip(legs_of(plan), slow.references, strict=True):
        assert 2.0 <= (len(references) - 1) * PERIOD / leg.seconds < 2.3


@pytest.mark.extensive
@pytest.mark.parametrize("servo", [SERVO, Servo(0.1, 300), Servo(0.2, 2000)])
def test_an_arm_that_follows_stays_by_the_proven_curve_however_much_it_lags(planned, servo):
    cell, plan, approval = planned
    arm, seconds = cell.arms[0], 0.0
    program = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0, servo=servo))
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    for leg, stream in zip(legs_of(plan), streams_of(program.text), strict=True):
        way = way_of(leg, velocity, np.asarray(arm.acceleration), cell.policy.zone)
        curve = np.array([way.at(s)[0] for s in np.linspace(0.0, way.s[-1], 2000)])
        followed = Following(arm.to_axes(leg.q[0]).tolist(), stream)
        for t in np.arange(0.0, followed.seconds, 0.01):
            q = np.asarray(arm.from_axes(followed.at(t)))
            assert off_the_references(q, curve).max() < FOLLOWS_WITHIN + 1e-4
        end = np.asarray(arm.from_axes(followed.at(followed.seconds)))
        assert np.abs(end - leg.q[-1]).max() < np.deg2rad(0.02), "it stands before the hand moves"
        seconds += followed.seconds
    assert seconds < 20 * sum(leg.seconds for leg in legs_of(plan))


@pytest.mark.extensive
def test_at_the_planned_pace_an_arm_that_lags_would_leave_the_curve(planned, monkeypatch):
    cell, plan, approval = planned
    lags, arm = Servo(0.2, 2000), cell.arms[0]
    monkeypatch.setattr("workbench.devices.universal_robots.servo.FOLLOWS_WITHIN", np.inf)
    hasty = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0, servo=lags))
    most = 0.0
    for stream, references in zip(streams_of(hasty.text), hasty.references, strict=True):
        followed = Following(arm.to_axes(references[0]).tolist(), stream)
        for t in np.arange(0.0, followed.seconds, 0.01):
            q = np.asarray(arm.from_axes(followed.at(t)))
            most = max(most, float(off_the_references(q, references).max()))
    assert most > np.deg2rad(2.0)
    monkeypatch.setattr("workbench.devices.universal_robots.servo.FOLLOWS_WITHIN", -1.0)
    with pytest.raises(InputError, match="the arm would leave its way by more than"):
        program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0, servo=lags))


def test_a_joint_lags_by_the_lookahead_and_comes_to_rest():
    speed = 0.8
    ramp = [[speed * PERIOD * k, 0, 0, 0, 0, 0] for k in range(1, 201)]
    followed = Following([0.0] * 6, stream_of(ramp, SERVO))
    # The reference of a period is that of its end.
    assert followed.at(1.2)[0] == pytest.approx(speed * (1.2 + PERIOD / 2 - 0.03), abs=0.004)
    assert followed.at(followed.seconds)[0] == pytest.approx(ramp[-1][0], abs=1e-3)


@pytest.mark.parametrize(
    "line",
    [
        "servoj([0, 0, 0, 0, 0, 0], t=0.008, lookahead_time=0.02, gain=300)",
        "servoj([0, 0, 0, 0, 0, 0], t=0.008, lookahead_time=0.1, gain=3000)",
        "servoj([0, 0, 0, 0, 0], t=0.008, lookahead_time=0.1, gain=300)",
        "servoj([0, 0, 0, 0, 0, nan], t=0.008, lookahead_time=0.1, gain=300)",
        "servoj([0, 0, 0, 0, 0, 0], t=0.000, lookahead_time=0.1, gain=300)",
        "servoj([0, 0, 0, 0, 0, 0], 0, 0, 0.008, 0.1, 300)",
    ],
)
def test_the_twin_refuses_streams_that_are_not_as_the_maker_says(line):
    with pytest.raises(InputError, match="line 2: 'servoj"):
        read_program(f"def a():\n  {line}\nend\n")


@pytest.mark.timeout(1800)
def test_it_keeps_the_promises_of_every_link(planned, host):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    check_robot_link(UrRtdeServo(), *planned, host=host)


def test_a_plan_is_streamed_once_and_the_arm_stays_in_what_was_proven(planned, host, tmp_path):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell, plan, approval = planned
    trace, legs = tmp_path / "trace", legs_of(plan)
    with twin_of(cell, host, speed=4.0, trace=trace) as (twin, there):
        receipts = list(send(plan, approval, there, patience=PATIENT))
        assert [one.kind for one in receipts] == ["program", *(leg.name for leg in legs), "end"]
        assert [text for text in twin.programs if "workbench_plan" in text] == [receipts[0].sent]
        assert twin.outputs == {0: False}
        with pytest.raises(LinkError, match="has begun this plan already"):
            list(send(plan, approval, there, patience=PATIENT))
    seen = [json.loads(line)["q"] for line in trace.read_text().splitlines()]
    seen = [np.asarray(cell.arms[0].from_axes(q)) for q in seen]
    ways = program_of(cell, plan, approval, ProgramSettings(0, 0.5, 2.0, servo=SERVO)).references
    off = [min(off_the_references(q, way).max() for way in ways) for q in seen]
    assert len(seen) > 30 and max(off) < FOLLOWS_WITHIN + 1e-4


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ("protective-stop@2", "reports a fault at leg . of 6: protective stop"),
        ("cut@2", "closed the link|silent|has ended|client of the controller|protocol error"),
        ("stray@2", r"does not follow in leg 2 of 6: \d\.\d deg from its reference"),
    ],
)
def test_a_doubt_stops_the_robot(planned, host, fault, says):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell, plan, approval = planned
    receipts = []
    with twin_of(cell, host, speed=1.0, faults=[fault]) as (twin, there):
        patience = replace(PATIENT, silence=10.0)
        with pytest.raises(LinkError, match=says):
            for receipt in send(plan, approval, there, patience=patience):
                receipts.append(receipt.kind)
        assert "end" not in receipts
        if "cut" not in fault:
            assert not twin.is_playing
        if "stray" in fault:
            legs = legs_of(plan)
            q = np.asarray(cell.arms[0].from_axes(twin.q))
            assert off_the_references(q, legs[1].q).max() > FOLLOWING_TOLERANCE


def test_a_client_that_stands_still_ends_the_stream_by_the_controllers_watchdog(
    planned, host, monkeypatch
):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell, plan, approval = planned
    opened = []

    class Watched(talking.Client):
        def __init__(self, *given, **more):
            super().__init__(*given, **more)
            opened.append(self._process)

    monkeypatch.setattr("workbench.devices.universal_robots.link.Client", Watched)
    with twin_of(cell, host, speed=0.2) as (twin, there):
        sending = send(plan, approval, there, patience=replace(PATIENT, silence=10.0))
        kinds = [next(sending).kind, next(sending).kind]
        os.kill(opened[0].pid, signal.SIGSTOP)
        try:
            with pytest.raises(LinkError, match=r"silent for 10\.0 s"):
                for receipt in sending:
                    kinds.append(receipt.kind)
            assert "end" not in kinds and twin.is_protective and not twin.is_playing
        finally:
            opened[0].kill()


def test_a_stop_ends_the_stream_and_is_acknowledged(planned, host):
    pytest.importorskip("rtde_receive", reason="ur-rtde is not installed")
    cell, plan, approval = planned
    taken, shown = [], []
    with twin_of(cell, host, speed=0.2) as (twin, there):
        sending = send(
            plan,
            approval,
            there,
            cancelled=lambda: len(taken) > 1,
            show=shown.append,
            patience=PATIENT,
        )
        with pytest.raises(JobCancelled, match="reported that it stands after"):
            for receipt in sending:
                taken.append(receipt)
        assert not twin.is_playing and shown[-1].phase == "stopped"
