"""The dialog in which a person approves, with a browser in which somebody types very early."""

from contextlib import contextmanager, nullcontext
from types import SimpleNamespace

import pytest

from workbench.gui.cycle.approval import ApprovalDialog
from workbench.words.words import IN_ENGLISH


class Widget(SimpleNamespace):
    """A field or button; who listens to it."""

    def on_click(self, then):
        self.clicked = then

    def on_update(self, then):
        self.updated = then


class QuickHand:
    """Stands for a browser: a name is typed as soon as the field has arrived there."""

    def __init__(self, name):
        self.name, self.field, self.buttons = name, None, {}
        self.is_held = False

    @contextmanager
    def atomic(self):
        self.is_held = True
        yield
        self.is_held = False
        self.type()

    def type(self):
        """What viser does with a letter: the newest value is kept, who listens is told."""
        self.field.value = self.name
        if listens := getattr(self.field, "updated", None):
            with pytest.raises(StopIteration):
                listens(SimpleNamespace(target=self.field)).send(None)

    def add_modal(self, title):
        modal = nullcontext()
        modal.close = lambda: None
        return modal

    def add_html(self, html):
        pass

    def add_text(self, label, value, hint=None):
        self.field = Widget(value=value)
        if not self.is_held:
            self.type()
        return self.field

    def add_dropdown(self, label, options, initial_value, **said):
        return Widget(value=initial_value, options=options, **said)

    def add_checkbox(self, label, value, **said):
        return Widget(value=value, **said)

    def add_button(self, label, **said):
        button = Widget(label=label, disabled=said.get("disabled", False))
        self.buttons[label] = button
        return button


def test_a_name_that_is_typed_at_once_is_on_the_button(states):
    hand = QuickHand("Anna")
    bench = SimpleNamespace(state=states.planned, live=SimpleNamespace(joints={}))
    links = {"unseen": lambda pressed: "id", "hide": lambda buttons: None}
    visitor = SimpleNamespace(
        bench=bench, gui=hand, client=hand, is_known=False, words=IN_ENGLISH, **links
    )
    dialog = ApprovalDialog(visitor)
    dialog.open()
    word = hand.buttons["Type your name to approve"]
    assert word.label == "Approve as Anna"
    assert not word.disabled
