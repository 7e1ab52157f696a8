"""A controller whose reports by EGM cannot be, over UDP: the motion ends, and says why."""

import socket
import threading
import time
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from egm_scenes import PATIENT, twin_of
from relays import between_datagrams
from waiting import wait_until

from workbench.devices.abb_egm import wire
from workbench.devices.abb_egm.twin import free_ports
from workbench.model.errors import JobCancelled, LinkError
from workbench.plugins.robot_link import send, states

pytest.importorskip(
    "google.protobuf", reason="protobuf is not installed: pip install 'workbench[egm]'"
)


@contextmanager
def spoilt_twin(cell, spoil, speed=100.0, ports="port", **given):
    """The twin, and the cell with its controller behind somebody who changes reports.

    `spoil(twin, k, told)` gives the reports, or bytes, that come in place of one of arm `k`.
    """
    with twin_of(cell, speed=speed, **given) as (twin, there):
        here = free_ports("127.0.0.1", len(cell.arms))

        def changed(k, data):
            told = wire.read_feedback(data, len(cell.arms[k].joints))
            made = spoil(twin, k, told)
            return [one if isinstance(one, bytes) else wire.feedback_bytes(one) for one in made]

        at = getattr(there.controller, ports)
        with between_datagrams(at, here, len(cell.arms), changed):
            yield twin, replace(there, controller=replace(there.controller, **{ports: here}))


def with_axis(told, degrees):
    axes = np.array(told.axes)
    axes[2] = np.deg2rad(degrees)
    return replace(told, axes=axes)


class InLeg:
    """Spoils reports of the arm that moves: the `into`-th after a leg began, or from there on.

    `how(told)` gives what comes in place of it.  `held`: it comes with the next one, at once.
    """

    def __init__(self, how, leg=1, into=20, held=False, on=False):
        self._how, self._leg, self._into, self._held, self._on = how, leg, into, held, on
        self._back, self.count = [], 0

    def __call__(self, twin, k, told):
        if twin.arms[k].leg < self._leg:
            return [told]
        self.count += 1
        made = [told]
        if self.count == self._into or (self._on and self.count > self._into):
            made = self._how(told)
        if self.count == self._into and self._held:
            self._back = list(made)
            return []
        made, self._back = [*self._back, *made], []
        return made


SLOW = replace(PATIENT, clock=lambda: time.monotonic() / 60, stop=0.05)
"""A busy machine is silent, too: here a second lasts a minute."""

IMPOSSIBLE = [1e308, -1e308, 1e306, 500.0, -600.0]
"""[deg] Of an axis that goes from -123.5 to 80 degrees."""


def fault_of(cell, plan, approval, spoil, says, **given):
    """Send a plan while reports are spoilt; it ends by a fault, no leg was told to be done."""
    kinds = []
    with spoilt_twin(cell, spoil, **given) as (_, there), pytest.raises(LinkError, match=says):
        for receipt in send(plan, approval, there, patience=SLOW):
            kinds.append(receipt.kind)
    assert set(kinds) <= {"order"}


@pytest.mark.parametrize("degrees", IMPOSSIBLE)
@pytest.mark.parametrize("held", [False, True], ids=["alone", "with a good one behind it"])
def test_a_joint_that_is_reported_where_it_cannot_be_ends_the_motion(planned, degrees, held):
    spoil = InLeg(lambda told: [with_axis(told, degrees)], held=held)
    fault_of(*planned, spoil, r"reports \S+ at \S+ degrees; it goes from")


def test_motors_that_were_off_between_two_good_reports_end_the_motion(planned):
    spoil = InLeg(lambda told: [replace(told, motors=wire.MOTORS_OFF)], held=True)
    fault_of(*planned, spoil, r"at leg 1 of \d+: left: the motors are off")


