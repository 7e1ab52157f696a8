"""Vision only on the page: what is not proven, and who has switched approval off."""

from dataclasses import replace
from html.parser import HTMLParser

from workbench.gui.cycle.approval_views import approval_line, facts_html
from workbench.gui.shared.link_views import unproven_html

EVIL = "<script>alert(2)</script>&amp;"


class Reader(HTMLParser):
    """Notes tags and text."""

    def __init__(self, html: str):
        super().__init__()
        self.tags: list[str] = []
        self.text = ""
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)

    def handle_data(self, data):
        self.text += data


def test_vision_only_says_that_nothing_is_proven_and_who_has_switched_approval_off(states):
    state = states.planned
    assert unproven_html(state) == ""
    motion = replace(state.cell.controller.motion, sends_poses=True)
    cell = replace(state.cell, controller=replace(state.cell.controller, motion=motion))
    seeing = replace(state, cell=cell)
    assert "Nothing of its motion is proven" in Reader(unproven_html(seeing)).text
    assert "approval" not in unproven_html(seeing)
    off = Reader(unproven_html(replace(seeing, unapproved_by=EVIL)))
    assert "has switched approval off" in off.text and EVIL in off.text
    assert "script" not in off.tags
    text = Reader(facts_html(seeing, {}, 0.0)).text
    assert "nothing of the motion that the robot's own program makes" in text
    assert "stops at each" not in text


def test_an_approval_that_is_switched_off_names_nobody_who_has_approved(states):
    state = states.approved
    off = replace(state, approval=replace(state.approval, is_switched_off=True, is_unwatched=True))
    shown = Reader(approval_line(off, state.approval.at, "")).text
    assert "Not approved" in shown and "switched approval off" in shown
