"""What passes from a browser to viser, told without sockets."""

import msgspec
import pytest
from viser import _messages as theirs

from workbench.app.core.people import Role
from workbench.studies.load.raw_browser import CAMERA
from workbench.web.page import messages
from workbench.web.page.messages import (
    CommandTriggerMessage,
    GuiUpdateMessage,
    Updates,
    is_press,
    read,
    subject,
    write_frame,
)

POINT, TURN = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
LOOKING = [
    {"type": "ViewerCameraMessage", **CAMERA},
    {
        "type": "ScenePointerMessage",
        "event_type": "rect-select",
        "ray_origin": None,
        "ray_direction": None,
        "screen_pos": ((0.0, 0.0), (1.0, 1.0)),
        "modifier": None,
    },
    {
        "type": "SceneNodeClickMessage",
        "name": "/part",
        "instance_index": None,
        "ray_origin": POINT,
        "ray_direction": POINT,
        "screen_pos": (0.5, 0.5),
        "modifier": "shift",
        "owner": "",
    },
    {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": "text"}},
    {"type": "CommandTriggerMessage", "uuid": "a"},
]
WORKING = [
    {
        "type": "TransformControlsUpdateMessage",
        "name": "/gizmo",
        "wxyz": TURN,
        "position": POINT,
        "owner": "client_1",
    },
    {"type": "TransformControlsDragStartMessage", "name": "/gizmo", "owner": ""},
    {"type": "TransformControlsDragEndMessage", "name": "/gizmo", "owner": ""},
    {
        "type": "FileTransferStartUpload",
        "source_component_uuid": "a",
        "transfer_uuid": "b",
        "filename": "scan.ply",
        "mime_type": "",
        "part_count": 1,
        "size_bytes": 3,
    },
    {
        "type": "FileTransferPart",
        "source_component_uuid": "a",
        "transfer_uuid": "b",
        "part_index": 0,
        "content": b"abc",
    },
    {"type": "GetRenderResponseMessage", "payload": b"jpeg", "render_uuid": "a"},
]


def packed(message):
    return msgspec.msgpack.encode(message)


@pytest.mark.parametrize("message", LOOKING + WORKING, ids=lambda message: message["type"])
def test_what_the_page_says_reaches_viser_as_it_was(message):
    passed = write_frame(read(packed(message), Role.ENGINEER))
    assert msgspec.msgpack.decode(passed) == msgspec.msgpack.decode(packed(message))
    # viser itself reads it, and knows all of its fields.
    assert type(theirs.Message.deserialize(passed)).__name__ == message["type"]


def test_each_role_may_say_all_that_the_one_before_may():
    for message in LOOKING:
        for role in Role:
            read(packed(message), role)
    for message in WORKING:
        read(packed(message), Role.OPERATOR)
        with pytest.raises(ValueError, match=message["type"]):
            read(packed(message), Role.VIEWER)


@pytest.mark.parametrize("message", LOOKING + WORKING, ids=lambda message: message["type"])
def test_a_field_more_or_less_is_refused(message):
    with pytest.raises(ValueError, match="unknown field"):
        read(packed({**message, "excluded_self_client": 1}), Role.ENGINEER)
    first = next(key for key in message if key != "type")
    with pytest.raises(ValueError, match="missing"):
        read(packed({key: message[key] for key in message if key != first}), Role.ENGINEER)


def test_everything_else_that_viser_listens_to_is_refused():
    ours = {message["type"] for message in LOOKING + WORKING}
    for kind in theirs.Message.get_subclasses():
        if kind.__name__ not in ours:
            with pytest.raises(ValueError):
                read(packed({"type": kind.__name__}), Role.ENGINEER)


@pytest.mark.parametrize(
    "frame",
    [
        *(b"", b"\xc1", b"\x91" * 10_000, b"\xdf\xff\xff\xff\xff", packed({"type": 1}), b"\x80"),
        b"\x82\xa1a" + b"\x91" * 300_000 + b"\xc0\xa4type\xa1x",  # nested before its type is told
    ],
    ids=lambda frame: frame[:8].hex(),
)
def test_garbage_is_a_value_error(frame):
    with pytest.raises(ValueError):
        read(frame, Role.ENGINEER)


def test_presses_are_told_from_values():
    def update(value):
        return GuiUpdateMessage("a", Updates(value))

    assert is_press(update(True))
    assert is_press(CommandTriggerMessage("a"))
    assert not is_press(update(1))
    assert not is_press(update(False))
    assert not is_press(read(packed(LOOKING[0]), Role.VIEWER))
    assert subject(update(1)) == subject(update(2)) != subject(GuiUpdateMessage("b", Updates(1)))


def test_every_role_has_its_messages():
    assert set(messages._DECODERS) == set(Role)
