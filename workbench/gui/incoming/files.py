"""Files that a browser sends: to which button, under which name, and how one is turned away."""

# pyright: reportPrivateUsage=false

from typing import Any

import viser
from viser import _messages as messages

from workbench.gui.incoming.refusals import FILE_REFUSED, REFUSED, SECONDS_TO_READ
from workbench.gui.incoming.values import is_no_sign
from workbench.gui.incoming.widgets import NOT_THERE, use_problem, widget_of

LONGEST_NAME = 255
"""[bytes] Of a file: no system keeps more."""


def start_problem(message: messages.FileTransferStartUpload, *pages: viser.GuiApi) -> str:
    """Why no file is taken that a browser announces; empty when it is."""
    widget = widget_of(message.source_component_uuid, *pages)
    return use_problem(widget) or file_problem(widget, message.filename)


def file_problem(widget: Any, name: str) -> str:
    """Why a widget does not take a file of this name; empty when it does."""
    if not isinstance(widget, viser.GuiUploadButtonHandle):
        return "no button for files"
    if not name.strip(" .") or len(name.encode()) > LONGEST_NAME:
        return "a name that no file has"
    return "signs that no name has" if any(is_no_sign(c) or c in "/\\" for c in name) else ""


def part_problem(number: int, message: messages.FileTransferPart, *pages: viser.GuiApi) -> str:
    """Why a part of a file is not taken from a browser; empty when it is."""
    for gui in pages:
        file = gui._current_file_upload_states.get(message.transfer_uuid)
        if file is not None and file["client_id"] == number:
            return use_problem(widget_of(message.source_component_uuid or "", gui))
    return NOT_THERE


def turn_away(client: viser.ClientHandle, message: Any) -> bool:
    """Take no more of a file, and tell the person; False when nothing of it is awaited.

    Args:
        client: whose browser.
        message: that begins the file, or is a part of it.
    """
    file = client.gui._current_file_upload_states.pop(message.transfer_uuid, None)
    if isinstance(message, messages.FileTransferStartUpload):
        size = message.size_bytes
    elif file is not None:
        size = file["total_bytes"]
    else:
        return False  # the rest of one that was refused
    # Until all of it has arrived the page takes no other file there.
    client._websock_connection.queue_message(
        messages.FileTransferPartAck(
            source_component_uuid=message.source_component_uuid,
            transfer_uuid=message.transfer_uuid,
            transferred_bytes=size,
            total_bytes=size,
        )
    )
    client.add_notification(REFUSED, FILE_REFUSED, color="red", auto_close_seconds=SECONDS_TO_READ)
    return True
