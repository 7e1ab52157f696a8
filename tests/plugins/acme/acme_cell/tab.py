"""A tab that counts for Acme's maintenance how often the hands have closed."""

from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor


class AcmeTab:
    """One line of text."""

    title = "Acme"

    def __init__(self, visitor: Visitor) -> None:
        self._text = visitor.gui.add_markdown("Pincer: nothing known yet")

    def show(self, old: View | None, new: View) -> None:
        """The plan's grips, as soon as there is a plan."""
        plan = new.state.plan
        if old is None or old.state.plan is not plan:
            grips = 0 if plan is None else len(plan.arms)
            self._text.content = f"Pincer: this plan closes it {grips} times"
