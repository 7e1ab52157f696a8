"""What is said of a robot after a sending, and that each sending has an end, whatever happens."""

import dataclasses
import threading
import time
from types import SimpleNamespace

import pytest
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.runtime import robot_link
from workbench.app.runtime.robot_link import LinkRunner
from workbench.model.errors import JobCancelled, LinkError, ProtocolError
from workbench.model.release import LinkStatus, Receipt, RobotState
from workbench.plugins.robot_link import USUAL

APPROVAL = SimpleNamespace(digest="0" * 64, first="")


class Rig:
    """A runner over a link made of two functions, and what it shows and tells."""

    def __init__(self, monkeypatch, cell, plan, send, states, report) -> None:
        self.shown, self.told, self.plan = {}, [], plan
        self.connections = 0
        self._tell = states
        monkeypatch.setattr(robot_link, "send", send)
        monkeypatch.setattr(robot_link, "states", self._states)
        patience = dataclasses.replace(USUAL, report=report)
        self.link = LinkRunner(cell, self._do, time.time, self._show, patience=patience)

    def _states(self, cell, cancelled):
        self.connections += 1
        return self._tell(self.connections, cancelled)

    def _show(self, **changes):
        self.shown.update(changes)

    def _do(self, command, actor):
        # As the record of a session would.
        if isinstance(command, LinkEnded):
            str(command.fault).encode()
        self.told.append(command)

    def ended(self):
        wait_until(lambda: any(isinstance(one, LinkEnded) for one in self.told))
        wait_until(lambda: self.shown["link"].phase == "closed")
        return self.told[-1]


@pytest.fixture
def rig(monkeypatch, cell, samples):
    made = []

    def make(send, states, report=PATIENCE):
        plan = samples.plan("0" * 64)
        made.append(Rig(monkeypatch, cell, plan, send, states, report))
        return made[-1]

    yield make
    for one in made:
        one.link.close()


def state(moving="", received=0):
    return RobotState({"right": (0.0,)}, {}, moving, received, 0, "")


def no_reports(connection, cancelled):
    raise LinkError("nobody reports")


def stopped_after_a_message(plan, approval, cell, *, cancelled, **_):
    yield Receipt(0.0, "right", "in", "a message", 1, 2)
    while not cancelled():
        time.sleep(0.01)
    raise JobCancelled("sending was stopped before message 2 of 2")


def stopped(rig, *later, **patience):
    """The link after a stop, where the connections for reports after the first tell `later`."""

    def states(connection, cancelled):
        if connection == 1:
            yield state()
        elif connection - 2 < len(later):
            yield later[connection - 2]
        else:
            raise LinkError("nobody answers")
        while not cancelled():
            time.sleep(0.01)

    one = rig(stopped_after_a_message, states, **patience)
    wait_until(lambda: str(one.shown.get("robot")) == "stands")
    one.link.send(one.plan, APPROVAL)
    wait_until(lambda: one.told)
    one.link.stop()
    assert "sending was stopped" in str(one.ended().fault)
    return one.shown["link"]


def test_a_report_from_before_a_stop_does_not_say_that_the_robot_stands(rig):
    link = stopped(rig)
    assert str(link.stop) == "nobody has reported that the robot stands: use the emergency stop"
    assert link.stopped is None


def test_after_a_stop_the_controller_is_asked_anew(rig):
    link = stopped(rig, state(received=1))
    assert str(link.stop).startswith("the robot was reported to stand after")
    assert link.stopped is not None


@pytest.mark.parametrize("told", [state("right", received=1), state(received=0)])
def test_a_robot_that_moves_or_is_about_to_does_not_stand(rig, told):
    assert "use the emergency stop" in str(stopped(rig, told, report=0.2).stop)


