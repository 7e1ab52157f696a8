"""Keys of the pick server in a cell file, and how lines and motion follow from them."""

from dataclasses import dataclass, replace
from typing import cast

from workbench.devices.pick_server.lines import ENDS, SEPARATORS, End, Form, Separator, Unit
from workbench.devices.pick_server.program import LONGEST_SEGMENT
from workbench.formats.poses.conventions import CONVENTIONS
from workbench.model.cell import Cell
from workbench.model.motion import MotionModel
from workbench.plugins.options import Options, option, options_of

MOTION = MotionModel(
    "pick-server",
    corners="stop",
    unit="deg",
    decimals=2,
    reports_progress=True,
    takes_share=True,
    takes_loads=True,
    takes_openings=True,
    keeps_hand=True,
    longest=LONGEST_SEGMENT,
    maps_axes=True,
)
"""Paths, and a stop at each waypoint."""


@dataclass(frozen=True, slots=True)
class PickOptions:
    """Keys in `[controller.options]`."""

    separator: str = option("space", among=tuple(SEPARATORS), says="between words")
    line_end: str = option("lf", among=tuple(ENDS), says="of each line")
    longest: int = option(80, low=40, high=255, says="bytes of a line with its end")
    check: bool = option(True, says="whether each line closes with its check")
    answers: str = option(
        "words", among=("words", "numbers"), says="how an answer begins after its number"
    )
    unit: str = option("deg", among=("deg", "rad"), says="of turning axes")
    digits: int = option(2, low=2, high=6, says="after the point; radians need 5")
    silence_s: float = option(
        30.0, low=1.0, high=600.0, says="without a request for longer a plan ends [s]"
    )
    ask_s: float = option(
        10.0, low=1.0, high=600.0, says="how long a plan waits to be asked for [s]"
    )
    client: str = option("", says="the robot's address, needed unless host is 127.0.0.1")
    poses: str = option(
        "none",
        among=("none", *CONVENTIONS),
        says="vision only, in this maker's format",
    )
    frame: str = option("base", among=("base", "world"), says="of poses")
    pose_of: str = option("tcp", among=("tcp", "flange"), says="whose poses")


def pick_options(cell: Cell) -> PickOptions:
    """The options of a cell.

    Raises:
        InputError: they are not right.
    """
    return options_of(PickOptions, cell.controller.options)


def form_of(cell: Cell) -> Form:
    """How the lines of a cell are written."""
    given = pick_options(cell)
    return Form(
        cast(Separator, given.separator),
        cast(End, given.line_end),
        given.longest,
        given.check,
        given.answers == "numbers",
        cast(Unit, given.unit),
        given.digits,
    )


def motion_with(options: Options) -> MotionModel:
    """How a robot program moves that gets what these options say.

    Raises:
        InputError: they are not right.
    """
    given: PickOptions = options_of(PickOptions, options)
    sends_poses = given.poses != "none"
    # A program that gets poses moves at its own speed.
    return replace(MOTION, sends_poses=sends_poses, takes_share=not sends_poses)
