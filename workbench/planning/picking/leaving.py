"""How a hand leaves the part it has let go of, and what it meets of other placed parts."""

from dataclasses import replace

import numpy as np

from workbench.model.cell import Arm
from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.motion import arm_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World

CLOSING = 0.001
"""[m] Step of checks while fingers close; fingers are thicker."""

SPARE_MARGIN = 0.0005
"""[m] Distance beyond the margin from which on a hand has left a part.  Fingers slide along parts
at a distance that may just be the margin."""


def along_placed(world: World, arm: str, path: Floats) -> tuple[Contact, Floats] | None:
    """The first part placed by another arm that an arm meets on a path, in this phase.

    Args:
        world: in the phase of the leg.
        arm: its name.
        path: (m, n) [rad] waypoints.

    Returns:
        What meets what, and the arm's configuration (n,) [rad] there.
    """
    among = world.pairs.to_placed(arm)
    if len(among) == 0:
        return None
    found = arm_contact(world, arm, path, among)
    return None if found is None else found[:2]


def find_contact_after_release(
    world: World, arm: str, path: Floats
) -> tuple[Contact, Floats, int] | None:
    """Where a hand violates the margin to the part it has let go of, or never leaves it.

    From the first waypoint on at which the hand has left the part it keeps the full margin; until
    then `World.allow_start_contacts` applies.  An arm that does not move at all, since its place is
    at home, stays as near as it is.

    Args:
        world: in the phase of the leg.
        arm: name of the arm that has let go of the part.
        path: waypoints (m, n) [rad].

    Returns:
        As `motion.chain_contact`.
    """
    pairs = world.pairs.left_behind(arm)
    if len(pairs) == 0 or not np.diff(path, axis=0).any():
        return None
    number, contact = _first_clear(world, pairs, arm, path)
    if number == len(path) - 1:
        return None if contact is None else (contact, path[-1], len(path) - 2)
    with world.at_full_margins():
        found = arm_contact(world, arm, path[number:], pairs)
    return None if found is None else (found[0], found[1], found[2] + number)


def is_around(world: World, arm: Arm, phase: LegPhase, q: Floats) -> bool:
    """Whether fingers that closed at `q` (n,) [rad] would meet the part they have let go of.

    However wide they are open, the hand has not left it then.

    Args:
        world: is put into the phase, with the fingers anywhere.
        arm: that has let go of something.
        phase: in which it goes away.
        q: see there.
    """
    opening, whole = phase.openings[arm.name], world.configuration({arm.name: q})
    while arm.tool.fingers and opening > 0.0:
        world.enter(replace(phase, openings={**phase.openings, arm.name: opening}))
        distance = world.nearest(whole, world.pairs.left_behind(arm.name)).distance
        if distance <= 0.0:
            return True
        # Each finger moves by half of that.
        opening -= max(2 * distance, CLOSING)
    return False


def _first_clear(world: World, pairs: Ints, arm: str, path: Floats) -> tuple[int, Contact | None]:
    """The first waypoint with pairs clear by `SPARE_MARGIN`; else the last, with its contact."""
    contact = None
    with world.at_full_margins(SPARE_MARGIN):
        for number, q in enumerate(path):
            contact = world.contact(world.configuration({arm: q}), pairs)
            if contact is None:
                return number, None
    return len(path) - 1, contact
