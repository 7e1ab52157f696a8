"""The dialog in which a person approves a plan."""

import threading
import time
from collections.abc import Callable
from typing import Any

import viser

from workbench.app.core.commands import Approve
from workbench.gui.cycle.approval_views import facts_html
from workbench.gui.scene.nearest import PlanLinks
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor


class ApprovalDialog:
    """Facts of the plan as the server holds them, whose vote it is, and the vote itself.

    Without a login there is a field for the name, and the button carries it as the server has
    received it: viser sends a field at most every 50 ms and may keep the last letters
    (`docs/architecture.md`), so what is shown there, and not what stands in the field, is what
    will be recorded.

    Concurrency: `open` from viser's threads, `show` from the renderer's.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is shown until `open`."""
        self._visitor = visitor
        self._lock = threading.Lock()
        self._close: Callable[[], None] | None = None
        self._digest = ""

    def open(self) -> None:
        """Show the facts of the current plan, until `show` finds that it cannot be approved."""
        visitor, state = self._visitor, self._visitor.bench.state
        plan, proof = state.plan, state.proof
        with self._lock:
            if self._close is not None or plan is None or proof is None:
                return
            self._digest = plan.digest
            # Sent as one: letters typed before somebody listens to the field would be lost.
            with visitor.client.atomic():
                modal = visitor.gui.add_modal("Approve this plan")
                self._close = modal.close
                with modal:
                    links, joints = PlanLinks(visitor, self.close), visitor.bench.live.joints
                    visitor.gui.add_html(facts_html(state, plan, proof, joints, time.time(), links))
                    self._add_word(plan.digest)

    def _add_word(self, digest: str) -> None:
        """The name, the way back and the vote; who is logged in has a name already."""
        visitor, gui = self._visitor, self._visitor.gui
        name: viser.GuiTextHandle | None = None
        if not visitor.is_known:
            name = gui.add_text("Your name", "")
            gui.add_html(line("It is recorded with the plan, the time and the scan.", kind="hint"))
        back = gui.add_button("Back", color="gray")
        confirm = gui.add_button(
            _word_of(visitor.person.name if visitor.is_known else ""),
            icon=viser.Icon.USER_CHECK,
            disabled=name is not None,
        )
        back.on_click(lambda _: self.close())
        if name is None:
            confirm.on_click(lambda _: self._approve(digest, ""))
            return
        field = name
        confirm.on_click(lambda _: self._approve(digest, field.value.strip()))

        @field.on_update
        async def _(event: Any) -> None:
            typed = str(event.target.value).strip()
            confirm.disabled = not typed
            confirm.label = _word_of(typed)

    def show(self, new: View) -> None:
        """Close when what is shown is no longer what would be approved."""
        with self._lock:
            is_open = self._close is not None
        if not is_open:
            return
        command, joints = Approve(self._digest), new.live.joints
        if problem := self._visitor.refusal(new.state, command, new.at, joints):
            self.close()
            self._visitor.tell("Approval closed", problem)

    def close(self) -> None:
        """Take the dialog away."""
        with self._lock:
            take_away, self._close = self._close, None
        if take_away is not None:
            take_away()

    def _approve(self, digest: str, name: str) -> None:
        if self._visitor.ask(lambda: Approve(digest), name):
            self.close()


def _word_of(name: str) -> str:
    """What the button says."""
    return f"Approve as {name}" if name else "Type your name to approve"
