"""The button that plans the path of a scanner on an arm to its view, and back home from there."""

import viser

from workbench.app.core.cycle.arm_scanner import is_at_view
from workbench.app.core.cycle.viewing import PlanView
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor
from workbench.model.robot import HOME

SAYS = "Plans the path of the arm with the scanner between home and view; then a person approves."

TO_VIEW, TO_HOME = "Go to view", "Go back home"


class ViewButton:
    """Beside the scan, which is taken at the view; to be seen where an arm carries the scanner."""

    def __init__(self, visitor: Visitor):
        """Add the button."""
        self._visitor = visitor
        self.button = visitor.gui.add_button(
            TO_VIEW, icon=viser.Icon.SCAN_EYE, visible=False, hint=SAYS
        )
        self._goal = ""
        visitor.on_press(self.button, lambda: PlanView(self._goal))

    def show(self, new: View) -> bool:
        """Bring it up to date; whether it is what comes before a scan."""
        state, visitor = new.state, self._visitor
        self.button.visible = state.cell.scanner.on_arm is not None
        if not self.button.visible:
            return False
        self._goal = HOME if is_at_view(state.cell, new.live.joints) else ""
        label = TO_HOME if self._goal else TO_VIEW
        if self.button.label != label:
            self.button.label = label
        problem = visitor.refusal(state, PlanView(self._goal), new.at, new.live.joints)
        visitor.allow(self.button, visitor.words.render(problem))
        return problem is None and not self._goal