def telling(**changes):
    """Reports in which the module in RAPID tells something else than it does."""

    def how(told):
        words = dict(zip(("version", "ticket", "done"), told.rapid_values, strict=False))
        made = {name: changes.get(name, float)(value) for name, value in words.items()}
        return [replace(told, rapid_values=tuple(made.values()))]

    return how


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"ticket": lambda v: v + 1}, "has begun another plan"),
        ({"ticket": lambda v: 1e308}, "has begun another plan"),
        ({"version": lambda v: 2.0}, "does not answer"),
        ({"done": lambda v: v + 1}, "reports order 3, where 2 was done and 2 was given"),
        ({"done": lambda v: v - 1}, "reports order 1, where 2"),
        ({"done": lambda v: v + 0.5}, r"reports order 2\.5, where 2"),
        ({"done": lambda v: -v}, "reports order -2, where 2"),
        ({"done": lambda v: 1e308}, r"reports order 1e\+308, where 2"),
    ],
)
def test_a_module_that_tells_of_what_was_not_ordered_ends_the_motion(planned, changes, says):
    fault_of(*planned, InLeg(telling(**changes), held=True), says)


def test_an_order_that_is_told_to_be_done_before_it_was_given_is_not_taken_for_done(planned):
    begun = set()

    def ahead(twin, k, told):
        made = telling(done=lambda v: v + 1)(told) if len(begun) == len(twin.arms) else [told]
        begun.update({k} if told.rapid_values[2] == 1.0 else ())
        return made

    fault_of(*planned, ahead, "reports order 2, where 1 was done and 1 was given")


def test_an_arm_that_moves_while_the_other_one_is_to_ends_the_motion(planned):
    def moves(twin, k, told):
        others = [one for one in twin.arms if one is not twin.arms[k]]
        return [with_axis(told, np.rad2deg(told.axes[2]) + 5.0 * (others[0].leg > 0))]

    fault_of(*planned, moves, r"does not follow in leg 1 of 12: 5\.0 deg")


@pytest.mark.parametrize(
    ("how", "says"),
    [
        (lambda told: [wire.feedback_bytes(told)[:-7]], "reports|that is no EgmRobot"),
        (lambda told: [b""], "without header or joints"),
        (lambda told: [b"\xff" * 60_000], "that is no EgmRobot"),
        (lambda told: [b"send"], "that is no EgmRobot"),
        (lambda told: [replace(told, axes=told.axes[:6])], "reports 6 axes, 7 are expected"),
        (lambda told: [replace(told, axes=told.axes * np.nan)], "that are no numbers"),
        (lambda told: [replace(told, axes=told.axes + np.inf)], "that are no numbers"),
        (lambda told: [told, told], "twice, or out of order"),
        (lambda told: [replace(told, number=told.number - 2)], "twice, or out of order"),
        (lambda told: [replace(told, number=0xFFFFFFFF)], "twice, or out of order"),
        (lambda told: [replace(told, number=told.number + 10_000)], "EGM has to run at 4 ms"),
        (lambda told: [replace(told, at=told.at - 400)], "EGM has to run at 4 ms"),
        (lambda told: [replace(told, at=0xFFFFFFFF)], "EGM has to run at 4 ms"),
    ],
)
def test_a_report_that_is_none_or_not_the_next_ends_the_motion(planned, how, says):
    fault_of(*planned, InLeg(how), says)


def test_a_second_program_that_reports_ends_the_motion(planned):
    cell, plan, approval = planned
    with spoilt_twin(cell, lambda twin, k, told: [told]) as (_, there):
        sending = send(plan, approval, there, patience=SLOW)
        assert next(sending).kind == "order"
        good = wire.Feedback(9, 9, cell.arms[0].to_axes(cell.arms[0].home), 1, 3, 2, True, ())
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
            other.sendto(wire.feedback_bytes(good), ("127.0.0.1", there.controller.port))
            with pytest.raises(LinkError, match="two programs report"):
                list(sending)


