"""The button that plans the path of a scanner on an arm to its view."""

import viser

from workbench.app.core.cycle.viewing import PlanView
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor

SAYS = "Plans the path of the arm with the scanner from home to its view; then a person approves."


class ViewButton:
    """Beside the scan, which is taken at the view; to be seen where an arm carries the scanner."""

    def __init__(self, visitor: Visitor):
        """Add the button."""
        self._visitor = visitor
        self.button = visitor.gui.add_button(
            "Go to view", icon=viser.Icon.SCAN_EYE, visible=False, hint=SAYS
        )
        visitor.on_press(self.button, PlanView)

    def show(self, new: View) -> bool:
        """Bring it up to date; whether it is what comes before a scan."""
        state, visitor = new.state, self._visitor
        self.button.visible = state.cell.scanner.on_arm is not None
        if not self.button.visible:
            return False
        problem = visitor.refusal(state, PlanView(), new.at, new.live.joints)
        visitor.allow(self.button, visitor.words.render(problem))
        return problem is None