def test_what_the_link_itself_says_of_a_stop_is_not_asked_again(rig):
    def send(plan, approval, cell, *, cancelled, show, **_):
        yield Receipt(0.0, "right", "program", "a program", 0, 2)
        while not cancelled():
            time.sleep(0.01)
        show(LinkStatus("acme", "stopped", stopped=0.1, stop="it stands after 100 ms"))
        raise JobCancelled("sending was stopped; it stands after 100 ms")

    one = rig(send, no_reports)
    one.link.send(one.plan, APPROVAL)
    wait_until(lambda: one.told)
    one.link.stop()
    one.ended()
    assert one.shown["link"].stop == "it stands after 100 ms"


def test_joints_told_before_a_stop_are_not_shown_after_it(rig):
    def send(plan, approval, cell, *, cancelled, show, **_):
        show(LinkStatus("acme", "running", 1, 2, joints={"right": (0.5,)}))
        yield Receipt(0.0, "right", "program", "a program", 0, 2)
        while not cancelled():
            time.sleep(0.01)
        show(LinkStatus("acme", "stopped", 1, 2))
        raise JobCancelled("sending was stopped")

    one = rig(send, no_reports)
    one.link.send(one.plan, APPROVAL)
    wait_until(lambda: one.told)
    assert one.shown["joints"] == {"joint_1": 0.5}
    one.link.stop()
    one.ended()
    assert one.shown["joints"] == {} and not one.shown["robot"]


def test_a_robot_of_which_nonsense_is_reported_goes_on_with_no_plan(rig):
    begun = threading.Event()

    def send(plan, approval, cell, *, cancelled, **_):
        yield Receipt(0.0, "right", "program", "a program", 0, 2)
        begun.set()
        while not cancelled():
            time.sleep(0.01)
        raise JobCancelled("the controller reported that it stands")

    def states(connection, cancelled):
        yield state()
        while not begun.is_set() and not cancelled():
            time.sleep(0.01)
        raise ProtocolError("the controller reports joint_1 at 1e+308 degrees")

    one = rig(send, states)
    one.link.send(one.plan, APPROVAL)
    says = (
        "protocol error: the controller reports joint_1 at 1e+308 degrees; "
        "the controller reported that it"
    )
    assert str(one.ended().fault).startswith(says)


def test_a_fault_that_no_journal_can_hold_is_an_end_all_the_same(rig):
    def send(*arguments, **_):
        yield Receipt(0.0, "right", "in", "a message", 1, 2)
        raise LinkError("the controller says \ud800")

    one = rig(send, no_reports)
    one.link.send(one.plan, APPROVAL)
    assert "the controller says" in str(one.ended().fault)


def test_no_further_plan_goes_out_where_the_end_of_one_could_not_be_told(rig):
    begun = []

    def sends(plan, approval, cell, **_):
        begun.append(approval.digest)
        yield Receipt(0.0, "right", "in", "a message", 1, 1)

    one = rig(sends, no_reports)
    onward = SimpleNamespace(digest="1" * 64, first=APPROVAL.digest)
    tell = one._do

    def fails_once(command, actor):
        is_first = isinstance(command, LinkEnded) and not any(
            isinstance(each, LinkEnded) for each in one.told
        )
        tell(command, actor)
        if is_first:
            one.link.send(one.plan, onward)
            raise RuntimeError("an effect fails")

    one.link._do = fails_once
    one.link.send(one.plan, APPROVAL)
    wait_until(lambda: sum(isinstance(each, LinkEnded) for each in one.told) == 3)
    assert begun == [APPROVAL.digest]


def test_a_sending_needs_no_thread_that_may_not_be_had(rig, monkeypatch):
    def send(*arguments, **_):
        yield Receipt(0.0, "right", "in", "a message", 1, 1)

    def no_more(thread):
        raise RuntimeError("can't start new thread")

    one = rig(send, no_reports)
    with monkeypatch.context() as short:
        short.setattr(threading.Thread, "start", no_more)
        one.link.send(one.plan, APPROVAL)
        assert one.ended().fault == ""
