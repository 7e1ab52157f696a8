"""The tab that shows the robot link: what went out, and what the controller says."""

from workbench.gui.look import View
from workbench.gui.views import joints_html, link_html
from workbench.gui.visitor import Visitor


class RobotPanel:
    """Status only; what acts on the robot is in the cycle."""

    def __init__(self, visitor: Visitor):
        """Add the status fields."""
        self._link = visitor.gui.add_html("")
        self._joints = visitor.gui.add_html("")

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        if old is None or old.state is not new.state or old.live.robot != new.live.robot:
            self._link.content = link_html(new)
        if old is None or old.live.joints is not new.live.joints:
            self._joints.content = joints_html(new.state.cell, new.live.joints)
