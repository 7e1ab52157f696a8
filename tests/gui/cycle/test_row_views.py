"""What the approval and the plan's tab say of a row: each plan by its number, sums of all."""

import re
from dataclasses import replace
from html import unescape

from workbench.app.core.state import Phase
from workbench.gui.cycle.approval_views import facts_html
from workbench.gui.cycle.sending_views import send_line
from workbench.gui.plan.views import plan_html
from workbench.model.derived.row_parts import parts_taken
from workbench.model.release import Receipt


def read(html):
    return unescape(re.sub(r"<[^>]+>", "", html))


def test_of_a_row_every_plan_is_approved_in_full_and_sums_are_of_all(row, states):
    text = read(facts_html(row, {}, 0.0))
    for number, one in enumerate(row.whole_row, 1):
        assert f"Plan {number}" in text and f"plan {one.plan.digest[:12]}" in text
        assert one.proof.digest[:12] in text
        for arm, part in zip(one.plan.arms, parts_taken(row.plan, one.plan), strict=True):
            takes = f"{arm.arm} arm part-{part + 1} (keyed_cylinder), grasp {arm.grasp}"
            assert takes in text
    # What is nearest is in the second plan, and its part-1 is the scan's part-3.
    assert "Free motionplan 2: at least 2.1 mm" in text
    assert "part-3 and bin_wall_left" in text
    assert "Linear motionplan 1: " in text
    alone = states.planned
    assert f"{3 * alone.plan.cycle_seconds:.1f} s in all" in text
    assert f"{3 * alone.proof.checks:,} positions checked" in text
    legs = 3 * sum(len(arm.legs) for arm in alone.plan.arms)
    assert f"the whole motion on {legs} legs" in text
    assert "each plan with what those before it leave" in text
    assert "Certificatesplan 1, plan 2, plan 3" in text


def test_the_tab_of_the_plan_tells_each_plan_of_a_row_by_its_number(row):
    text = read(plan_html(row))
    total = 3 * row.plan.cycle_seconds
    assert text.startswith(f"3 plans in a row, 6 parts, {total:.1f} s in all")
    for number, one in enumerate(row.plans, 1):
        assert f"Plan {number}: {one.cycle_seconds:.1f} s" in text
        assert f"plan {one.digest[:12]}" in text
    assert sorted(re.findall(r"part-\d", text)) == [f"part-{number}" for number in range(1, 7)]


def test_messages_are_those_of_the_plan_that_is_named(row, states):
    first, second, third = row.whole_row
    sending = states.sending
    assert read(send_line(sending)) == "3 of 40 messages sent"
    onward = replace(
        sending, plan=second.plan, proof=second.proof, sent_before=(first,), row=(third,)
    )
    assert read(send_line(onward)) == "3 of 40 messages sent (plan 2)"


def test_once_the_robot_reports_steps_these_are_told(states):
    steps = len(states.sending.plan.sequence)
    told = (*states.sending.receipts, Receipt(0.0, "", "heard", "", 76, 76, step=4))
    sending = replace(states.sending, receipts=told)
    assert read(send_line(sending)) == f"Step 4 of {steps}"
    assert read(send_line(replace(sending, phase=Phase.FAULT))) == f"Ended in step 4 of {steps}"
    assert read(send_line(replace(sending, phase=Phase.DONE))) == f"All {steps} steps done"


def test_a_plan_alone_says_nothing_of_a_row(states):
    text = read(plan_html(states.planned))
    assert "in a row" not in text and "Plan 1" not in text
