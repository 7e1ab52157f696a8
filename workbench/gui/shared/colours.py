"""The colours of the page and the scene: each means one thing everywhere."""

from html import escape

from workbench.gui.shared.solids import Colour
from workbench.model.candidate import Reason

MUTED = "#868e96"
BRAND = "#1c64b4"
GOOD = "#287d38"
BAD = "#c92a2a"
BUSY = "#e67700"

VERDICTS: dict[Reason, str] = {
    Reason.OK: GOOD,
    Reason.DISABLED: MUTED,
    Reason.OUTSIDE_REGIONS: MUTED,
    Reason.ARM_NOT_ALLOWED: MUTED,
    Reason.NO_GRASP: MUTED,
    Reason.NO_GRIP: "#a61e4d",
    Reason.OUT_OF_STROKE: "#a61e4d",
    Reason.TOOL_COLLISION: "#e03131",
    Reason.ROLL_UNKNOWN: "#1864ab",
    Reason.TILTED: "#5f3dc4",
    Reason.OUT_OF_REACH: "#d1440c",
    Reason.IN_COLLISION: BAD,
    Reason.APPROACH_BLOCKED: "#b35c00",
    Reason.EXTRACT_BLOCKED: "#996b00",
    Reason.NO_PATH: "#7048e8",
    Reason.NO_RETURN: "#9c36b5",
    Reason.NO_PLACE: "#ae3ec9",
    Reason.OUT_OF_TIME: "#0b7285",
    Reason.WITHIN_MARGIN: BUSY,
}
"""Green works, grey was not asked for, wine red fits no hand, red touches; orange and ochre get
stuck on the way, violet finds none or lies tilted, cyan ran out of time, blue wants another scan;
a margin is a warning."""

BRIGHT = 0.183
"""Luminance, 0 to 1, from which white letters have a contrast below 4.5."""

VERDICT_KINDS = tuple(Reason)
"""All kinds of verdicts, in the order in which the page lists them."""


def verdict_colour(kind: Reason) -> str:
    """Of a kind of verdict."""
    return VERDICTS[kind]


def left_colour(kind: str) -> str:
    """Of a part that stays in the bin, by the word for why; grey where that is no verdict."""
    known = {str(reason): colour for reason, colour in VERDICTS.items()}
    return known.get(kind, MUTED)


PLATE: Colour = (90, 110, 200)
"""Of the balls of a calibration plate."""

JOINTS = ("#1c7ed6", "#e8590c", "#2f9e44", "#ae3ec9", "#0ca678", "#f08c00", "#e64980", "#495057")
"""Of curves, by axis: blue, orange and green come first."""

ARMS = ("#1971c2", "#c2255c")
"""By place in the cell: first and second arm."""

PART_COLOURS = (
    "#f59f00",
    "#12b886",
    "#5c7cfa",
    "#ff6b6b",
    "#9775fa",
    "#94d82d",
    "#22b8cf",
    "#f783ac",
)
"""By place among the detections, over again after the last."""

HEIGHTS = ((62, 74, 137), (38, 130, 142), (80, 180, 120), (250, 205, 70))
"""Of scanned points from the bin's floor to its rim."""

STATION = (151, 117, 250)
"""Of the surfaces on which parts stand to be taken anew."""

BESIDE_BIN = (190, 196, 204)
SKY = ("#d3deea", "#f8fafc")
NIGHT_SKY = ("#141a22", "#333d4a")
"""Behind the scene, from top to bottom: on a light page, and on a dark one."""

GRID = ("#e9ecef", "#ced4da")
NIGHT_GRID = ("#39424e", "#4b5563")
"""Of the floor, fine and coarse lines: on a light page, and on a dark one."""

AVOIDED = BAD
"""Of the boxes that a plan keeps clear of besides cell and parts, and of the points in them."""

COMPARED = (217, 70, 239)
"""Of the parts of another search."""

PLANNED_ROBOT = (77, 148, 235)
"""Of the robot as it is planned or moved by hand, see-through; the real one has its own colours."""

NOT_REPORTED = (118, 126, 134)
"""Of the solid robot where its controller does not report how it stands."""

CHECKED = (253, 150, 68)
"""Of shapes that are checked for collisions."""


def rgb_of(hexadecimal: str) -> Colour:
    """`#rrggbb` as red, green, blue, 0..255."""
    value = int(hexadecimal[1:], 16)
    return value >> 16, value >> 8 & 255, value & 255


def badge(colour: str, text: str) -> str:
    """A text on a patch of a colour `#rrggbb`, white or black, whichever is read better."""
    parts = (value / 255 for value in rgb_of(colour))
    r, g, b = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in parts)
    luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b  # relative, as WCAG 2.2 defines it
    ink = "#fff" if luminance < BRIGHT else "#111"
    return f'<span class="wb-verdict" style="background:{colour};color:{ink}">{escape(text)}</span>'


def part_colour(index: int) -> str:
    """The colour of the detection with that index."""
    return PART_COLOURS[index % len(PART_COLOURS)]


def arm_colour(index: int) -> str:
    """The colour of the arm at that place in the cell."""
    return ARMS[index % len(ARMS)]
