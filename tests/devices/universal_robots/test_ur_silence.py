"""What counts as silence of a controller of Universal Robots, with clients that are not there."""

import time
from dataclasses import replace

import pytest

import workbench
from workbench.devices.universal_robots import link as ur_link
from workbench.devices.universal_robots.link import UrRtde
from workbench.devices.universal_robots.program import ProgramSettings, program_of
from workbench.devices.universal_robots.rtde import PLAYING, RTDE_PORT, STOPPED
from workbench.devices.universal_robots.sending import RtdeSending
from workbench.model.errors import JobCancelled, LinkError
from workbench.plugins.robot_link import USUAL, controller_by


@pytest.fixture(scope="module")
def cell():
    made = workbench.read_cell("tx2_90")
    return replace(made, controller=controller_by("ur-rtde", "127.0.0.1", 30002, RTDE_PORT))


class Repeating:
    """A client that tells the last state again and again, as the library does without a cable."""

    def __init__(self, *asked, **more):
        self.told = {"at": 7.0, "q": [0.0] * 6, "runtime": 1, "mode": 7, "safety": 1, "leg": 0}

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def hear(self, _):
        return self.told


def test_a_state_that_is_no_news_is_no_report(cell, monkeypatch):
    monkeypatch.setattr(ur_link, "Client", Repeating)
    monkeypatch.setattr(ur_link, "USUAL", replace(USUAL, silence=0.1))
    states = UrRtde().states(cell, lambda: False)
    next(states)
    with pytest.raises(LinkError, match="has reported nothing new"):
        next(states)


class Late(Repeating):
    """A client that connects for longer than a controller may be silent."""

    def __init__(self, *asked, **more):
        super().__init__()
        self.left = 10

    def hear(self, _):
        time.sleep(0.02)
        self.left -= 1
        return None if self.left > 0 else self.told


def test_a_client_that_connects_slowly_is_no_silent_controller(cell, monkeypatch):
    monkeypatch.setattr(ur_link, "Client", Late)
    monkeypatch.setattr(ur_link, "USUAL", replace(USUAL, silence=0.05))
    assert next(UrRtde().states(cell, lambda: False)).moving == ""


class Slow:
    """A client that needs 5 s to connect, and then hears nothing new for a moment."""

    def __init__(self, program, to_axes):
        self.seconds, self.said, self.looks = 0.0, [], 0
        there = {"runtime": STOPPED, "mode": 7, "safety": 1}
        begin = {"at": 1.0, "q": to_axes(program.q_start), "leg": program.ticket - 1}
        end = {"at": 60.0, "q": to_axes(program.q_end), "leg": program.ticket + len(program.legs)}
        self.begin, self.end = begin | there, end | there | {"leg": end["leg"] + 1}

    def clock(self):
        return self.seconds

    def say(self, **asked):
        self.said.append(asked)

    def hear(self, seconds):
        self.seconds += seconds
        if self.seconds < 5.0:
            return None
        self.looks += 1
        return {1: self.begin, 2: None}.get(self.looks, self.end)


class Stopped(Slow):
    """A client whose controller takes a stop, and then tells `states`, one at each question."""

    def __init__(self, program, to_axes, *states):
        super().__init__(program, to_axes)
        self.states, self.is_stopped = list(states), False

    def say(self, **asked):
        super().say(**asked)
        self.is_stopped = self.is_stopped or "stop" in asked

    def hear(self, seconds):
        self.seconds += seconds
        if not self.is_stopped:
            return self.begin
        if {"stopping": True} not in self.said:
            self.said.append({"stopping": True})
            return {"stopping": True}
        return self.begin | self.states.pop(0) if self.states else None


@pytest.fixture(scope="module")
def program(cell):
    parts = workbench.drop_parts(cell.parts[:1], cell.bin, seed=5)
    result = workbench.plan(cell, parts)
    approval = workbench.approve(cell, result.plan, result.proof, "tester")
    return program_of(cell, result.plan, approval, ProgramSettings(0, 0.5, USUAL.silence))


def talking(cell, program, client):
    return RtdeSending(
        client,
        cell,
        program,
        now=time.time,
        show=lambda status: None,
        patience=replace(USUAL, clock=client.clock),
    )


STANDS, RUNS, MOVED = {"runtime": STOPPED}, {"runtime": PLAYING}, {"q": [0.5] * 6}


@pytest.mark.parametrize(
    "states",
    [
        [STANDS, STANDS, STANDS],
        [{"at": 2.0} | STANDS],
        [{"at": 2.0} | STANDS, {"at": 2.0} | STANDS],
        [{"at": 2.0} | STANDS, {"at": 3.0} | RUNS, {"at": 4.0} | STANDS, {"at": 4.0} | STANDS],
        [{"at": 2.0} | STANDS, {"at": 3.0} | STANDS | MOVED],
        [{"at": 2.0} | STANDS, {"at": float("nan")} | STANDS],
    ],
)
def test_a_stop_is_not_believed_by_what_was_on_its_way_or_by_a_robot_that_moves(
    cell, program, states
):
    client = Stopped(program, cell.arms[0].to_axes, *states)
    receipts = []
    with pytest.raises(JobCancelled, match="did not report that it stands: use the emergency stop"):
        for receipt in talking(cell, program, client).run(lambda: None, lambda: bool(receipts)):
            receipts.append(receipt)


def test_how_long_it_takes_to_connect_ends_no_motion(cell, program):
    client = Slow(program, cell.arms[0].to_axes)
    receipts = list(talking(cell, program, client).run(lambda: None, lambda: False))
    assert receipts[-1].kind == "end"
    assert {"stop": True} not in client.said
