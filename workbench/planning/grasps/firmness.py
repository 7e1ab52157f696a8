"""Whether a grip holds a part's weight and acceleration, whichever way they pull: a wrench check.

The forces that a grip holds form a convex body.  The measure is the largest ball in it, as in
Ferrari and Canny, "Planning optimal grasps", ICRA 1992.  Here each force acts with the torque that
it causes.  For the forces of the contacts see `grip_program`.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from workbench.model.geometry import Floats
from workbench.model.messages.grasps import GripText
from workbench.model.messages.message import Message
from workbench.planning.grasps.cup import Cup
from workbench.planning.grasps.grip_program import Contacts, GripProgram, Touch
from workbench.planning.grasps.pads import PadContact

GRAVITY = 9.81
"""[m/s2]"""

RESERVE = 1.2
"""The load counts this many times: neither this model nor a stated friction is exact."""

BLOCKS = 5
"""Along each side of a pad's touch: points within a block count as one."""

LIP_POINTS = 16
"""Around a cup."""

REFINED = 4
"""Number of further directions to try, each perpendicular to the weakest facet until then."""

MOST_TIMES = 9.9
"""Times the load: more is as good."""

_FIRST = [np.array(d) / np.linalg.norm(d) for d in product((-1, 0, 1), repeat=3) if np.any(d)]
LOAD_DIRECTIONS = [d for d in _FIRST if np.count_nonzero(np.abs(d) > 1e-9) != 2]
"""Along the axes and the corners of a cube: in which the load pulls first."""


@dataclass(frozen=True, slots=True)
class Firmness:
    """How much of a load is held where it pulls in the direction that is worst.

    `share` 1.0 is just enough; `worst` (3,), unit, TCP frame, is that direction; `turns`: in line
    with the grip it would be held, so that what gives way is the torque.  `load` [N] is the weight
    and what `acceleration` [m/s2] adds to it, times `RESERVE`; `force` [N] and `friction`, no unit,
    are those of the grip, `is_cup` whether a cup holds it.
    """

    share: float
    worst: tuple[float, float, float]
    turns: bool
    load: float
    acceleration: float
    force: float
    friction: float
    is_cup: bool

    @property
    def is_enough(self) -> bool:
        """Whether the part stays as it is gripped."""
        return self.share >= 1.0


def finger_contacts(hold: PadContact, travel: Floats, force: float, friction: float) -> Contacts:
    """What two pads touch.

    Args:
        hold: what they close on.
        travel: (3,) of the first finger as it opens, TCP frame.
        force: [N] of each finger.
        friction: no unit.
    """
    touches = tuple(
        Touch(*_blocks(*patch), -normal, sense * travel)
        for patch, normal, sense in zip(hold.patches, hold.normals, (-1.0, 1.0), strict=True)
    )
    return Contacts(touches, force, friction)


def cup_contacts(cup: Cup, force: float, friction: float) -> Contacts:
    """What the lip of a cup touches, that `force` [N] of vacuum pulls the part to."""
    turns = np.arange(LIP_POINTS) * 2 * np.pi / LIP_POINTS
    ring = cup.radius * np.column_stack([np.cos(turns), np.sin(turns), np.zeros(LIP_POINTS)])
    z = np.array([0.0, 0.0, 1.0])
    touch = Touch(ring, np.full(LIP_POINTS, 1 / LIP_POINTS), z, z)
    return Contacts((touch,), force, friction, -force * z)


def firmness(contacts: Contacts, centre: Floats, mass: float, acceleration: float) -> Firmness:
    """How much of the weight and of an acceleration is held in the direction that is worst.

    Args:
        contacts: of the grip.
        centre: of mass (3,) [m], TCP frame.
        mass: [kg].
        acceleration: [m/s2] that acts on the part, in whichever direction is worst.

    Returns:
        Share 0 where the grip holds nothing at all.
    """
    load = RESERVE * mass * (GRAVITY + acceleration)
    program = GripProgram(contacts)
    radius, worst = np.inf, np.zeros(3)
    ways = list(LOAD_DIRECTIONS)
    for number in range(len(LOAD_DIRECTIONS) + REFINED):
        way = ways[number] if number < len(LOAD_DIRECTIONS) else worst
        force, side = program.most(way, centre)
        far = abs(force * float(side @ way))
        if far < radius:
            # The side faces outward, as what pulls along it is what is not held.
            radius, worst = far, side if side @ way > 0 else -side
        elif number >= len(LOAD_DIRECTIONS):
            break
    middle = np.mean([touch.points.mean(axis=0) for touch in contacts.touches], axis=0)
    return Firmness(
        share=radius / load,
        worst=(float(worst[0]), float(worst[1]), float(worst[2])),
        turns=program.most(worst, middle)[0] >= load,
        load=load,
        acceleration=acceleration,
        force=contacts.force,
        friction=contacts.friction,
        is_cup=contacts.pull is not None,
    )


def _blocks(points: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """The middles (n, 3) [m] of blocks of points (k, 3), and the weight (n,) of each."""
    low, size = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-9)
    cells = np.minimum((BLOCKS * (points - low) / size).astype(int), BLOCKS - 1)
    _, number = np.unique(cells, axis=0, return_inverse=True)
    number = number.ravel()
    whole = np.bincount(number, weights)
    sums = np.stack([np.bincount(number, weights * points[:, k]) for k in range(3)], axis=1)
    return (sums / whole[:, None]).astype(np.float64), whole.astype(np.float64)


def in_words(firmness: Firmness) -> Message:
    """The message about a grip, with the numbers that it depends on."""
    by = GripText.CONDITIONS(
        force=f"{firmness.force:g}",
        friction=f"{firmness.friction:g}",
        acceleration=firmness.acceleration,
    )
    if firmness.is_enough:
        return GripText.HOLDS(times=min(firmness.share, MOST_TIMES), conditions=by)
    # What is not enough is never reported as 1.00.
    share = float(np.floor(firmness.share * 100)) / 100
    match firmness.turns, firmness.is_cup:
        case True, False:
            text = GripText.TURNS_IN_FINGERS
        case True, True:
            text = GripText.TURNS_ON_CUP
        case False, False:
            text = GripText.SLIPS_IN_FINGERS
        case _:
            text = GripText.SLIPS_ON_CUP
    return text(share=share, conditions=by)
