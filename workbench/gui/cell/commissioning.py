"""The steps of commissioning as a list: what is done, what is next, and a way to its tab."""

from collections.abc import Mapping
from html import escape

from workbench.app.review.commissioning import CheckedStep, Step, checklist, next_step
from workbench.gui.shared.icons import TAB_ICONS
from workbench.gui.shared.look import View
from workbench.words.words import IN_ENGLISH, Words

TABS: Mapping[Step, str] = {
    Step.LOAD: "Cell",
    Step.CALIBRATION: "Calibration",
    Step.GRASPS: "Grasps",
    Step.SCAN: "Cycle",
    Step.PARTS: "Cycle",
    Step.PLAN: "Cycle",
    Step.PICK: "Cycle",
    Step.SAVED: "Cell",
}
"""Where each step is done."""


def steps_html(view: View, words: Words = IN_ENGLISH) -> str:
    """A line for each step, which opens the tab where the step is done."""
    checked = checklist(view.state, view.statistics, view.at)
    upcoming = next_step(checked)
    lines = "".join(_line(each, each.step is upcoming, words) for each in checked)
    return f'<ol class="wb-checks">{lines}</ol>'


def _line(checked: CheckedStep, is_next: bool, words: Words) -> str:
    kind = "wb-done" if checked.is_done else "wb-next" if is_next else "wb-later"
    text = escape(words.render(checked.says))
    icon = escape(TAB_ICONS[TABS[checked.step]])
    # Tabs hear no click that a script makes, but what a person's Enter does.
    enter = "new KeyboardEvent('keydown',{key:'Enter',bubbles:true})"
    press = f"document.querySelector('[role=tab]:has(.icon-tabler-{icon})')?.dispatchEvent({enter})"
    key = f"if(event.key==='Enter'||event.key===' '){{event.preventDefault();{press}}}"
    opens = f'tabindex="0" role="button" onclick="{press}" onkeydown="{key}"'
    return f'<li class="{kind}"><span {opens}>{text}</span></li>'
