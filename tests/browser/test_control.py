"""Several people at one bench, each in a browser: roles, control, and what others drag."""

from types import SimpleNamespace

import numpy as np
import pytest
from hands import first_look, settle, watch
from playwright.sync_api import expect

import workbench.gui.page.renderer
import workbench.gui.shared.visitor
from workbench.app.core.control import AskForControl, ReleaseControl, TakeControl
from workbench.app.core.people import Person, Role
from workbench.gui.cell.panel import GIZMO
from workbench.gui.page.control import SETTLING
from workbench.gui.scene.dragged_bodies import DrawnHeld

ADA = Person("Ada", Role.ENGINEER)
BOB = Person("Bob", Role.OPERATOR)
VIC = Person("Vic", Role.VIEWER)


@pytest.fixture
def next_to_come(monkeypatch):
    """Who sits at the browser that comes next."""
    come = SimpleNamespace(person=ADA)
    people = {}

    def person_of(client):
        return people.setdefault(client.client_id, come.person)

    monkeypatch.setattr(workbench.gui.page.renderer, "person_of", person_of)
    monkeypatch.setattr(workbench.gui.shared.visitor, "person_of", person_of)
    return come


@pytest.fixture
def shown(monkeypatch):
    """What the scene was told last about what is dragged."""
    told = SimpleNamespace(held=None)
    draw = DrawnHeld.draw

    def noted(self, held):
        told.held = held
        draw(self, held)

    monkeypatch.setattr(DrawnHeld, "draw", noted)
    return told


def test_control_is_asked_for_handed_over_and_taken_back(next_to_come, open_screen, bench, wait):
    next_to_come.person = BOB
    bob = open_screen()
    bob.wait_for("You are in control.")
    assert bench.state.control == "Bob"
    expect(bob.button("Scan")).to_be_enabled()

    bench.do(AskForControl(), "Ada", ADA.role)
    bob.wait_for("Ada asks for control")
    bob.shoot("control-asked")
    bob.page.wait_for_timeout(SETTLING * 1000)  # since Bob has come to be in control
    bob.press("Hand over to Ada")
    bob.wait_for("Ada is in control.")
    assert bench.state.control == "Ada"
    expect(bob.button("Scan")).to_be_disabled()
    assert not bob.button("Take over").is_visible(), "only engineers take over"
    bench.do(ReleaseControl(), "Ada", ADA.role)
    bob.wait_for("Nobody has taken control")
    bob.page.wait_for_timeout(SETTLING * 1000)
    bob.press("Take control")
    wait(lambda: bench.state.control == "Bob", "control")
    bench.do(TakeControl(), "Ada", ADA.role)
    bob.wait_for("Ada takes control over from Bob")
    assert bob.errors == []


def test_take_over_asks_and_names_who_loses_control(next_to_come, open_screen, bench, wait):
    next_to_come.person = BOB
    bob = open_screen()
    bob.wait_for("You are in control.")
    next_to_come.person = ADA
    ada = open_screen()
    ada.wait_for("Bob is in control.")
    ada.page.wait_for_timeout(SETTLING * 1000)
    ada.press("Take over")
    ada.wait_for("Bob is in control. Take control over?")
    ada.shoot("control-take-over")
    ada.press("Back")
    expect(ada.button("Take over from Bob")).to_have_count(0)
    assert bench.state.control == "Bob"
    ada.page.wait_for_timeout(SETTLING * 1000)
    ada.press("Take over")
    ada.press("Take over from Bob")
    wait(lambda: bench.state.control == "Ada", "control")
    expect(ada.button("Take over from Bob")).to_have_count(0)
    assert bob.errors == ada.errors == []


def test_a_viewer_looks_and_a_watcher_sees_what_is_dragged(
    next_to_come, open_screen, bench, shown, wait
):
    ada = open_screen()
    ada.wait_for("You are in control.")
    expect(ada.page.get_by_role("tab", name="Grasps")).to_have_count(1)
    next_to_come.person = VIC
    vic = open_screen()
    vic.wait_for("Ada is in control.")
    expect(vic.button("Scan")).to_be_disabled()
    assert not vic.button("Take over").is_visible()
    for tab in ("Grasps", "Calibration"):
        expect(vic.page.get_by_role("tab", name=tab)).to_have_count(0)
    assert not vic.button("Ask for control").is_visible()
    ada.tab("Cell")
    ada.press("Show gizmo")
    ada.shoot("control-gizmo")
    vic.tab("Cell")
    for name in ("Show gizmo", "Jog"):
        expect(vic.button(name)).to_be_disabled()
    camera = first_look(ada.page, bench.state.cell)
    origin = bench.state.cell.bin.T_world_bin.translation
    along = origin + np.array([0.0, GIZMO * 0.9, 0.0])
    ada.page.mouse.move(*camera.pixel(along))
    settle(ada.page, 300)
    ada.page.mouse.down()
    ada.page.mouse.move(*camera.pixel(along + np.array([0.0, 0.05, 0.0])), steps=12)
    wait(lambda: shown.held is not None and shown.held.name == "Ada", "what Ada drags")
    vic.page.wait_for_timeout(1000)
    vic.shoot("control-viewer")
    ada.page.mouse.up()
    wait(lambda: shown.held is None and bench.state.before != (), "the end of the drag")
    assert vic.errors == ada.errors == []


def test_who_is_logged_in_approves_with_their_own_name(
    next_to_come, open_screen, bench, reaches, wait
):
    next_to_come.person = BOB
    bob = open_screen()
    bob.wait_for("You are in control.")
    for step, phase in (("Scan", "scanned"), ("Find parts", "localized"), ("Plan", "planned")):
        bob.press(step)
        reaches(phase)
    watch(bob, bench, wait)
    assert bench.state.watched == ("Bob",)
    bob.press("Approve")
    bob.press("Approve as Bob")
    state = reaches("approved")
    assert state.approval.people == ("Bob",)
    assert bob.errors == []
