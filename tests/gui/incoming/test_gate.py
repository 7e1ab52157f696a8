"""What a browser without a screen sends to widgets, and what it is told then."""

import asyncio

import pytest
from few_widgets import run

from workbench.gui.incoming import gate


@pytest.mark.parametrize(
    ("name", "wrong", "true"),
    [
        ("choice", "/etc/passwd", "all"),
        ("choice", 5, "all"),
        ("count", 12.5, 12),
        ("count", "13", 12),
        ("count", True, 12),
        ("size", 0.123, 0.5),
        ("size", None, 0.5),
        ("place", [0.0, 0.0], [0.0, 0.0, 0.0]),
        ("place", [0.0, "x", 0.0], [0.0, 0.0, 0.0]),
        ("name", "a\0b", "Ada"),
        ("name", ["Ada"], "Ada"),
        ("is_on", 1, False),
        ("colour", [1, 2, 2.5], [1, 2, 3]),
        ("span", [0.8, 0.2], [0.2, 0.8]),
        ("bar", 50.0, 10.0),
    ],
)
def test_a_value_that_is_not_offered_is_not_taken_and_the_true_one_is_shown(
    hands, caplog, name, wrong, true
):
    async def look():
        async with hands() as hand:
            await hand.set(name, wrong)
            await hand.is_shown(name, true)
            await hand.set("press", True)
            await hand.uses("press")

    run(look())
    (told,) = (line for line in caplog.messages if "refused value" in line)
    assert "Traceback" not in caplog.text
    assert "\0" not in told


@pytest.mark.parametrize(
    ("name", "right", "taken"),
    [
        ("choice", "none", "none"),
        ("count", 13.0, 13),
        ("size", 1, 1.0),
        ("place", [0.1, -5, 0.0], (0.1, -5.0, 0.0)),
        ("name", "Grüße 测试", "Grüße 测试"),
        ("is_on", True, True),
        ("colour", [9, 2, 3], (9, 2, 3)),
        ("span", [0.1, 0.8], (0.1, 0.8)),
        ("tabbed", True, "tabbed"),
        ("group", "right", "group"),
    ],
)
def test_a_value_that_is_offered_is_taken(hands, caplog, name, right, taken):
    async def look():
        async with hands() as hand:
            await hand.set(name, right)
            await hand.uses(taken)
            assert type(hand.made.uses[0]) is type(taken)

    run(look())
    assert "refused" not in caplog.text


@pytest.mark.parametrize("name", ["off", "away", "inner", "bar", "gone"])
def test_what_is_disabled_hidden_or_gone_is_not_pressed(hands, caplog, name):
    async def look():
        async with hands() as hand:
            hand.made.gone = hand.made.client.gui.add_button("gone")
            hand.made.gone.on_click(lambda _: hand.made.uses.append("gone"))
            hand.made.gone.remove()
            await hand.set(name, True)
            await hand.set("press", True)
            await hand.uses("press")

    run(look())
    assert "refused value" in caplog.text


def test_nobody_uses_the_widgets_of_another_browser(hands, caplog):
    async def look():
        async with hands() as one, hands() as other:
            await one.say(
                "GuiUpdateMessage", uuid=other.made.id_of("press"), updates={"value": True}
            )
            await one.say("CommandTriggerMessage", uuid=other.made.id_of("key"))
            await one.say(
                "TransformControlsUpdateMessage",
                name="/gizmo",
                owner=str(other.made.client.client_id),
                wxyz=(1.0, 0.0, 0.0, 0.0),
                position=(1.0, 0.0, 0.0),
            )
            await one.set("press", True)
            await one.uses("press")
            assert other.made.uses == []

    run(look())
    assert caplog.text.count("it is not there") == 3


def test_who_types_a_number_may_pass_others_that_are_none(hands, caplog):
    async def look():
        async with hands() as hand:
            for typed in (1, 15):
                await hand.set("count", typed)
            await hand.uses(15)
            await hand.set("place", [9.0, 0.0, 0.0])
            await hand.set("place", [0.9, 0.0, 0.0])
            await hand.uses(15, (0.9, 0.0, 0.0))

    run(look())
    assert "refused" not in caplog.text


def test_a_number_that_is_left_beyond_its_bounds_becomes_the_true_one(hands, caplog, monkeypatch):
    monkeypatch.setattr(gate, "WHILE_TYPING", 0.05)

    async def look():
        async with hands() as hand:
            await hand.set("count", 1)
            await hand.is_shown("count", 12)
            assert hand.made.uses == []

    run(look())
    assert "too small" in caplog.text


def test_a_browser_that_goes_while_somebody_types_leaves_nothing(hands, caplog, monkeypatch):
    monkeypatch.setattr(gate, "WHILE_TYPING", 0.3)

    async def look():
        async with hands() as hand:
            await hand.set("count", 1)
            await hand.set("press", True)
            await hand.uses("press")
        await asyncio.sleep(0.5)

    run(look())
    assert "refused" not in caplog.text


def test_choices_of_another_language_are_compared_in_english(server, hands, caplog):
    async def look():
        async with hands():
            server.speaks = True
            async with hands() as hand:
                await hand.set("choice", "keine")
                await hand.uses("none")
                await hand.set("choice", "nichts")
                await hand.is_shown("choice", "keine")

    run(look())
    assert "none of the options" in caplog.text
