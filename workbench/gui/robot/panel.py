"""The tab that shows the robot link: what went out, and what the controller says."""

import viser

from workbench.app.core.cell.changes import EmptyPallets
from workbench.app.core.state import Phase
from workbench.app.picking.pallets import pallets_of
from workbench.gui.shared.link_views import joints_html, link_html
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line, when
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.page import PageText


class RobotPanel:
    """Status, and the word that pallets are empty; what acts on the robot is in the cycle."""

    def __init__(self, visitor: Visitor):
        """Add the status fields."""
        self._visitor = visitor
        self._link = visitor.gui.add_html("")
        self._pallets = visitor.gui.add_html("")
        self._empty = visitor.gui.add_button("Pallets are empty", icon=viser.Icon.CHECK)
        self._joints = visitor.gui.add_html("")
        visitor.on_press(self._empty, EmptyPallets)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        if old is None or _link_shown(old) != _link_shown(new):
            self._link.content = link_html(new, self._visitor.words)
        if old is None or old.state is not new.state:
            count = len(new.state.placed)
            cell = new.state.cell
            keeps = bool(cell.stations) or any(arm.keeps_parts for arm in cell.arms)
            fills = pallets_of(cell, new.state.placed)
            texts = [
                PageText.PALLETS(count=count),
                *(text for fill in fills for text in fill.words),
            ]
            lines = (line(self._visitor.words.render(text)) for text in texts)
            self._pallets.content = "".join(lines) if keeps else ""
            self._empty.visible = keeps
            missing = "" if count else "no part lies on the pallets"
            self._visitor.admit(self._empty, new.state, EmptyPallets, otherwise=missing)
        live = new.live
        if old is None or old.live.joints is not live.joints:
            joints, at = live.joints, ""
            if not joints and live.last_joints:
                joints, at = live.last_joints, when(live.reported_at, new.at)
            self._joints.content = joints_html(new.state.cell, joints, at, self._visitor.words)


def _link_shown(view: View) -> tuple[object, ...]:
    """What the link's table is made from; while something is sent, the time belongs to it."""
    seconds = round(view.at, 1) if view.state.phase is Phase.SENDING else 0.0
    return id(view.state), id(view.live.link), view.live.robot, seconds
