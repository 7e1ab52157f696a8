"""The table of the plans for the same parts: each can be pressed but the one that is taken."""

from dataclasses import replace

from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.state import Outline
from workbench.gui.plan.panel import PlanPanel
from workbench.gui.plan.views import outlines_html
from workbench.model.cell import PlanOverrides
from workbench.model.messages.message import plain

ONE = Outline("rrtconnect", 0.4, "alternated", parts=2, cycle=9.0, digest="a" * 64)
OTHER = Outline("sbl", 0.2, "left", parts=1, cycle=8.0, digest="b" * 64)
NONE = Outline("rrt", 0.1, verdict=plain("no path"))


def test_every_plan_but_the_one_that_is_taken_can_be_pressed():
    html = outlines_html((ONE, OTHER, NONE), ONE.digest, ("first", "second", "third"))
    assert "'second'" in html and "'first'" not in html and "'third'" not in html
    taken = html[html.index("wb-taken") :]
    assert taken.index("alternated, 2 parts") < taken.index("</tr>")
    assert "left arm only, 1 part" in html and "A row that is clicked" in html
    assert html.index("no path") < html.index("left arm only"), "the latest first"


def test_a_row_of_plans_is_told_from_a_single_one_and_its_clearance_is_rounded_down():
    row = replace(ONE, digest="c" * 64, parts=4, plans=2, clearance=0.00729)
    html = outlines_html((ONE, row), ONE.digest, ("first", "second"))
    assert "alternated, 4 parts, 2 plans" in html
    assert "7.2 mm" in html, "as the sentence beside it says"


def test_where_there_is_nothing_to_choose_nothing_can_be_pressed():
    assert outlines_html((ONE,), ONE.digest, ("first",)) == ""
    html = outlines_html((ONE, NONE), ONE.digest, ("first", "second"))
    assert "button" not in html and "A row that is clicked" not in html


def test_a_row_asks_for_the_plan_as_it_was_made(visitor, monkeypatch):
    asked = []
    one = Outline(
        "sbl",
        0.2,
        "left",
        digest="b",
        asked="auto",
        threshold=0.3,
        seed=7,
        overrides=PlanOverrides("sbl"),
    )
    panel = PlanPanel(visitor, "slider")
    state = visitor.bench.state
    monkeypatch.setattr(type(visitor.bench), "state", property(lambda _: state))
    panel._again(0)
    assert asked == [] and visitor.client.told == [], "there is no such row"
    state = replace(state, outlines=(one,))
    panel._again(0)
    assert "take a scan first" in visitor.client.told[-1]
    monkeypatch.setattr(visitor, "obstacle", lambda *_: "")
    monkeypatch.setattr(visitor, "ask", lambda made: asked.append(made()))
    panel._again(0)
    (command,) = asked
    assert isinstance(command, MakePlan)
    assert (command.strategy, command.threshold, command.seed) == ("auto", 0.3, 7)
    assert command.overrides.planner == "sbl"
