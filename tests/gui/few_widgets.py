"""One widget of each kind in one browser, and the hand that uses them."""

import asyncio

import msgspec
from waiting import PATIENCE, wait_until

from workbench.gui.words.translation import speak
from workbench.studies.load.raw_browser import unpack
from workbench.words.words import Words

GERMAN = Words("de", {"all": "alle", "none": "keine"})


class Made:
    """The widgets of one browser, and what they were used for."""

    def __init__(self, client):
        self.client = client
        self.uses = []
        if client.client_id and client._viser_server.speaks:
            speak(client, GERMAN)
        gui = client.gui
        with client.atomic():
            self.choice = gui.add_dropdown("choice", ("all", "none"), initial_value="all")
            self.count = gui.add_number("count", 12, min=10, max=30, step=1)
            self.size = gui.add_slider("size", min=0.0, max=1.0, step=0.1, initial_value=0.5)
            self.place = gui.add_vector3("place", (0.0, 0.0, 0.0), step=0.1, max=(1.0, 1.0, 1.0))
            self.name = gui.add_text("name", "Ada")
            self.is_on = gui.add_checkbox("on", False)
            self.press = gui.add_button("press")
            self.off = gui.add_button("off", disabled=True)
            self.away = gui.add_button("away", visible=False)
            with gui.add_folder("folder", visible=False), gui.add_folder("inner"):
                self.inner = gui.add_button("inner")
            with gui.add_tab_group().add_tab("tab"):
                self.tabbed = gui.add_button("tabbed")
            self.file = gui.add_upload_button("file")
            self.colour = gui.add_rgb("colour", (1, 2, 3))
            self.span = gui.add_multi_slider("span", 0.0, 1.0, 0.1, (0.2, 0.8))
            self.group = gui.add_button_group("group", ("left", "right"))
            self.bar = gui.add_progress_bar(10.0)
            self.key = gui.add_command("key", hotkey="X")
            self.gizmo = client.scene.add_transform_controls("/gizmo")
            self.ball = client.scene.add_icosphere("/ball", 1.0)
        for one in ("choice", "count", "size", "place", "name", "is_on", "colour", "span"):
            getattr(self, one).on_update(lambda event: self.uses.append(event.target.value))
        for one in ("press", "off", "away", "inner", "tabbed", "group"):
            getattr(self, one).on_click(lambda event: self.uses.append(event.target.label))
        self.file.on_upload(lambda event: self.uses.append(event.target.value.name))
        self.key.on_trigger(lambda _: self.uses.append("key"))
        self.gizmo.on_update(lambda _: self.uses.append(tuple(self.gizmo.position)))
        self.ball.on_click(lambda _: self.uses.append("ball"))
        client.scene.on_click()(lambda _: self.uses.append("scene"))

    def id_of(self, name):
        return getattr(self, name)._impl.uuid


class Hand:
    """One browser: what it says, and what it is told."""

    def __init__(self, connection, made):
        self.connection, self.made = connection, made
        self.told = []

    async def say(self, kind, **fields):
        await self.connection.send(msgspec.msgpack.encode({"type": kind, **fields}))

    async def set(self, name, value):
        await self.say("GuiUpdateMessage", uuid=self.made.id_of(name), updates={"value": value})

    async def is_told(self, kind, **fields):
        """Wait for a message with these fields."""
        async with asyncio.timeout(PATIENCE):
            while True:
                for message in unpack(await self.connection.recv()):
                    if message["type"] == kind and fields.items() <= message.items():
                        return message

    async def is_shown(self, name, value):
        """Wait until the browser is told a value of a widget."""
        uuid = self.made.id_of(name)
        return await self.is_told("GuiUpdateMessage", uuid=uuid, updates={"value": value})

    async def uses(self, *uses):
        """Wait until the widgets were used so, and not otherwise."""
        await asyncio.to_thread(wait_until, lambda: len(self.made.uses) >= len(uses))
        assert self.made.uses == [*uses]


def run(scenario):
    return asyncio.run(asyncio.wait_for(scenario, 2 * PATIENCE))
