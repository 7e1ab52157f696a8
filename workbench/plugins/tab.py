"""The seam of tabs: what others show and ask beside our own, in every browser."""

from typing import TYPE_CHECKING, Protocol

from workbench.plugins.found import Group, names

if TYPE_CHECKING:
    from workbench.gui.shared.look import View
    from workbench.gui.shared.visitor import Visitor

ENTRY_POINTS: Group = "workbench.tabs"


class Tab(Protocol):
    """One tab of the page.

    A class with this interface is made for each browser, while its folder of controls is open:
    `visitor.gui` adds controls to it (viser's `GuiApi`), `visitor.do` gives commands in the name of
    the person there, with that person's rights.  `title` stands on the tab.  All methods are called
    by the thread that draws: they must return at once.
    """

    title: str

    def __init__(self, visitor: "Visitor") -> None:
        """Add the controls."""
        ...

    def show(self, old: "View | None", new: "View") -> None:
        """Bring what is shown from `old`, None at first, to `new`: immutable values both."""
        ...


def tab_names() -> tuple[str, ...]:
    """All tabs that installed packages declare."""
    return names(ENTRY_POINTS)
