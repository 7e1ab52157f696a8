"""What a browser may say to viser: which messages, with which fields, by which role.

viser 1.1.1 sets any attribute of a widget that a message names, takes any number, and opens a
public tunnel when asked to.  So only the messages that our page uses pass, each read into the
exact form below and written anew: what was checked is what viser sees.  Here a value only has to
be one; whether the page offers it is asked where the page is made (`gui/incoming/gate.py`).

A message of the page that is not here is refused: add it when the page begins to use it.
"""

from typing import Annotated, Any, Literal, TypeAlias

import msgspec
from msgspec import Meta, Struct

from workbench.app.core.people import Role

Length = Annotated[float, Meta(ge=-1e5, le=1e5)]
"""[m]; also what has no unit.  The part that grasps are edited on stands 1 km above the cell.

Bounds keep out what is no number, too: it is not greater or smaller than anything."""

Distance = Annotated[float, Meta(ge=-1e7, le=1e7)]
"""[m], of cameras, which people zoom out."""

Number = Annotated[float, Meta(ge=-1e12, le=1e12)]
Whole = Annotated[int, Meta(ge=-(2**53), le=2**53)]
Word = Annotated[str, Meta(max_length=200)]
Text = Annotated[str, Meta(max_length=20_000)]
Scalar: TypeAlias = bool | Whole | Number | Text | None
Row = Annotated[list[Scalar], Meta(max_length=200)]
Value: TypeAlias = bool | Whole | Number | Text | Row | None
Point: TypeAlias = tuple[Length, Length, Length]
Far: TypeAlias = tuple[Distance, Distance, Distance]
Turn: TypeAlias = tuple[Length, Length, Length, Length]
Pixel: TypeAlias = tuple[Length, Length]
Pixels = Annotated[int, Meta(ge=0, le=100_000)]


class BrowserMessage(Struct, tag_field="type", tag=True, forbid_unknown_fields=True, frozen=True):
    """One message from a browser; the tag is viser's name of it."""


class ViewerCameraMessage(BrowserMessage, frozen=True):
    """From where this browser looks."""

    wxyz: Turn
    position: Far
    fov: Length
    near: Distance
    far: Distance
    image_height: Pixels
    image_width: Pixels
    look_at: Far
    up_direction: Far


class ScenePointerMessage(BrowserMessage, frozen=True):
    """A click into the scene, or a box drawn over it."""

    event_type: Literal["click", "rect-select"]
    ray_origin: Far | None
    ray_direction: Point | None
    screen_pos: Annotated[list[Pixel], Meta(max_length=2)]
    modifier: Word | None = None


class SceneNodeClickMessage(BrowserMessage, frozen=True):
    """A click on one thing in the scene."""

    name: Word
    instance_index: Whole | None
    ray_origin: Far
    ray_direction: Point
    screen_pos: Pixel
    modifier: Word | None = None
    owner: Word = ""


class Updates(Struct, forbid_unknown_fields=True, frozen=True):
    """What of a widget a browser may set: its value and nothing else."""

    value: Value


class GuiUpdateMessage(BrowserMessage, frozen=True):
    """A widget was used; the id leads nowhere but among the widgets of the same browser."""

    uuid: Word
    updates: Updates


class CommandTriggerMessage(BrowserMessage, frozen=True):
    """A key, or a line of the list behind Ctrl+K."""

    uuid: Word


class TransformControlsUpdateMessage(BrowserMessage, frozen=True):
    """A gizmo is dragged."""

    name: Word
    wxyz: Turn
    position: Point
    owner: Word = ""


class TransformControlsDragStartMessage(BrowserMessage, frozen=True):
    """A gizmo is taken."""

    name: Word
    owner: Word = ""


class TransformControlsDragEndMessage(BrowserMessage, frozen=True):
    """A gizmo is let go."""

    name: Word
    owner: Word = ""


class FileTransferStartUpload(BrowserMessage, frozen=True):
    """A file will come, of this many bytes, in this many parts."""

    source_component_uuid: Word
    transfer_uuid: Word
    filename: Annotated[str, Meta(max_length=1000)]
    mime_type: Word
    part_count: Annotated[int, Meta(ge=0, le=100_000)]
    size_bytes: Annotated[int, Meta(ge=0, le=2**53)]


class FileTransferPart(BrowserMessage, frozen=True):
    """A part of a file."""

    source_component_uuid: Word
    transfer_uuid: Word
    part_index: Annotated[int, Meta(ge=0, le=100_000)]
    content: bytes


class GetRenderResponseMessage(BrowserMessage, frozen=True):
    """The browser has drawn what it was sent; the picture is small, and nobody looks at it."""

    payload: Annotated[bytes, Meta(max_length=100_000)]
    render_uuid: Word


Looking: TypeAlias = (
    ViewerCameraMessage
    | ScenePointerMessage
    | SceneNodeClickMessage
    | GuiUpdateMessage
    | CommandTriggerMessage
)
Working: TypeAlias = (
    Looking
    | TransformControlsUpdateMessage
    | TransformControlsDragStartMessage
    | TransformControlsDragEndMessage
    | FileTransferStartUpload
    | FileTransferPart
    | GetRenderResponseMessage
)

_DECODERS: dict[Role, msgspec.msgpack.Decoder[Any]] = {
    Role.VIEWER: msgspec.msgpack.Decoder(Looking),
    Role.OPERATOR: msgspec.msgpack.Decoder(Working),
    Role.ENGINEER: msgspec.msgpack.Decoder(Working),
}
_ENCODER = msgspec.msgpack.Encoder()


def read(frame: bytes, role: Role) -> Working:
    """The message in a frame from the browser of somebody with this role.

    Raises:
        ValueError: it is none, not one that this role may send, or has a field or value that it
            must not have; says which.
    """
    try:
        return _DECODERS[role].decode(frame)
    except RecursionError as error:
        raise ValueError("the message is nested too deeply") from error


def write_frame(message: BrowserMessage) -> bytes:
    """The frame for viser."""
    return _ENCODER.encode(message)


def is_press(message: BrowserMessage) -> bool:
    """Whether each such message counts, not only the newest: buttons, keys, ends of a drag."""
    match message:
        case GuiUpdateMessage(updates=Updates(value=value)):
            return value is True
        case ViewerCameraMessage() | TransformControlsUpdateMessage():
            return False
        case _:
            return True


def subject(message: BrowserMessage) -> tuple[str, str]:
    """What a message is about: of two about the same, the newer one makes the older worthless."""
    match message:
        case GuiUpdateMessage(uuid=uuid):
            return ("widget", uuid)
        case TransformControlsUpdateMessage(name=name, owner=owner):
            return ("gizmo", f"{owner} {name}")
        case _:
            return (type(message).__name__, "")
