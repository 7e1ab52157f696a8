"""What stands above the tabs: a bar that is full only when all is done."""

from dataclasses import replace

import pytest

from workbench.app.core.state import Phase
from workbench.gui.page.header import Header
from workbench.gui.page.theme import Theme
from workbench.gui.shared.visitor import Visitor
from workbench.model.release import Receipt
from workbench.plugins.robot_link import spoken_to_by


@pytest.fixture
def header(visitor, monkeypatch):
    for name in ("on_key", "on_end"):
        monkeypatch.setattr(Visitor, name, lambda *_, **__: None)
    return Header(visitor, Theme(is_framed=True), "")


def heard(step, done=76, total=76):
    return Receipt(0.0, "", "heard", "", done, total, f"running {step:02d}", step=step)


@pytest.fixture
def bar(header, view_of):
    """Of a state: how full the bar is, and in which colour."""
    before = [None]

    def shown(state):
        view = view_of(state)
        header.show(before[0], view)
        before[0] = view
        return header._progress.value, header._progress.color

    return shown


def test_the_bar_goes_by_the_steps_that_the_robot_has_reported(states, bar):
    sending = states.sending
    steps = len(sending.plan.sequence)
    sent = (Receipt(0.0, "right", "in", "...", 76, 76),)
    assert bar(replace(sending, receipts=sent)) == (0.0, None)
    for step in (1, 3, steps):
        told = replace(sending, receipts=(*sent, heard(step)))
        assert bar(told)[0] == pytest.approx(100 * (step - 1) / steps, abs=0.1)
    ended = replace(sending, receipts=(*sent, heard(steps)), phase=Phase.DONE)
    assert bar(ended) == (100.0, None)


def test_a_robot_that_waits_before_a_step_has_done_those_before_it(states, bar):
    steps = len(states.sending.plan.sequence)
    waits = replace(heard(0), waits=4)
    told = replace(states.sending, receipts=(heard(3), waits), waits=4, let=3)
    assert bar(told)[0] == pytest.approx(100 * 3 / steps, abs=0.1)


def test_after_a_stop_the_bar_stays_where_it_was_and_is_grey(states, bar):
    steps = len(states.sending.plan.sequence)
    stopped = replace(states.fault, receipts=(heard(3),))
    assert bar(stopped) == (pytest.approx(100 * 2 / steps, abs=0.1), "gray")
    assert bar(states.idle) == (0.0, None)


def test_of_a_row_the_bar_is_full_with_its_last_plan_alone(row, bar):
    first, second, third = row.whole_row
    receipts = (heard(len(second.plan.sequence)),)
    onward = replace(row, plan=second.plan, proof=second.proof, sent_before=(first,))
    sending = replace(onward, row=(third,), phase=Phase.SENDING, receipts=receipts)
    assert 100 / 3 < bar(sending)[0] < 100 * 2 / 3
    assert bar(replace(sending, phase=Phase.DONE))[0] == pytest.approx(100 * 2 / 3, abs=0.1)
    whole = replace(sending, sent_before=(first, second), row=(), phase=Phase.DONE)
    assert bar(whole)[0] == pytest.approx(100.0)


def test_where_a_link_reports_no_steps_a_message_is_done_when_the_next_one_goes_out(states, bar):
    plain = spoken_to_by(states.sending.cell, "abb-socket")
    assert not plain.controller.motion.reports_progress
    told = Receipt(0.0, "right", "in", "...", 40, 40)
    sending = replace(states.sending, cell=plain, receipts=(told,))
    assert bar(sending)[0] == pytest.approx(100 * 39 / 40, abs=0.1)
    assert bar(replace(sending, phase=Phase.DONE)) == (100.0, None)
