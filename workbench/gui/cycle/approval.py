"""The dialog in which a person approves a plan."""

import math
import threading
import time
from collections.abc import Callable
from typing import Any

import viser

from workbench.app.core.cycle.approval import Approve, standing_votes
from workbench.app.core.state import State
from workbench.gui.cycle.approval_views import facts_html
from workbench.gui.drawing.nearest import PlanLinks
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.approval import ApprovalText
from workbench.model.cell import Cell
from workbench.model.release import AS_PLANNED, Manner, manner_words
from workbench.words.words import Words

SPEED_SHARES = (1.0, 0.5, 0.25, 0.1)
"""Of the planned speed, that are offered."""

FIRST_SHARE = 0.25
"""Of the planned speed, that a person changes for another: how a real robot runs a first plan."""

VOTE_ROW_MARK = '<div class="wb-buttons wb-vote"></div>'
"""A mark that lays the vote beside the way back, see the style sheet: all is seen at 720 lines."""


class ApprovalDialog:
    """Facts of the plan as the server holds them, whose vote it is, and the vote itself.

    Without a login there is a field for the name, and the button carries it as the server has
    received it: viser sends a field at most every 50 ms and may keep the last letters.  So what is
    shown there, and not what stands in the field, is what will be recorded.

    Concurrency: `open` from viser's threads, `show` from the renderer's.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is shown until `open`."""
        self._visitor = visitor
        self._lock = threading.Lock()
        self._close: Callable[[], None] | None = None
        self._named: tuple[str, tuple[str, ...]] = ("", ())
        self._chosen: Callable[[], Manner] = lambda: AS_PLANNED
        self._approved_share: float | None = None
        self._speed_line: viser.GuiHtmlHandle | None = None
        self._fields: tuple[viser.GuiDropdownHandle[str] | viser.GuiCheckboxHandle, ...] = ()

    def open(self) -> None:
        """Show the facts of the current plan, until `show` finds that it cannot be approved."""
        visitor, state = self._visitor, self._visitor.bench.state
        row = state.whole_row
        with self._lock:
            if self._close is not None or not row:
                return
            # One press is for all plans that are shown, and for no other.
            self._named = named = row[0].plan.digest, row_of(state)
            # Sent as one: letters typed before somebody listens to the field would be lost.
            with visitor.client.atomic():
                title = ApprovalText.TITLE()
                if len(row) > 1:
                    title = ApprovalText.TITLE_ROW(count=len(row))
                modal = visitor.gui.add_modal(visitor.words.render(title))
                self._close = modal.close
                with modal:
                    links = PlanLinks(visitor, self.close, len(row))
                    joints, now = visitor.bench.live.joints, time.time()
                    visitor.gui.add_html(
                        facts_html(state, joints, now, links.make_html(state), visitor.words)
                    )
                    self._add_word(state, named)

    def _add_manner(self, state: State) -> Manner:
        """Speed and steps as the controller can do them; first as others voted for this plan.

        Without votes the speed is the last that was approved here.
        """
        gui, motion = self._visitor.gui, state.cell.controller.motion
        votes = standing_votes(state, time.time())
        share = self._approved_share or first_share(state.cell)
        manner = votes[-1].manner if votes else (share, AS_PLANNED[1])
        shares = SPEED_SHARES if motion.takes_share else SPEED_SHARES[:1]
        shares = (*shares, manner[0]) if manner[0] not in shares else shares
        speed = gui.add_dropdown(
            "Speed",
            tuple(f"{share * 100:g}%" for share in shares),
            initial_value=f"{manner[0] * 100:g}%",
            disabled=len(shares) == 1,
            hint="Of what was planned; the way stays the same.",
        )
        line_of_speed = gui.add_html(_speed_html(state, manner[0], self._visitor.words))
        steps = gui.add_checkbox(
            "Step by step",
            manner[1],
            disabled=not motion.takes_steps,
            hint="The robot waits before each step until somebody lets that one run.",
        )
        by_words = {f"{share * 100:g}%": share for share in shares}
        self._fields, self._speed_line = (speed, steps), line_of_speed
        # Whatever else a browser sends is refused by the rules.
        self._chosen = lambda: (by_words.get(speed.value, math.nan), bool(steps.value))
        return manner

    def _add_word(self, state: State, named: tuple[str, tuple[str, ...]]) -> None:
        """How it is sent, the name, the way back and the vote; who is logged in has a name."""
        visitor, gui = self._visitor, self._visitor.gui
        gui.add_html(VOTE_ROW_MARK)
        shown = [visitor.person.name if visitor.is_known else ""]
        name: viser.GuiTextHandle | None = None
        if not visitor.is_known:
            recorded = "It is recorded with the plan, the time and the scan."
            name = gui.add_text("Your name", "", hint=recorded)
        chosen = self._add_manner(state)
        back = gui.add_button("Back", color="gray")
        confirm = gui.add_button(
            _label_of(shown[0], chosen, visitor.words),
            icon=viser.Icon.USER_CHECK,
            disabled=name is not None,
        )
        back.on_click(lambda _: self.close())

        def said(_: Any) -> None:
            manner = self._chosen()
            confirm.label = _label_of(shown[0], manner, visitor.words)
            if self._speed_line is not None:
                self._speed_line.content = _speed_html(state, manner[0], visitor.words)

        for field in self._fields:
            field.on_update(said)
        if name is None:
            confirm.on_click(lambda _: self._approve(named, ""))
            return
        field = name
        confirm.on_click(lambda _: self._approve(named, field.value.strip()))

        @field.on_update
        async def _(event: Any) -> None:
            typed = str(event.target.value).strip()
            confirm.disabled = not typed
            shown[0] = typed
            said(event)

    def show(self, new: View) -> None:
        """Close when what is shown is no longer what would be approved."""
        with self._lock:
            is_open = self._close is not None
        if not is_open:
            return
        plan, row = self._named
        command, joints = Approve(plan, *self._chosen(), row), new.live.joints
        if problem := self._visitor.refusal(new.state, command, new.at, joints):
            self.close()
            self._visitor.notify("Approval closed", self._visitor.words.render(problem))

    def close(self) -> None:
        """Take the dialog away."""
        with self._lock:
            take_away, self._close = self._close, None
        if take_away is not None:
            take_away()

    def _approve(self, named: tuple[str, tuple[str, ...]], name: str) -> None:
        (plan, row), manner = named, self._chosen()
        if self._visitor.ask(lambda: Approve(plan, *manner, row), name):
            self._approved_share = manner[0]
            self.close()


def first_share(cell: Cell) -> float:
    """The share of the planned speed that is offered before anybody has chosen another one.

    A browser that is loaded anew begins with it again.
    """
    controller = cell.controller
    is_slowed = controller.motion.takes_share and not controller.is_simulated
    return FIRST_SHARE if is_slowed else AS_PLANNED[0]


def row_of(state: State) -> tuple[str, ...]:
    """The digests of the plans after the plan."""
    return tuple(proven_plan.plan.digest for proven_plan in state.row)


def _label_of(name: str, manner: Manner, words: Words) -> str:
    """The label of the button."""
    if not name:
        return "Type your name to approve"
    how = manner_words(*manner)
    if how is None:
        return words.render(ApprovalText.AS(person=name))
    return words.render(ApprovalText.AS_MANNER(person=name, manner=how))


def _speed_html(state: State, share: float, words: Words) -> str:
    """How fast the robot moves by a share of the planned speed; full speed stands out."""
    if not math.isfinite(share):
        return ""
    is_full = share >= 1.0
    text = ApprovalText.FULL_SPEED if is_full else ApprovalText.SLOWER
    said = words.render(text(share=share * state.cell.policy.speed))
    return line(said, kind="warn" if is_full else "result")
