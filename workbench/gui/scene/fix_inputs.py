"""The nearest fix with its two buttons: applied with one press, and undone with one."""

import viser

from workbench.app.core.cell.changes import UndoCell
from workbench.app.core.cell.part_edits import EditPart
from workbench.app.picking.fixing import explain_fix, make_fix_command
from workbench.gui.shared.look import NO_HELP, Help, View
from workbench.gui.shared.views import line, sentence
from workbench.gui.shared.visitor import Visitor


class FixInputs:
    """Shown while there is a fix to apply, or the last change of the cell was one.

    Concurrency: clicks give commands; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the buttons where the page is built now, unseen."""
        self._visitor = visitor
        self._help = NO_HELP
        self._scope = visitor.gui.add_html("", visible=False)
        # In some languages it would take two lines where there is room for one.
        self._wide = visitor.gui.add_html('<div class="wb-wide"></div>', visible=False)
        self._apply = visitor.gui.add_button(
            "Apply the fix",
            icon=viser.Icon.TOOL,
            color="gray",
            visible=False,
            hint="Plan again after it; Undo the fix takes it back.",
        )
        self._applied = visitor.gui.add_html("", visible=False)
        self._wide_undo = visitor.gui.add_html('<div class="wb-wide"></div>', visible=False)
        self._undo = visitor.gui.add_button(
            "Undo the fix", icon=viser.Icon.ARROW_BACK_UP, color="gray", visible=False
        )
        self._apply.on_click(lambda _: self._press())
        visitor.on_press(self._undo, UndoCell)

    def show(self, old: View | None, new: View, help: Help) -> None:
        """Bring what is shown to the newest view, in which `help` is what would admit something."""
        is_same = help is self._help and old is not None and old.state is new.state
        if is_same and old is not None and old.look.fixed == new.look.fixed:
            return
        self._help, state = help, new.state
        fix = help.fix
        can_apply = fix is not None and (fix.grasp or fix.policy) is not None
        self._wide.visible = self._apply.visible = can_apply
        words = self._visitor.words
        scope = None if fix is None or not self._apply.visible else explain_fix(state, fix)
        self._scope.content = line(words.render(scope))
        self._scope.visible = scope is not None
        self._undo.visible = bool(state.before) and new.look.fixed == state.cell.digest
        self._applied.visible = self._wide_undo.visible = self._undo.visible
        change = sentence(words.render(state.before[0].change)) if state.before else ""
        self._applied.content = line(change)
        self._visitor.admit(self._apply, state, EditPart)
        self._visitor.admit(self._undo, state, UndoCell)

    def _press(self) -> None:
        visitor, fix = self._visitor, self._help.fix
        if fix is not None and visitor.ask(lambda: make_fix_command(visitor.bench.state, fix)):
            visitor.look.change(fixed=visitor.bench.state.cell.digest)
