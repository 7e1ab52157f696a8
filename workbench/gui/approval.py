"""The dialog in which a person approves a plan."""

import threading
import time
from collections.abc import Callable
from typing import Any

import viser

from workbench.app.commands import Approve
from workbench.gui.approval_views import facts_html
from workbench.gui.look import View
from workbench.gui.visitor import Visitor, refusal


class ApprovalDialog:
    """Facts of the plan as the server holds them, a field for the name, and the word itself.

    The button carries the name as the server has received it: viser sends a field at most
    every 50 ms and may keep the last letters (`docs/architecture.md`), so what is shown there,
    and not what stands in the field, is what will be recorded.

    Concurrency: `open` from viser's threads, `show` from the renderer's.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is shown until `open`."""
        self._visitor = visitor
        self._lock = threading.Lock()
        self._close: Callable[[], None] | None = None
        self._digest = ""

    def open(self) -> None:
        """Show the facts of the current plan, unless the rules would refuse an approval."""
        visitor, state = self._visitor, self._visitor.bench.state
        plan, proof = state.plan, state.proof
        with self._lock:
            if self._close is not None or plan is None or proof is None:
                return
            self._digest = plan.digest
            modal = visitor.gui.add_modal("Approve this plan")
            self._close = modal.close
            with modal:
                joints, now = visitor.bench.live.joints, time.time()
                visitor.gui.add_html(facts_html(state, plan, proof, joints, now))
                name = visitor.gui.add_text(
                    "Your name", "", hint="It is recorded with the plan, the time and the scan."
                )
                visitor.gui.add_html('<div class="wb-buttons wb-two"></div>')
                back = visitor.gui.add_button("Back", color="gray")
                confirm = visitor.gui.add_button(
                    "Type your name to approve", icon=viser.Icon.USER_CHECK, disabled=True
                )
        back.on_click(lambda _: self.close())
        confirm.on_click(lambda _: self._approve(plan.digest, name.value.strip()))

        @name.on_update
        async def _(event: Any) -> None:
            typed = str(event.target.value).strip()
            confirm.disabled = not typed
            confirm.label = f"Approve as {typed}" if typed else "Type your name to approve"

    def show(self, new: View) -> None:
        """Close when what is shown is no longer what would be approved."""
        with self._lock:
            is_open = self._close is not None
        if is_open and (
            problem := refusal(new.state, Approve(self._digest), new.at, joints=new.live.joints)
        ):
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
