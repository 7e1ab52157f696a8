"""Whether the values of a command can be used at all: finite, in range, known, near enough.

Callers have checked nothing: a value may be of any type, since browsers and programs send what
they like.
"""

from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.core.people import MACHINES
from workbench.app.core.state import State
from workbench.model.cell import MOST_PICKS, ORDER_NAMES, Cell, PlanOverrides, picks_problem
from workbench.model.errors import CommandRefused, InputError
from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.model.scan import Detection

MOST_PARTS = 30
MOST_PILES = 20
"""That are emptied in one task."""
SEED_LIMIT = 2**31
LONGEST_NAME = 80
LONGEST_TEXT = 200
FARTHEST = 20.0
"""[m] Nothing of a cell stands further from its origin."""
DETAIL = (0.3, 2.0)
"""Share of the usual detail that a search may have."""
MOST_OBSERVATIONS = 60
MOST_ITERATIONS = 100_000
LARGEST_MARGIN = 0.2
"""[m]"""


def strategies_of(cell: Cell) -> tuple[str, ...]:
    """What can be asked for in a cell: words, and its arms by name, each of which works alone.

    `auto` takes what the controller can run; `both` plans with two arms one after the other and at
    once, and compares.
    """
    arms = tuple(arm.name for arm in cell.arms)
    if len(arms) < 2:
        return ("auto", *arms)
    return ("auto", "alternated", "coordinated", *arms, "both")


def check_person(actor: str) -> None:
    """A name is that of a person, not of a machine.

    Raises:
        CommandRefused: it is not.
    """
    if not actor.strip() or len(actor) > LONGEST_NAME or not actor.isprintable():
        raise CommandRefused(
            f"a person's name is needed, 1 to {LONGEST_NAME} printable characters, not {actor!r}"
        )
    if actor in MACHINES:
        raise CommandRefused(f"{actor!r} is the name of a machine; a person has to ask for this")


def check_integer(name: str, value: Any, lowest: int, highest: int) -> None:
    """A whole number within these bounds, both included.

    Raises:
        CommandRefused: it is not.
    """
    if not isinstance(value, int) or isinstance(value, bool) or not lowest <= value <= highest:
        raise CommandRefused(
            f"{name} must be a whole number from {lowest} to {highest}, not {value!r}"
        )


def check_number(name: str, value: Any, lowest: float, highest: float, unit: str) -> None:
    """A number within these bounds, both included; NaN lies within none.

    Raises:
        CommandRefused: it is not.
    """
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not lowest <= value <= highest:
        raise CommandRefused(
            f"{name} must lie between {lowest} and {highest} {unit}, not {value!r}"
        )


def check_text(name: str, value: Any) -> None:
    """A text that is short enough to be kept and shown.

    Raises:
        CommandRefused: it is not.
    """
    if not isinstance(value, str) or len(value) > LONGEST_TEXT or not value.isprintable():
        raise CommandRefused(
            f"{name} must be a text of up to {LONGEST_TEXT} printable characters, not {value!r:.80}"
        )


def check_among(name: str, value: Any, known: tuple[str, ...]) -> None:
    """One of the names that are known.

    Raises:
        CommandRefused: it is not.
    """
    if value not in known:
        raise CommandRefused(f"{name} {value!r} is not known; there are {', '.join(known)}")


def check_overrides(cell: Cell, overrides: PlanOverrides) -> None:
    """What is wished of a planning is possible in this cell.

    Raises:
        CommandRefused: it is not.
    """
    if overrides.planner is not None:
        check_text("planner", overrides.planner)
    if overrides.order is not None:
        check_among("order", overrides.order, ORDER_NAMES)
    if overrides.iterations is not None:
        check_integer("iterations", overrides.iterations, 1, MOST_ITERATIONS)
    if overrides.margin is not None:
        check_number("margin", overrides.margin, cell.policy.margin, LARGEST_MARGIN, "m")
    if overrides.picks is not None:
        check_integer("picks", overrides.picks, 1, MOST_PICKS)
    if problem := picks_problem(overrides.on(cell.policy)):
        raise CommandRefused(problem)
    if overrides.metric is not None:
        check_number("metric", overrides.metric, 0.05, 1.0, "of the joint before")


def check_detections(cell: Cell, detections: tuple[Detection, ...]) -> None:
    """Poses from outside are of parts of this cell, and not too many.

    Raises:
        CommandRefused: they are not.
    """
    if not 1 <= len(detections) <= MOST_PARTS:
        raise CommandRefused(f"1 to {MOST_PARTS} poses are needed, not {len(detections)}")
    for number, detection in enumerate(detections, start=1):
        check_near(f"part-{number}", detection.T_world_part)
        try:
            cell.part(detection.part)
        except InputError as error:
            raise CommandRefused(str(error)) from error


def check_configuration(cell: Cell, arm: str, q: Floats) -> None:
    """An arm can stand at `q` (n,) [rad]; what a controller reports may be off by its resolution.

    Raises:
        CommandRefused: it cannot.
    """
    try:
        joints = cell.arm(arm).joints
    except InputError as error:
        raise CommandRefused(str(error)) from error
    lower, upper, _ = cell.robot.limits(joints)
    q = np.asarray(q)
    if q.shape != lower.shape or not np.all((q >= lower - 1e-3) & (q <= upper + 1e-3)):
        raise CommandRefused(f"{len(joints)} joint values within the limits of {arm} are needed")


def check_near(thing: str, T_world_thing: pin.SE3) -> None:
    """A pose is finite and lies in the room.

    Raises:
        CommandRefused: it does not.
    """
    far = float(np.abs(T_world_thing.translation).max())
    # A rotation may be no number where the place is one.
    if not far <= FARTHEST or not np.all(np.isfinite(T_world_thing.rotation)):
        raise CommandRefused(f"{thing}: {far:g} m away; {FARTHEST:g} m are allowed")


def check_cell(cell: Cell) -> None:
    """What a person moves stays in the room, and homes within the limits.

    Raises:
        CommandRefused: they do not.
    """
    check_near("bin", cell.bin.T_world_bin)
    for region in cell.bin.regions:
        check_near(f"region {region.name}", region.T_bin_region)
    check_near("scanner", cell.scanner.T_world_scanner)
    check_near("robot", cell.T_world_robot)
    for fixture in cell.fixtures:
        check_near(fixture.name, fixture.T_world_fixture)
    for arm in cell.arms:
        for T in arm.Ts_world_place:
            check_near(f"a place of the {arm.name} arm", T)
        for place in arm.part_places:
            check_near(f"a place of parts of the {arm.name} arm", place.T_world_part)
        lower, upper, _ = cell.robot.limits(arm.joints)
        if not np.all((arm.home >= lower) & (arm.home <= upper)):
            raise CommandRefused(f"the home of the {arm.name} arm lies outside its limits")


def named_plan(state: State, digest: str) -> Plan:
    """The current plan, provided that it is the one meant.

    Raises:
        CommandRefused: there is none, or it is another one.
    """
    check_text("plan", digest)
    if state.plan is None:
        raise CommandRefused("there is no plan; make a plan first")
    if state.plan.digest != digest:
        raise CommandRefused(
            f"the current plan is {state.plan.digest[:12]}, not {digest[:12]}: "
            "look at the current one and decide again"
        )
    return state.plan
