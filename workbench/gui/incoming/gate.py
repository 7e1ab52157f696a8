"""The one gate between a browser and viser's handles: what its page does not offer stays outside.

viser 1.1.1 takes any value for a widget, of any type, also while the widget is disabled or hidden:
what a browser draws is no bar to who writes messages himself.  Here each message is compared with
what the page of that browser offers at this moment.  What is refused is one line in the log, and
the browser gets the value that is true.
"""

# pyright: reportPrivateUsage=false

import asyncio
import base64
import json
import logging
from collections.abc import Callable
from typing import Any

import viser
from viser import _messages as messages

from workbench.gui.incoming.files import part_problem, start_problem, turn_away
from workbench.gui.incoming.rim import Rim, show_error
from workbench.gui.incoming.scene import (
    camera_problem,
    gizmo_problem,
    node_problem,
    pointer_problem,
)
from workbench.gui.incoming.values import TOO_LARGE, TOO_SMALL
from workbench.gui.incoming.widgets import (
    NOT_THERE,
    key_problem,
    use_problem,
    value_problem,
    widget_of,
)

log = logging.getLogger(__name__)

WHILE_TYPING = 3.0
"""[s] For which a number beyond its bounds may stand in its field.  Who types 15 where 10 is the
least has typed 1 before: browsers send that, and mend what is left behind themselves."""

LONGEST_TEXT = 200

PICTURE = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAP//////////////////////////////////////////////////////"
    "////////////////////////////////wAALCAABAAEBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAAA//EABQQAQAA"
    "AAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8AN//Z"
)
"""A JPEG of one pixel: what viser unpacks instead of a picture that a browser sends.

Nobody looks at it, and a few bytes may stand for a picture of gigabytes.
"""


class MessageGate:
    """The gate of one server.

    Lifetime: that of the server.

    Concurrency: viser's event loop only.
    """

    def __init__(self, server: viser.ViserServer, name_of: Callable[[int], str]):
        """Nothing is checked until `install`.

        Args:
            server: viser's.
            name_of: returns who sits at a browser, by its number.
        """
        self._server = server
        self._name_of = name_of
        self._typing: dict[tuple[int, str], asyncio.TimerHandle] = {}

    def install(self) -> None:
        """Look at all that comes from now on, from browsers that connect later."""
        server, inner = self._server, self._server._websock_server
        server._thread_executor.shutdown(wait=False)
        threads = Rim(server._thread_executor._max_workers)
        server._thread_executor = threads
        server.gui._thread_executor = server.scene._thread_executor = threads
        serve = inner._handle_incoming_message

        async def serve_all(client_id: Any, message: Any) -> None:
            # What one browser alone has is refused below, where it is told.
            if not self._problem(client_id, message):
                await serve(client_id, message)

        async def serve_arrival(connection: Any) -> None:
            serve_one = connection._handle_incoming_message

            async def take_message(client_id: Any, message: Any) -> None:
                self._forget(client_id, message)
                if problem := self._problem(client_id, message):
                    self._refuse(connection, message, problem)
                    return
                try:
                    await serve_one(client_id, message)
                except Exception as error:
                    # A rim: nobody waits for what comes of a message.
                    show_error(self._server._connected_clients.get(client_id), error)

            connection._handle_incoming_message = take_message

        async def forget_connection(connection: Any) -> None:
            for key in [key for key in self._typing if key[0] == connection.client_id]:
                self._typing.pop(key).cancel()

        inner._handle_incoming_message = serve_all
        inner._client_connect_cb.insert(0, serve_arrival)
        inner._client_disconnect_cb.append(forget_connection)

    def _problem(self, number: int, message: Any) -> str:
        """Why the page of a browser does not offer what a message says; empty when it does."""
        if isinstance(message, messages.ViewerCameraMessage):
            return camera_problem(message)
        client = self._server._connected_clients.get(number)
        if client is None:
            return NOT_THERE  # no page was made for it yet
        pages, scenes = (client.gui, self._server.gui), (client.scene, self._server.scene)
        match message:
            case messages.GuiUpdateMessage():
                return _update_problem(message, *pages)
            case messages.CommandTriggerMessage():
                return key_problem(message.uuid, *pages)
            case messages.FileTransferStartUpload():
                return start_problem(message, *pages)
            case messages.FileTransferPart():
                return part_problem(number, message, *pages)
            case (
                messages.TransformControlsUpdateMessage()
                | messages.TransformControlsDragStartMessage()
                | messages.TransformControlsDragEndMessage()
            ):
                return gizmo_problem(message, number, *scenes)
            case messages.SceneNodeClickMessage():
                return node_problem(message, *scenes)
            case messages.ScenePointerMessage():
                return pointer_problem(message, *scenes)
            case messages.GetRenderResponseMessage():
                message.payload = PICTURE
                return ""
            case _:
                return "nothing that this page says"

    def _refuse(self, connection: Any, message: Any, problem: str) -> None:
        """Tell the log, and have the browser show again what is so."""
        number = connection.client_id
        client = self._server._connected_clients.get(number)
        widget = None
        if client is not None and isinstance(message, messages.GuiUpdateMessage):
            widget = widget_of(message.uuid, client.gui, self._server.gui)
        if client is not None and isinstance(
            message, messages.FileTransferStartUpload | messages.FileTransferPart
        ):
            if turn_away(client, message):
                self._log_refusal(number, message, None, problem)
        elif widget is None:
            self._log_refusal(number, message, None, problem)
        elif problem in (TOO_SMALL, TOO_LARGE):
            self._wait(connection, message, widget, problem)
        else:
            self._log_refusal(number, message, widget, problem)
            _show_again(connection, widget)

    def _wait(self, connection: Any, message: Any, widget: Any, problem: str) -> None:
        """Show the number that is so when a person has stopped typing without one that may be."""

        def over() -> None:
            del self._typing[key]
            if not widget._impl.removed:
                self._log_refusal(key[0], message, widget, problem)
                _show_again(connection, widget)

        key = (connection.client_id, widget._impl.uuid)
        loop = asyncio.get_running_loop()
        self._typing[key] = loop.call_later(WHILE_TYPING, over)

    def _forget(self, number: int, message: Any) -> None:
        """The next value of the same field has come."""
        if isinstance(message, messages.GuiUpdateMessage):
            waiting = self._typing.pop((number, message.uuid), None)
            if waiting is not None:
                waiting.cancel()

    def _log_refusal(self, number: int, message: Any, widget: Any, problem: str) -> None:
        about = (
            getattr(message, "name", getattr(message, "uuid", ""))
            if widget is None
            else getattr(widget._impl.props, "label", "")
        )
        log.warning(
            "refused value: who=%s what=%s of=%s why=%s",
            *map(_quote, (self._name_of(number), type(message).__name__, about, problem)),
        )


def _update_problem(message: messages.GuiUpdateMessage, *pages: viser.GuiApi) -> str:
    widget = widget_of(message.uuid, *pages)
    if problem := use_problem(widget):
        return problem
    if set(message.updates) != {"value"}:
        return "nothing but a value can be set"
    return value_problem(widget, message.updates["value"])


def _show_again(connection: Any, widget: Any) -> None:
    """Have one browser show the value that is so."""
    if not widget._impl.is_button and not isinstance(widget, viser.GuiUploadButtonHandle):
        value = {"value": widget._impl.value}
        connection.queue_message(messages.GuiUpdateMessage(widget._impl.uuid, value))


def _quote(text: str) -> str:
    """As one word on one line, whatever somebody has put into it."""
    return json.dumps(text if len(text) <= LONGEST_TEXT else text[:LONGEST_TEXT] + "...")
