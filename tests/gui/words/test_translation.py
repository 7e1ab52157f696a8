"""What one browser is told, read as it comes over the wire: in its language, and English inside."""

import asyncio

import msgspec
import pytest
from raw_browser import raw_browser
from waiting import wait_until

from workbench.gui.shared.viser_server import close_viser, language_of, open_viser
from workbench.gui.words.translation import speak
from workbench.studies.load.raw_browser import unpack
from workbench.words.words import Words

WORDS = Words(
    "de",
    {
        "Stop": "Stopp",
        "Plan": "Plan",
        "all": "alle",
        "both": "beide",
        "each": "beide",
        "some parts": "einige Teile",
    },
)


@pytest.fixture
def server():
    server = open_viser("127.0.0.1", 0)
    yield server
    close_viser(server)


@pytest.fixture
def made(server):
    """Widgets of a browser, by its language; none where there is no browser yet."""
    found = {}

    @server.on_client_connect
    def _(client):
        if language_of(client) == "de":
            speak(client, WORDS)
        with client.atomic():
            tabs = client.gui.add_tab_group()
            tabs.add_tab("Stop")
            found[language_of(client)] = (
                client.gui.add_button("Stop", hint="some parts"),
                client.gui.add_html('<b title="Stop">some parts</b>'),
                client.gui.add_dropdown(
                    "Plan", ("all", "both", "each", "mine"), initial_value="both"
                ),
            )

    return found


async def read(browser, kinds):
    """The first message of each kind."""
    found = {}
    while set(kinds) - set(found):
        for message in unpack(await browser.recv()):
            found.setdefault(message["type"], message)
    return found


KINDS = ("GuiButtonMessage", "GuiHtmlMessage", "GuiDropdownMessage", "GuiTabGroupMessage")


async def seen(port, language, then=None):
    async with raw_browser(port, {"Accept-Language": language}) as browser:
        found = await asyncio.wait_for(read(browser, KINDS), 60)
        if then is not None:
            await then(browser, found)
        return [
            found["GuiButtonMessage"]["props"]["label"],
            found["GuiButtonMessage"]["props"]["hint"],
            found["GuiHtmlMessage"]["props"]["content"],
            tuple(found["GuiDropdownMessage"]["props"]["options"]),
            found["GuiDropdownMessage"]["value"],
        ]


def test_two_browsers_are_told_the_same_in_two_languages(server, made):
    async def both():
        return await asyncio.gather(seen(server.get_port(), "de-DE"), seen(server.get_port(), "en"))

    german, english = asyncio.run(both())
    assert english == [
        "Stop",
        "some parts",
        '<b title="Stop">some parts</b>',
        ("all", "both", "each", "mine"),
        "both",
    ]
    # What would read alike stays as it is: nobody could tell what was meant.
    assert german == [
        "Stopp",
        "einige Teile",
        '<b title="Stopp">einige Teile</b>',
        ("alle", "beide", "each", "mine"),
        "beide",
    ]


def test_what_is_chosen_comes_back_in_english_and_widgets_hold_english(server, made):
    async def choose(browser, found):
        uuid = found["GuiDropdownMessage"]["uuid"]
        message = {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": "alle"}}
        await browser.send(msgspec.msgpack.encode(message))
        button, _, dropdown = made["de"]
        await asyncio.to_thread(wait_until, lambda: dropdown.value == "all", "the choice")
        assert (button.label, dropdown.options) == ("Stop", ("all", "both", "each", "mine"))
        dropdown.options = ("each", "all")
        button.label = "some parts"
        told = {}
        while not {"options", "label"} <= set(told):
            for one in unpack(await browser.recv()):
                if one["type"] == "GuiUpdateMessage":
                    told |= one["updates"]
        assert (tuple(told["options"]), told["label"]) == (("beide", "alle"), "einige Teile")
        assert button.label == "some parts"

    asyncio.run(seen(server.get_port(), "de", choose))
