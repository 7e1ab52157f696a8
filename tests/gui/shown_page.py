"""What a browser was shown, by what came over the wire; and messages that this page has, or not."""

import math
import random
from dataclasses import dataclass, field
from typing import Any

BUTTON, FILE = "GuiButtonMessage", "GuiUploadButtonMessage"
CHOICE, TEXT, CHECK = "GuiDropdownMessage", "GuiTextMessage", "GuiCheckboxMessage"
NUMBER, SLIDER, VECTOR = "GuiNumberMessage", "GuiSliderMessage", "GuiVector3Message"
BAR, KEY = "GuiProgressBarMessage", "RegisterCommandMessage"
USED = (BUTTON, FILE, CHOICE, TEXT, CHECK, NUMBER, SLIDER, VECTOR)

TEXTS = (
    *("", "a\0b", "\0", "../../etc/passwd", "/etc/shadow", "\x1b[31m", "nan", "1e400", "-"),
    *("\u202egnp.exe", "'; DROP TABLE", "<script>alert(1)</script>", "ü" * 1001, "x" * 19_000),
)
NO_CHOICES = (*TEXTS, None, 0, True, [], ["-"])
NO_NUMBERS = (*TEXTS, None, True, False, [], [1, 2], ["a", "b", "c"])
WRONG = {
    BUTTON: (False, 1, "True", None, []),
    CHECK: (0, 1, "True", None, []),
    TEXT: ("a\0b", "\x1b[31m", "\u202egnp.exe", "ü" * 1001, None, True, 1, ["a"]),
}
NO_FRAMES = (math.nan, math.inf, -math.inf, {"a": 1}, b"\0", [[0]], 2**60, "x" * 30_000, [0] * 300)
"""Values that the front drops before they come to a widget."""

FILES = ("a\0b.stl", "../../x.zip", "/etc/passwd", "", "..", "a\nb.step", "n" * 300, "a\\b.obj")
"""Names that no file has."""

TYPED = "ab12 -_."


@dataclass
class Widget:
    """One thing that was shown."""

    kind: str
    inside: str
    shape: dict[str, Any]
    value: Any


@dataclass
class ShownPage:
    """All that is shown in one browser now."""

    widgets: dict[str, Widget] = field(default_factory=dict)
    around: dict[str, Widget] = field(default_factory=dict)
    gizmos: dict[str, str] = field(default_factory=dict)

    def learn(self, message: dict[str, Any]) -> None:
        """Take note of one message from the server."""
        uuid, kind = message.get("uuid", ""), message["type"]
        if kind == "TransformControlsMessage":
            self.gizmos[message["name"]] = message["owner"]
        elif kind == "RemoveSceneNodeMessage":
            self.gizmos.pop(message["name"], None)
        elif kind in ("GuiRemoveMessage", "GuiCloseModalMessage"):
            self.widgets.pop(uuid, None)
        elif kind == "GuiUpdateMessage" and uuid in self.widgets:
            shown = self.widgets[uuid]
            shown.value = message["updates"].get("value", shown.value)
            shown.shape.update(message["updates"])
        elif "props" in message and uuid:
            inside = message.get("container_uuid", "root")
            shown = Widget(kind, inside, message["props"], message.get("value"))
            self.widgets[uuid] = shown
            for tab in message["props"].get("_tab_container_ids", ()):
                self.around[tab] = shown
            self.around[uuid] = shown
        for tab in message.get("updates", {}).get("_tab_container_ids", ()):
            self.around[tab] = self.around[uuid]

    def is_offered(self, uuid: str) -> bool:
        """Whether a person could use a widget."""
        shown = self.widgets[uuid]
        if shown.kind == KEY:
            return not shown.shape["disabled"]
        is_seen = shown.shape["visible"]
        around = self.around.get(shown.inside)
        while around is not None and is_seen:
            is_seen = around.shape.get("visible", True)
            around = self.around.get(around.inside)
        return is_seen and not shown.shape["disabled"]

    def labelled(self, label: str) -> str | None:
        """The id of a widget that can be used, by what stands beside it."""
        for uuid, shown in self.widgets.items():
            if shown.shape.get("label") == label and shown.kind in USED and self.is_offered(uuid):
                return uuid
        return None

    def of(self, *kinds: str) -> list[str]:
        """The ids of all widgets of some kinds."""
        return [uuid for uuid, shown in self.widgets.items() if shown.kind in kinds]

    def right(self, rng: random.Random, uuid: str) -> Any:
        """A value that a widget offers."""
        kind, shape = self.widgets[uuid].kind, self.widgets[uuid].shape
        if kind == CHOICE:
            return rng.choice(shape["options"])
        if kind == TEXT:
            return "".join(rng.choice(TYPED) for _ in range(rng.randrange(12)))
        if kind in (NUMBER, SLIDER):
            return _number(rng, shape)
        if kind == VECTOR:
            return [_number(rng, {**shape, "min": None, "max": None}) for _ in range(3)]
        return kind == BUTTON or rng.random() < 0.5

    def wrong(self, rng: random.Random, uuid: str) -> Any:
        """A value that a widget does not offer, of those that may come to it."""
        kind, shape = self.widgets[uuid].kind, self.widgets[uuid].shape
        if kind == CHOICE:
            return rng.choice([one for one in NO_CHOICES if one not in shape["options"]])
        if kind == VECTOR:
            broken: list[Any] = [0.0, 0.0, 0.0]
            broken[rng.randrange(3)] = _no_number(rng, shape)
            return rng.choice((broken, broken[:2], [*broken, 0.0], 0.0, "0,0,0", None))
        if kind in (NUMBER, SLIDER):
            return _no_number(rng, shape)
        return rng.choice(WRONG.get(kind, (True, 0.5, "x", None)))


def _number(rng: random.Random, shape: dict[str, Any]) -> float:
    low = -100.0 if shape["min"] is None else shape["min"]
    high = low + 200.0 if shape["max"] is None else shape["max"]
    number = round(low + rng.random() * (high - low), shape["precision"])
    return min(max(number, low), high)


def _no_number(rng: random.Random, shape: dict[str, Any]) -> Any:
    found = [1 / 3 * 10.0 ** -(shape["precision"] + 1)]
    for bound, way in ((shape["min"], -1), (shape["max"], 1)):
        if isinstance(bound, int | float):
            found.append(bound + way * (1 + abs(bound)))
    return rng.choice((*NO_NUMBERS, *found * 4))
