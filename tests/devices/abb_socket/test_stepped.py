"""A plan sent step by step, and slower: over TCP, on the simulated controller."""

import json
import threading
from dataclasses import replace

import numpy as np
import pytest
from patient import PATIENT, Hurried, send
from waiting import wait_until

from workbench.app.picking.pipeline import plan_pick
from workbench.devices.abb_simulated.loading import Loading
from workbench.devices.abb_simulated.serving import Serving
from workbench.devices.abb_socket.frames import make_frame
from workbench.devices.abb_socket.program import lines_of, program_of
from workbench.model.errors import (
    CommandRefused,
    InputError,
    JobCancelled,
    LinkError,
    ProtocolError,
)
from workbench.plugins.misfit import misfit


@pytest.fixture
def stepped(approval):
    return replace(approval, is_stepped=True)


@pytest.fixture(scope="module")
def both(cell, plan):
    return plan_pick(cell, plan.detections, "scan", strategy="coordinated", seed=0).plan


class Person:
    """Lets one step run after the other; `presses` (at which the robot waited, what was let)."""

    def __init__(self, one, target, plan, approval, **how):
        self.let, self.waits, self.receipts, self.error = 0, 0, [], None
        self._cancel = threading.Event()
        self._said = send(
            plan, approval, target, let=lambda: self.let, cancelled=self._cancel.is_set, **how
        )
        self.one = one
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self):
        try:
            for receipt in self._said:
                self.receipts.append(receipt)
                self.waits = receipt.waits or self.waits
        except (CommandRefused, LinkError, JobCancelled) as error:
            self.error = error

    def stop(self):
        self._cancel.set()

    def sent(self, word):
        return [one.sent.split()[-1] for one in self.receipts if one.kind == word]


def joined(person):
    person.thread.join(PATIENT.silence)
    assert not person.thread.is_alive()
    return person


@pytest.mark.parametrize("which", ["plan", "both"])
def test_each_step_waits_for_its_word(request, controller, cell, at, stepped, tmp_path, which):
    plan = request.getfixturevalue(which)
    one = controller(trace=tmp_path / "trace.jsonl")
    target = at(one.port, protocol="abb-socket/2")
    approval = replace(stepped, plan_digest=plan.digest)
    person = Person(one, target, plan, approval)
    for number in range(1, len(plan.sequence) + 1):
        wait_until(lambda: person.waits == number)  # noqa: B023
        where = one.state()
        # A word for another step lets nothing run: an older one, one that is not yet there.
        for wrong in (number - 1, number + 1):
            person.let = wrong
            reports = len(person.receipts)
            wait_until(lambda: one.state() == where)  # noqa: B023
            assert len(person.receipts) == reports
        assert where["moving"] == "" and one.state() == where
        person.let = number
    joined(person)
    assert person.error is None
    assert person.receipts[-1].heard.split()[1:] == ["done", f"{len(plan.sequence):02d}"]
    numbers = [f"{number:02d}" for number in range(1, len(plan.sequence) + 1)]
    assert person.sent("next") == numbers
    assert [one.waits for one in person.receipts if one.waits] == [int(n) for n in numbers]
    states = [json.loads(line) for line in (tmp_path / "trace.jsonl").read_text().splitlines()]
    assert sorted({state["step"] for state in states}) == list(range(1, len(numbers) + 1))
    assert all(receipt.done <= receipt.total for receipt in person.receipts)


def test_a_stop_while_a_step_waits_is_acknowledged(controller, at, plan, stepped):
    one = controller()
    person = Person(one, at(one.port, protocol="abb-socket/2"), plan, stepped)
    wait_until(lambda: person.waits == 1)
    person.stop()
    joined(person)
    assert "acknowledged the stop" in str(person.error)
    assert person.sent("next") == [] and one.state()["fault"] == "stopped by the client"


