"""A tool as people describe it from CAD: the mesh of its body, and by what it takes parts."""

from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import LONGEST_NAME, MB, write_upload
from workbench.formats.meshes.cad_files import CAD_ENDINGS, LARGEST_CAD
from workbench.formats.meshes.pieces.convex_pieces import hull_of, pieces_of
from workbench.formats.parts.new_part import check_name, import_mesh
from workbench.model.cell import Finger, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import (
    Box,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Solid,
    frozen,
    own,
    pose_from_rpy,
    put,
)
from workbench.model.messages.parts import DrawnText
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.work import ProgressText
from workbench.plugins.progress import Report, silent

Bytes = NDArray[np.uint8]

CLOSE_ENOUGH = 0.002
"""[m] A hull that is no more than this too large is taken as it is."""

MOST_PIECES = 8
"""Of a body that is none: every one is checked whenever the arm moves."""

LARGEST_TOOL = 1.0
"""[m] Farthest from the flange that a tool gets."""

SMALLEST_TOOL = 0.01
"""[m]"""

GREY, DARK = (0.55, 0.57, 0.6), (0.25, 0.26, 0.3)


@dataclass(frozen=True, slots=True, eq=False)
class CadDrawing:
    """A CAD file: `content` (n,) are its bytes; of no bytes there is none.

    `unit` is mm, m or inch, or empty when the file says it or only one gives the size of a tool.
    """

    file: str = ""
    content: Bytes = field(default_factory=lambda: np.zeros(0, np.uint8))
    unit: str = ""

    def __post_init__(self) -> None:
        put(self, content=frozen(self.content, np.uint8))


@dataclass(frozen=True, slots=True, eq=False)
class TwoFingers:
    """Two fingers that open along x of the drawing, each the other turned about its z.

    One is a box of `size` (3,) [m], along x, y and z, that begins at x = 0; or as in `drawing`,
    closed, on the side of x above 0 and in the frame of the body's drawing.  `stroke` is the
    largest opening [m], `force` that of each finger [N], None where nobody has said it.
    """

    size: Floats
    stroke: float
    force: float | None = None
    drawing: CadDrawing = field(default_factory=CadDrawing)

    def __post_init__(self) -> None:
        own(self, "size")


@dataclass(frozen=True, slots=True, eq=False)
class SuctionLip:
    """One suction cup on z of the drawing: `radius` and `length` [m].

    Its lip gives way by `press` [m]; `force` is that by which it pulls [N], None where nobody has
    said it.
    """

    radius: float
    length: float
    press: float = 0.003
    force: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class DrawnTool:
    """All that a tool is made of.

    The body's drawing lies in the flange's frame at `T_flange_drawing`, its z out of the flange.
    Fingers of a box, and a cup, begin at `begins` [m] on z of the drawing; None: where the body
    ends.  `is_mended`: what is open of the drawings is closed.
    """

    name: str
    body: CadDrawing
    takes_by: TwoFingers | SuctionLip
    T_flange_drawing: pin.SE3 = field(default_factory=pin.SE3.Identity)
    begins: float | None = None
    is_mended: bool = False

    def __post_init__(self) -> None:
        own(self, "T_flange_drawing")


def check_drawn(drawn: DrawnTool) -> None:
    """Look whether a tool can be meant so, without reading a drawing.

    Raises:
        InputError: says what cannot be, and what is expected.
    """
    check_name(drawn.name)
    _check_drawing(drawn.body)
    _check_length(DrawnText.DRAWING, drawn.T_flange_drawing.translation, -1000, 1000)
    if drawn.begins is not None:
        _check_length(DrawnText.BEGIN, drawn.begins, -1000, 1000)
    match drawn.takes_by:
        case TwoFingers(size=size, stroke=stroke, force=force, drawing=drawing):
            if drawing.content.size or drawing.file:
                _check_drawing(drawing)
            else:
                if np.shape(size) != (3,):
                    raise InputError(DrawnText.FINGER_SIZE())
                _check_length(DrawnText.FINGER, size, 0.5, 500)
            _check_length(DrawnText.STROKE, stroke, 0.5, 500)
        case SuctionLip(radius=radius, length=length, press=press, force=force):
            _check_length(DrawnText.CUP_RADIUS, radius, 0.5, 150)
            _check_length(DrawnText.CUP_LENGTH, length, 0.5, 500)
            _check_length(DrawnText.PRESS, press, 0, 50)
    if force is not None and not 0 < force <= 1e5:
        raise InputError(DrawnText.FORCE(value=repr(force)))