def test_what_comes_from_another_machine_is_not_looked_at(planned):
    cell, plan, approval = planned
    receipts = []
    with (
        spoilt_twin(cell, lambda twin, k, told: [told]) as (_, there),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        other.bind(("127.0.0.2", 0))
        for receipt in send(plan, approval, there, patience=SLOW):
            receipts.append(receipt)
            for _ in range(20):
                other.sendto(b"\xff" * 100, ("127.0.0.1", there.controller.port))
    assert receipts[-1].done == receipts[-1].total


def test_a_link_that_is_cut_and_comes_back_goes_on_with_nothing(planned):
    cell, plan, approval = planned
    is_cut = threading.Event()
    answers = []

    def until_cut(twin, k, told):
        if twin.arms[k].leg == 2:
            is_cut.set()
        return [] if is_cut.is_set() and not answers else [told]

    with spoilt_twin(cell, until_cut, home_after=0.5) as (twin, there):
        with pytest.raises(LinkError, match=r"silent for 1\.0 s"):
            list(send(plan, approval, there, patience=PATIENT))
        answers.append("back")
        wait_until(lambda: all(arm.mci == wire.MCI_RUNNING for arm in twin.arms))
        orders = [list(arm.orders) for arm in twin.arms]
        with pytest.raises(LinkError, match="has begun this plan already"):
            list(send(plan, approval, there, patience=SLOW))
        assert [list(arm.orders) for arm in twin.arms] == orders


PHASES = {
    "before anything": lambda twin: True,
    "while it begins": lambda twin: any(arm.is_attached for arm in twin.arms),
    "while a hand moves": lambda twin: any(arm._busy > 2 for arm in twin.arms),
    "in a leg": lambda twin: any(arm.leg == 3 for arm in twin.arms),
    "while the other arm ends": lambda twin: any(
        arm.orders and arm._has_ended for arm in twin.arms
    ),
}


@pytest.mark.parametrize("phase", PHASES)
def test_a_stop_in_each_phase_leaves_arms_that_stand_and_are_told_nothing_more(planned, phase):
    cell, plan, approval = planned
    times = []
    with twin_of(cell) as (twin, there):

        def cancelled():
            times.append(PHASES[phase](twin))
            return times[-1]

        says = "stopped before anything of this plan" if phase == "before anything" else "it stands"
        with pytest.raises(JobCancelled, match=says):
            list(send(plan, approval, there, cancelled=cancelled, patience=SLOW))
        assert times.count(True) == 1, "asked no more once it was to stop"
        orders = [list(arm.orders) for arm in twin.arms]
        assert any(orders) == (phase != "before anything")
        where = [arm.axes for arm in twin.arms]
        wait_until(lambda: not any(arm.is_attached for arm in twin.arms), "answers to end")
        assert [list(arm.orders) for arm in twin.arms] == orders
        assert all(arm.mci == wire.MCI_RUNNING for arm in twin.arms), "EGM was told to end"
        for before, arm in zip(where, twin.arms, strict=True):
            assert np.abs(arm.axes - before).max() < np.deg2rad(0.1)


def test_a_plan_that_was_begun_before_others_is_not_begun_again(planned):
    cell, plan, approval = planned
    later = [replace(approval, at=approval.at - k) for k in (1, 2)]
    with twin_of(cell) as (twin, there):
        for one in (approval, later[0]):
            sending = send(plan, one, there, patience=SLOW)
            next(sending)
            sending.close()
            wait_until(lambda: not any(arm.is_attached for arm in twin.arms))
        orders = [list(arm.orders) for arm in twin.arms]
        with pytest.raises(LinkError, match="has begun this plan already; nothing runs twice"):
            list(send(plan, approval, there, patience=SLOW))
        assert [list(arm.orders) for arm in twin.arms] == orders
        list(send(plan, later[1], there, patience=SLOW))


@pytest.mark.parametrize("degrees", IMPOSSIBLE)
def test_a_state_that_cannot_be_is_not_reported(planned, degrees):
    cell, _, _ = planned
    count = []

    def spoil(twin, k, told):
        count.append(k)
        if len(count) <= 20:
            return [told]
        return [with_axis(told, degrees if len(count) % 4 == 0 else -degrees)]

    with spoilt_twin(cell, spoil, speed=20.0, ports="state_port") as (_, there):
        reports = states(there)
        next(reports)
        with pytest.raises(LinkError, match=r"reports \S+ at \S+ degrees; it goes from"):
            for _ in reports:
                pass