def test_a_link_that_ends_while_a_step_waits_names_that_step(controller, at, plan, stepped):
    one = controller()
    person = Person(one, at(one.port, protocol="abb-socket/2"), plan, stepped)
    for number in (1, 2, 3):
        wait_until(lambda: person.waits == number)  # noqa: B023
        person.let = number if number < 3 else 2
    one.stop()
    joined(person)
    assert f"at step 3 of {len(plan.sequence)}, which had not begun" in str(person.error)


def test_silence_while_a_step_waits_is_a_fault(controller, at, plan, stepped):
    clock = Hurried()
    one = controller(patience=replace(PATIENT, clock=clock))
    person = Person(one, at(one.port, protocol="abb-socket/2"), plan, stepped)
    wait_until(lambda: person.waits == 1)
    clock.let_pass(PATIENT.silence + 1)
    joined(person)
    assert "the client was silent" in str(person.error)


def test_a_controller_that_falls_silent_while_a_step_waits(controller, at, plan, stepped):
    clock, one = Hurried(), controller()
    patience = replace(PATIENT, clock=clock)
    person = Person(one, at(one.port, protocol="abb-socket/2"), plan, stepped, patience=patience)
    wait_until(lambda: person.waits == 1)
    one.stop()
    joined(person)
    assert "closed the link" in str(person.error)


def test_a_fault_in_a_step_that_was_let_run(controller, at, plan, stepped):
    one = controller(faults=["emergency-stop:2"])
    person = Person(one, at(one.port, protocol="abb-socket/2"), plan, stepped)
    for number in (1, 2):
        wait_until(lambda: person.waits == number)  # noqa: B023
        person.let = number
    joined(person)
    assert "emergency stop" in str(person.error) and person.sent("next") == ["01", "02"]


def test_what_is_sent_in_one_go_is_as_ever_on_the_wire(cell, plan, approval, stepped):
    """A controller that knows only the older words gets them; one that waits a fourth word."""
    plain, waiting = (
        [(line.word, line.rest) for line in lines_of(cell, program_of(cell, plan, one))]
        for one in (approval, stepped)
    )
    assert plain[1] == ("ticket", f"{approval.digest[:16]} 012 {plain[1][1][-3:]}")
    assert waiting[1] == ("ticket", f"{stepped.digest[:16]} 012 {plain[1][1][-3:]} stepped")
    assert plain[2:] == waiting[2:] and plain[0] == waiting[0]


class Older(Serving):
    """A controller from before there were steps."""

    def _answer(self, frame):
        if frame.word == "ticket" and len(frame.words) != 3:
            raise ProtocolError("no ticket, or a second one")
        return super()._answer(frame)


def test_an_older_controller_refuses_a_stepped_plan_and_moves_nothing(
    controller, at, plan, stepped, monkeypatch
):
    monkeypatch.setattr("workbench.devices.abb_simulated.serve_program.Serving", Older)
    one = controller()
    person = joined(Person(one, at(one.port, protocol="abb-socket/2"), plan, stepped))
    assert "refuses" in str(person.error) and "cannot wait before steps" in str(person.error)
    assert not any(one.kind == "run" for one in person.receipts)


@pytest.mark.parametrize("share", [0.5, 0.25, 0.1, 0.05])
def test_a_share_of_the_speed_makes_all_times_longer(cell, plan, approval, share):
    slow = program_of(cell, plan, replace(approval, speed_share=share))
    usual = program_of(cell, plan, approval)
    for one, other in zip(slow.legs, usual.legs, strict=True):
        np.testing.assert_array_equal(one.q, other.q)
        # Both are whole milliseconds.
        np.testing.assert_allclose(one.seconds, other.seconds / share, atol=0.001 + 0.001 / share)
        assert np.all(one.seconds >= other.seconds)
        assert (one.zone, one.hand, one.opening) == (other.zone, other.hand, other.opening)
    for one in slow.legs:
        leg = plan.arm(one.arm).leg(one.name)
        late = one.seconds - np.diff(leg.t) / share
        assert late.min() >= -1e-9 and np.median(late) < 0.001


