"""A button that is grey says what is missing, whoever looks at it and in whatever state."""

from dataclasses import replace

import pytest
import viser

from workbench.app.core.people import Person, Role
from workbench.app.runtime.live import Live
from workbench.gui.page.tabs import tabs_of
from workbench.gui.shared.look import View
from workbench.gui.shared.viser_server import buttons_of

SAID_BESIDE = {
    "Save as CSV": "the table above is empty",
    "Previous": "it is the first page",
    "Next": "it is the last page",
}
"""Buttons beside which it stands why they cannot be pressed."""


def silent(gui: viser.GuiApi, made: dict[str, str | None]) -> list[str]:
    """Labels of buttons that cannot be pressed and say nothing but what they always say."""
    return [
        button.label
        for button in buttons_of(gui)
        if button.disabled
        and button.visible
        and button.label not in SAID_BESIDE
        and button.hint == made[button._impl.uuid]
    ]


@pytest.mark.parametrize("who", ["engineer", "viewer", "not in control"])
@pytest.mark.parametrize("phase", ["idle", "localized", "planned"])
def test_what_cannot_be_pressed_says_why(visitor, bench, states, monkeypatch, who, phase):
    state = getattr(states, phase)
    if who == "viewer":
        visitor.person = Person("Vic", Role.VIEWER)
    elif who == "not in control":
        state = replace(state, control="Bob")
    monkeypatch.setattr(type(bench), "state", property(lambda _: state))
    panels = tabs_of(visitor, lambda: None, "slider")
    made = {button._impl.uuid: button.hint for button in buttons_of(visitor.gui)}
    view = View(state, Live(), visitor.look.now, (), 0.0)
    for panel in panels:
        panel.show(None, view)
    assert silent(visitor.gui, made) == []
