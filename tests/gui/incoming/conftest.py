"""Browsers without a screen, each with one widget of each kind."""

import asyncio
import contextlib
import threading

import pytest
from few_widgets import Hand, Made
from raw_browser import raw_browser
from waiting import PATIENCE

from workbench.gui.shared.viser_server import close_viser, open_viser


@pytest.fixture
def server():
    server = open_viser("127.0.0.1", 0)
    server.speaks = False
    yield server
    close_viser(server)


@pytest.fixture
def hands(server):
    """Opens browsers whose widgets have been made."""
    made, arrived = {}, threading.Condition()

    @server.on_client_connect
    def _(client):
        with arrived:
            made[client.client_id] = Made(client)
            arrived.notify_all()

    @contextlib.asynccontextmanager
    async def open_one():
        before = len(made)

        def wait():
            with arrived:
                arrived.wait_for(lambda: len(made) > before, PATIENCE)

        async with raw_browser(server.get_port()) as connection:
            await asyncio.to_thread(wait)
            yield Hand(connection, made[max(made)])

    return open_one