@pytest.mark.parametrize("share", [1.0, 0.3])
def test_no_way_is_asked_for_faster_than_planned_or_than_the_cell_allows(
    cell, both, approval, share
):
    """A controller that is told a time goes at the speed that the way between waypoints needs."""
    fine = replace(both, arms=tuple(finer(one) for one in both.arms))
    for plan in (both, fine):
        program = program_of(cell, plan, replace(approval, speed_share=share))
        for one in program.legs:
            speeds = cell.robot.limits(cell.arm(one.arm).joints)[2] * cell.policy.speed * share
            asked = np.abs(np.diff(one.q, axis=0)) / one.seconds[:, None]
            assert (asked / speeds).max() <= 1.0 + 1e-6
            assert (one.seconds >= np.diff(plan.arm(one.arm).leg(one.name).t) / share - 1e-9).all()
            assert np.allclose(one.seconds * 1000, np.round(one.seconds * 1000))


def finer(one):
    """An arm's plan with five waypoints more on each way: what milliseconds round is more there."""

    def with_more(leg):
        at = np.linspace(0, len(leg.t) - 1, 6 * (len(leg.t) - 1) + 1)
        values = [np.interp(at, np.arange(len(leg.t)), column) for column in (leg.t, *leg.q.T)]
        return replace(leg, t=values[0], q=np.stack(values[1:], axis=1))

    return replace(one, legs=tuple(map(with_more, one.legs)))


def test_a_slow_plan_comes_to_its_end_the_same_way(controller, at, plan, approval, tmp_path):
    ways = []
    for share in (1.0, 0.25):
        trace = tmp_path / f"{share}.jsonl"
        one = controller(trace=trace)
        target = at(one.port, protocol="abb-socket/2")
        list(send(plan, replace(approval, speed_share=share), target))
        states = [json.loads(line) for line in trace.read_text().splitlines()]
        ways.append((states[-1]["time"], np.array([state["q"]["right"] for state in states])))
    (quick, usual), (slow, slowly) = ways
    moving = sum(float(leg.t[-1]) for arm in plan.arms for leg in arm.legs)
    assert slow - quick == pytest.approx(3 * moving, rel=0.01)
    apart = np.abs(slowly[::5, None] - usual[None]).max(axis=2).min(axis=1)
    assert apart.max() <= np.abs(np.diff(usual, axis=0)).max()


def test_no_approval_is_faster_than_the_plan(approval):
    for share in (1.01, 0.049, 0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="a plan is sent at"):
            replace(approval, speed_share=share)


def test_what_a_link_cannot_do_is_refused_in_one_sentence(plan, cell, at, approval, stepped):
    older, newer = at(1, protocol="abb-socket"), at(1, protocol="abb-socket/2")
    for manner, words in [
        ((0.5, False), "the robot link abb-socket cannot send a plan at a share of its speed"),
        ((1.0, True), "the robot link abb-socket cannot send a plan step by step"),
    ]:
        assert str(misfit(plan, older, manner)) == words
        assert misfit(plan, newer, manner) is None
    legs = (replace(plan.arms[0].legs[0], t=plan.arms[0].legs[0].t * 50), *plan.arms[0].legs[1:])
    slow = replace(plan, arms=(replace(plan.arms[0], legs=legs), *plan.arms[1:]))
    assert misfit(slow, newer) is None
    assert "the robot link abb-socket/2 allows 100.0 s" in str(misfit(slow, newer, (0.05, False)))
    with pytest.raises(CommandRefused, match="step by step"):
        list(send(plan, stepped, older))


def test_the_simulated_controller_takes_one_manner(cell):
    for words in ("slowly", "stepped now"):
        loading, serving = Loading(cell), Serving(cell, lambda: {}, [])
        del loading
        list(serving.hear(make_frame(1, "hello abb-socket/2")))
        list(serving.hear(make_frame(2, f"plan {'a' * 64}")))
        with pytest.raises(ProtocolError):
            list(serving.hear(make_frame(3, f"ticket {'b' * 16} 001 001 {words}")))
