"""The kit that is being filled: what it has, and the button for a new one."""

import viser

from workbench.app.core.cell.kits import NewKit, kit_message, lacks_of
from workbench.app.core.state import State
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line, sentence
from workbench.gui.shared.visitor import Visitor
from workbench.model.messages.cells import KitText
from workbench.model.messages.message import all_of
from workbench.model.scan import Obstacle
from workbench.words.words import Words


class KitInputs:
    """A line and a button, which nobody sees where the recipe fills no kit.

    Concurrency: clicks give commands; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add both."""
        self._visitor = visitor
        self._line = visitor.gui.add_html("", visible=False)
        self._new = visitor.gui.add_button(
            "New kit",
            icon=viser.Icon.PACKAGE,
            color="gray",
            visible=False,
            hint="The kit has been taken away, complete or not, and an empty one stands there.",
        )
        visitor.on_press(self._new, NewKit)

    def show(self, new: View) -> None:
        """Bring it up to date."""
        state, visitor = new.state, self._visitor
        words = _kit_words(state, visitor.words)
        self._line.visible = self._new.visible = bool(words)
        if self._line.content != words:
            self._line.content = words
        problem = visitor.words.render(
            visitor.refusal(state, NewKit(), new.at, new.live.joints) if words else None
        )
        self._new.disabled = bool(problem)
        visitor.explain(self._new, problem)


def _kit_words(state: State, words: Words) -> str:
    """What the kit has, and how many were filled before it; empty where there is none."""
    has = kit_message(state)
    if has is None:
        return ""
    kit = state.kit
    total = KitText.BEFORE(complete=kit.complete, incomplete=kit.incomplete)
    full = None if lacks_of(state) else KitText.COMPLETE()
    said = all_of((has, full, total if kit.complete + kit.incomplete else None))
    first = line(sentence(words.render(said)), kind="hint" if full is None else "warn")
    return first + "".join(_base_line(box, words) for box in state.obstacles)


def _base_line(box: Obstacle, words: Words) -> str:
    """Where a scan shows a base, or why not; empty for what no scan has to show."""
    if box.seen is None:
        return ""
    said = sentence(words.render(box.seen.message(box.part)))
    return line(said, kind="hint" if box.seen.problem is None else "bad")
