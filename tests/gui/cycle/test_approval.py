"""The dialog in which a person approves, with a browser in which somebody types very early."""

from contextlib import contextmanager, nullcontext
from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.core.state import EditedCell
from workbench.gui.cycle.approval import ApprovalDialog, first_share
from workbench.gui.cycle.approval_views import facts_html
from workbench.gui.cycle.plan_views import left_message, plan_line, unsaved_message
from workbench.gui.parts.fates import part_fates
from workbench.gui.shared.icons import opens_tab
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.messages.message import plain
from workbench.model.messages.plans import PlanNote
from workbench.proof.claims.clearance import linear_clearance
from workbench.words.words import IN_ENGLISH


class Widget(SimpleNamespace):
    """A field or button; who listens to it."""

    def on_click(self, then):
        self.clicked = then

    def on_update(self, then):
        self.updated = then


class QuickHand:
    """Stands for a browser: a name is typed as soon as the field has arrived there."""

    def __init__(self, name):
        self.name, self.field, self.buttons = name, None, {}
        self.is_held = False

    @contextmanager
    def atomic(self):
        self.is_held = True
        yield
        self.is_held = False
        self.type()

    def type(self):
        """What viser does with a letter: the newest value is kept, who listens is told."""
        if self.field is None:
            return
        self.field.value = self.name
        if listens := getattr(self.field, "updated", None):
            with pytest.raises(StopIteration):
                listens(SimpleNamespace(target=self.field)).send(None)

    def add_modal(self, title):
        modal = nullcontext()
        modal.close = lambda: None
        return modal

    def add_html(self, html):
        self.html = [*getattr(self, "html", []), Widget(content=html)]
        return self.html[-1]

    def add_text(self, label, value, hint=None):
        self.field = Widget(value=value)
        if not self.is_held:
            self.type()
        return self.field

    def add_dropdown(self, label, options, initial_value, **said):
        return Widget(value=initial_value, options=options, **said)

    def add_checkbox(self, label, value, **said):
        return Widget(value=value, **said)

    def add_button(self, label, **said):
        button = Widget(label=label, disabled=said.get("disabled", False))
        self.buttons[label] = button
        return button


def visitor_of(states, hand, *, is_known):
    """A person in a browser, before a plan that can be approved."""
    bench = SimpleNamespace(state=states.planned, live=SimpleNamespace(joints={}))
    links = {"unseen": lambda pressed: "id", "hide": lambda buttons: None}
    return SimpleNamespace(
        bench=bench, gui=hand, client=hand, is_known=is_known, words=IN_ENGLISH, **links
    )


def test_a_name_that_is_typed_at_once_is_on_the_button(states):
    hand = QuickHand("Anna")
    visitor = visitor_of(states, hand, is_known=False)
    dialog = ApprovalDialog(visitor)
    dialog.open()
    word = hand.buttons["Type your name to approve"]
    assert word.label == "Approve as Anna, at 25% of the planned speed"
    assert not word.disabled


def test_full_speed_has_a_line_of_its_own_that_follows_the_choice(states):
    visitor = visitor_of(states, QuickHand("Anna"), is_known=True)
    visitor.person = SimpleNamespace(name="Anna")
    dialog = ApprovalDialog(visitor)
    dialog.open()
    speed, field = dialog._speed_line, dialog._fields[0]
    field.value = "100%"
    field.updated(None)
    assert "Full speed" in speed.content and "wb-warn" in speed.content
    field.value = "25%"
    field.updated(None)
    assert "Full speed" not in speed.content and "wb-warn" not in speed.content


def test_a_real_robot_begins_slowly_and_goes_on_as_was_approved_last(states):
    visitor = visitor_of(states, QuickHand("Anna"), is_known=True)
    visitor.person = SimpleNamespace(name="Anna")
    visitor.ask = lambda command, name: bool(command())
    dialog = ApprovalDialog(visitor)
    dialog.open()
    assert dialog._fields[0].value == "25%"
    dialog._fields[0].value = "50%"
    dialog._approve(dialog._named, "")
    dialog.open()
    assert dialog._fields[0].value == "50%"


def test_a_simulated_robot_and_links_without_a_share_begin_as_planned(cell):
    controller = cell.controller
    assert first_share(cell) == 0.25
    simulated = replace(controller, is_simulated=True)
    assert first_share(replace(cell, controller=simulated)) == 1.0
    fixed = replace(controller, motion=replace(controller.motion, takes_share=False))
    assert first_share(replace(cell, controller=fixed)) == 1.0


def deviations(state, joints):
    html = facts_html(state, joints, 0.0)
    return html[: html.index("wb-usual")]