def _check_drawing(drawing: CadDrawing) -> None:
    name = drawing.file
    if PurePosixPath(name).suffix.lower() not in CAD_ENDINGS:
        raise InputError(ChangeRefusal.NO_CAD(file=repr(name[-LONGEST_NAME:]), kinds=CAD_ENDINGS))
    if not 0 < drawing.content.size <= LARGEST_CAD:
        raise InputError(
            ChangeRefusal.FILE_SIZE(
                file=name[-LONGEST_NAME:],
                bytes=f"{drawing.content.size:,}",
                most=f"{LARGEST_CAD / MB:g}",
            )
        )
    if drawing.unit not in ("", *UNITS):
        raise InputError(DrawnText.UNIT(unit=repr(drawing.unit), known=UNITS))


def _check_length(what: DrawnText, metres: Any, low_mm: float, high_mm: float) -> None:
    lengths = np.asarray(metres, np.float64) * 1000
    # Written so that what is not a number is refused, too.
    if not np.all((lengths >= low_mm) & (lengths <= high_mm)):
        raise InputError(DrawnText.LENGTH(what=what(), low=low_mm / 1000, high=high_mm / 1000))


def made_of(drawn: DrawnTool, report: Report = silent) -> Tool:
    """The tool that is described, its TCP between the finger tips or at the lip of its cup.

    The body is cut into convex pieces, a drawn finger is its hull.

    Args:
        drawn: the description.
        report: takes the share done and what is being done.

    Raises:
        InputError: see `check_drawn`; or the tool is too large or too small.
        FileError: a drawing cannot be read, or its surface is not closed.
    """
    check_drawn(drawn)
    T = drawn.T_flange_drawing
    report(0.0, ProgressText.READING_BODY())
    body = _mesh_of(drawn.body, drawn.is_mended)
    report(0.2, ProgressText.CONVEX_PIECES())
    pieces = pieces_of(body, tolerance=CLOSE_ENOUGH, most=MOST_PIECES)
    if pieces is None:
        raise InputError(DrawnText.FLAT_TOOL(file=drawn.body.file))
    solids = [
        Solid(f"body_{number}", piece, T, GREY)
        for number, piece in enumerate(pieces.pieces, start=1)
    ]
    top = float(np.asarray(body.points)[:, 2].max())
    begins = top if drawn.begins is None else drawn.begins
    report(0.8, ProgressText.FINGERS_OR_CUP())
    match drawn.takes_by:
        case SuctionLip(radius=radius, length=length, press=press, force=force):
            at = T * pose_from_rpy((0.0, 0.0, begins + length / 2))
            solids.append(Solid("cup", Cylinder(radius, length), at, DARK))
            tip = T * pose_from_rpy((0.0, 0.0, begins + length))
            tool = Tool(drawn.name, tip, tuple(solids), press=press, force=force)
        case TwoFingers(stroke=stroke, force=force) as two:
            shape, T_drawing_finger, tip_z = _finger(two, begins, drawn.is_mended)
            turned = pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, np.pi))
            fingers = tuple(
                Finger(
                    Solid(f"finger_{number}", shape, T * turn * T_drawing_finger, DARK),
                    (T * turn).rotation[:, 0],
                )
                for number, turn in enumerate((pin.SE3.Identity(), turned), start=1)
            )
            tip = T * pose_from_rpy((0.0, 0.0, tip_z))
            tool = Tool(drawn.name, tip, tuple(solids), fingers, (0.0, stroke), force=force)
    _check_size(tool)
    return tool


def _finger(two: TwoFingers, begins: float, is_mended: bool) -> tuple[Shape, pin.SE3, float]:
    """The shape of a finger, its pose in the drawing, and where its tip is on z of that."""
    if not two.drawing.content.size:
        thick, _, long = two.size
        at = pose_from_rpy((thick / 2, 0.0, begins + long / 2))
        return Box(two.size), at, begins + float(long)
    hull = hull_of(_mesh_of(two.drawing, is_mended))
    if hull is None:
        raise InputError(DrawnText.FLAT_FINGER(file=two.drawing.file))
    low, high = hull.points.min(axis=0), hull.points.max(axis=0)
    if low[0] < -CLOSE_ENOUGH:
        raise InputError(DrawnText.FINGER_SIDE(file=two.drawing.file, low=float(low[0])))
    return hull, pin.SE3.Identity(), float(high[2])


def _mesh_of(drawing: CadDrawing, is_mended: bool) -> Mesh:
    with write_upload(drawing.file, drawing.content.data) as file:
        return import_mesh(file, drawing.unit or None, repair=is_mended).mesh


def _check_size(tool: Tool) -> None:
    """Whether a hand could have the size.

    Raises:
        InputError: it could not: mostly another unit was meant.
    """
    if tool.reach > LARGEST_TOOL:
        raise InputError(DrawnText.TOO_LARGE(tool=tool.name, reach=tool.reach, most=LARGEST_TOOL))
    if tool.reach < SMALLEST_TOOL:
        raise InputError(DrawnText.TOO_SMALL(tool=tool.name, reach=tool.reach))
