"""The tab that shows the robot link: what went out, and what the controller says."""

import viser

from workbench.app.core.cell.changes import EmptyPallets
from workbench.app.core.cycle.unapproved import SwitchApproval
from workbench.app.core.state import Phase
from workbench.app.picking.pallets import pallets_of
from workbench.gui.shared.link_views import joints_html, link_html, unproven_html
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line, when
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.page import PageText


class RobotPanel:
    """Status, and the word that pallets are empty; what acts on the robot is in the cycle."""

    def __init__(self, visitor: Visitor):
        """Add the status fields."""
        self._visitor = visitor
        self._unproven = visitor.gui.add_html("")
        self._off = visitor.gui.add_button("Switch approval off", icon=viser.Icon.LOCK_OPEN)
        self._on = visitor.gui.add_button("Switch approval on", icon=viser.Icon.LOCK)
        self._link = visitor.gui.add_html("")
        self._pallets = visitor.gui.add_html("")
        self._empty = visitor.gui.add_button("Pallets are empty", icon=viser.Icon.CHECK)
        self._joints = visitor.gui.add_html("")
        visitor.on_press(self._empty, EmptyPallets)
        visitor.on_press(self._off, lambda: SwitchApproval(True))
        visitor.on_press(self._on, lambda: SwitchApproval(False))

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
            self._unproven.content = unproven_html(new.state, self._visitor.words)
            sends_poses = cell.controller.motion.sends_poses
            self._off.visible = sends_poses and not new.state.unapproved_by
            self._on.visible = sends_poses and not self._off.visible
            for button in (self._off, self._on):
                self._visitor.admit(button, new.state, SwitchApproval)
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