def test_what_deviates_from_a_plain_plan_stands_first(states):
    state = replace(states.planned, saved=states.planned.cell.digest, watched=("Anna",))
    first = deviations(
        state, state.cell.joint_values({arm.name: arm.home for arm in state.cell.arms})
    )
    assert "<th>Controller</th>" in first, "simulated"
    for name in (
        "Linear motion",
        "Not saved",
        "Warnings",
        "Robot",
        "Preview",
        "Kept clear of",
        "Proven",
    ):
        assert f"<th>{name}</th>" not in first
    remark = PlanNote.GOES_UNSEEN()
    plan = replace(state.plan, notes=(remark,))
    worse = replace(state, plan=plan, watched=(), scan=None, saved="")
    first = deviations(worse, {})
    for name in ("Not saved", "Warnings", "Robot", "Preview", "Kept clear of"):
        assert f"<th>{name}</th>" in first, name
    assert str(remark) in first


def test_a_linear_motion_deviates_only_below_its_near_margin(states):
    state = states.planned
    bound, margin = linear_clearance(state.proof), state.cell.policy.near_margin
    assert bound > margin
    assert "<th>Linear motion</th>" not in deviations(state, {})
    for near_margin, deviates in ((bound, False), (bound + 1e-4, True)):
        policy = replace(state.cell.policy, near_margin=near_margin)
        asked = replace(state, cell=replace(state.cell, policy=policy))
        assert ("<th>Linear motion</th>" in deviations(asked, {})) is deviates


def test_what_is_not_saved_is_said_at_the_plan_and_names_the_last_change(states):
    cell = states.planned.cell
    saved = replace(states.planned, saved=cell.digest)
    assert unsaved_message(saved) is None and "not saved" not in plan_line(saved)
    older = EditedCell(cell, plain("grasp a moved"))
    other = replace(cell, name="other")
    edited = replace(saved, cell=other, before=(EditedCell(other, plain("b turned")), older))
    said = str(unsaved_message(edited))
    assert said == "2 changes of cell or grasps not saved, the last: b turned"
    assert "Rests on what is not saved: 2 changes" in plan_line(edited)
    unknown = replace(edited, saved="elsewhere")
    assert str(unsaved_message(unknown)) == "cell or grasps differ from their files"


def state_with(planned, *verdicts, spare=3):
    """The planned state with further parts, and candidates of these parts, reasons and arms."""
    found = (*planned.detections, *planned.detections[:1] * spare)
    tried = tuple(
        replace(
            planned.candidates[0], detection=part, arm=arm, verdict=Verdict(reason, Stage.GRASP)
        )
        for part, reason, arm in verdicts
    )
    plan = replace(planned.plan, detections=found)
    return replace(planned, detections=found, plan=plan, candidates=tried)


def test_a_plan_says_why_most_of_the_other_parts_are_left(states):
    planned = states.planned
    assert left_message(planned) is None, "it takes both"
    refused = [(part, Reason.OUT_OF_REACH, "left") for part in (2, 3)]
    last = (4, Reason.TOOL_COLLISION, "right")
    state = state_with(planned, *refused, last)
    assert str(left_message(state)) == (
        "3 parts left; most frequent reason: unreachable (2, left arm)"
    )
    html = plan_line(state)
    assert "3 parts left; most frequent reason" in html and opens_tab("Parts") in html
    both = state_with(planned, refused[0], (3, Reason.OUT_OF_REACH, "right"), last)
    assert str(left_message(both)).endswith("unreachable (2, left and right arm)")
    some = state_with(planned, (2, Reason.OK, "left"), *refused[1:], last)
    assert str(left_message(some)) == (
        "1 part left for a later plan; 2 parts left; most frequent reason: unreachable (1, left "
        "arm)"
    )


def test_the_arm_that_takes_another_part_can_take_one_later(states):
    left_arm, right_arm = (2, Reason.OUT_OF_REACH, "left"), (2, Reason.OK, "right")
    state = state_with(states.planned, left_arm, right_arm, spare=1)
    right = tuple(pick for pick in state.plan.picks if pick.arm == "right")
    alone = replace(state, plan=replace(state.plan, arms=right))
    other = next(pick.detection for pick in state.plan.picks if pick.arm == "left")
    fates = part_fates(alone)
    assert str(fates[2]) == "Left for a later plan: 1 grasp works"
    assert str(fates[other]) == "Not taken: no grasp was tried"
    assert str(left_message(alone)) == (
        "1 part left for a later plan; 1 part left: no grasp was tried"
    )


def test_parts_that_no_grasp_was_tried_for_are_not_left_for_a_later_plan(states):
    state = state_with(states.planned)
    assert str(left_message(state)) == "3 parts left: no grasp was tried"
    assert str(part_fates(state)[2]) == "Not taken: no grasp was tried"
    assert left_message(replace(state, candidates=None)) is None, "nothing is known of them"
