"""Whether the values of a command can be used at all: finite, in range, known, near enough.

Callers have checked nothing: a value may be of any type, since browsers and programs send what
they like.
"""

from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.core.command import refuse_input
from workbench.app.core.people import MACHINES
from workbench.app.core.state import State
from workbench.model.cell import MOST_PICKS, ORDER_NAMES, Cell, PlanOverrides
from workbench.model.derived.policies import picks_problem
from workbench.model.errors import CommandRefused
from workbench.model.geometry import Floats
from workbench.model.messages.commands import NameText
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.refusals import ChangeRefusal, Refusal, ValueRefusal
from workbench.model.plan import Plan
from workbench.model.scan import Detection

MOST_PARTS = 30
MOST_PILES = 20
"""That are emptied in one task."""
SEED_LIMIT = 2**31
LONGEST_NAME = 80
LONGEST_TEXT = 200
FARTHEST_POINT = 20.0
"""[m] Nothing of a cell stands further from its origin."""
DETAIL = (0.3, 2.0)
"""Share of the usual detail that a search may have."""
MOST_OBSERVATIONS = 60
MOST_CHECKS = 30
"""Scans of balls, and touches."""
MOST_ITERATIONS = 100_000
LARGEST_MARGIN = 0.2
"""[m]"""


def check_person(actor: str) -> None:
    """A name is that of a person, not of a machine.

    Raises:
        CommandRefused: it is not.
    """
    if not actor.strip() or len(actor) > LONGEST_NAME or not actor.isprintable():
        raise CommandRefused(ValueRefusal.PERSON(most=LONGEST_NAME, value=repr(actor)))
    if actor in MACHINES:
        raise CommandRefused(ValueRefusal.MACHINE(person=repr(actor)))


def check_integer(name: str, value: Any, lowest: int, highest: int) -> None:
    """A whole number within these bounds, both included.

    Raises:
        CommandRefused: it is not.
    """
    if not isinstance(value, int) or isinstance(value, bool) or not lowest <= value <= highest:
        raise CommandRefused(
            ValueRefusal.INTEGER(name=name, lowest=lowest, highest=highest, value=repr(value))
        )


def check_number(
    name: NameText | str, value: Any, lowest: float, highest: float, unit: NameText | str = ""
) -> None:
    """A number within these bounds, both included; NaN lies within none.

    Args:
        name: what is checked, for people; a text is the name of a value in programs.
        value: that is checked.
        lowest: the least that is allowed.
        highest: the most that is allowed.
        unit: of all three; empty for a ratio.

    Raises:
        CommandRefused: it is not.
    """
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not lowest <= value <= highest:
        given = {
            "name": _name_text(name),
            "lowest": lowest,
            "highest": highest,
            "value": repr(value),
        }
        if not unit:
            raise CommandRefused(ValueRefusal.RATIO(**given))
        raise CommandRefused(ValueRefusal.NUMBER(**given, unit=_name_text(unit)))


def check_text(name: str, value: Any) -> None:
    """A text that is short enough to be kept and shown.

    Raises:
        CommandRefused: it is not.
    """
    if not isinstance(value, str) or len(value) > LONGEST_TEXT or not value.isprintable():
        raise CommandRefused(
            ValueRefusal.TEXT(name=name, most=LONGEST_TEXT, value=f"{value!r:.80}")
        )


def check_says(name: str, says: Any) -> None:
    """A remark on a change: a message, or a text that is short enough to be kept and shown.

    Raises:
        CommandRefused: it is neither.
    """
    check_text(name, str(says) if isinstance(says, Message) else says)


def check_among(name: NameText | str, value: Any, known: tuple[str, ...]) -> None:
    """One of the names that are known.

    Raises:
        CommandRefused: it is not.
    """
    if value not in known:
        raise CommandRefused(
            ValueRefusal.AMONG(name=_name_text(name), value=repr(value), known=known)
        )


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
        check_number("metric", overrides.metric, 0.05, 1.0, NameText.OF_JOINT_BEFORE)


def check_detections(cell: Cell, detections: tuple[Detection, ...]) -> None:
    """Poses from outside are of parts of this cell, and not too many.

    Raises:
        CommandRefused: they are not.
    """
    if not 1 <= len(detections) <= MOST_PARTS:
        raise CommandRefused(ValueRefusal.POSES(most=MOST_PARTS, count=len(detections)))
    for number, detection in enumerate(detections):
        check_near(FoundPart(number), detection.T_world_part)
        with refuse_input():
            cell.part(detection.part)


def check_configuration(cell: Cell, arm: str, q: Floats) -> None:
    """An arm can stand at `q` (n,) [rad]; what a controller reports may be off by its resolution.

    Raises:
        CommandRefused: it cannot.
    """
    with refuse_input():
        joints = cell.arm(arm).joints
    lower, upper, _ = cell.robot.limits(joints)
    q = np.asarray(q)
    if q.shape != lower.shape or not np.all((q >= lower - 1e-3) & (q <= upper + 1e-3)):
        raise CommandRefused(ValueRefusal.JOINTS(count=len(joints), arm=arm))


def check_near(thing: Message | FoundPart | str, T_world_thing: pin.SE3) -> None:
    """A pose is finite and lies in the room.

    Raises:
        CommandRefused: it does not.
    """
    far = float(np.abs(T_world_thing.translation).max())
    # A rotation may be no number where the place is one.
    if not far <= FARTHEST_POINT or not np.all(np.isfinite(T_world_thing.rotation)):
        raise CommandRefused(
            ValueRefusal.FAR(thing=thing, far=f"{far:g}", most=f"{FARTHEST_POINT:g}")
        )


def check_cell(cell: Cell) -> None:
    """What a person moves stays in the room, and homes within the limits.

    Raises:
        CommandRefused: they do not.
    """
    check_near(NameText.BIN(), cell.bin.T_world_bin)
    for region in cell.bin.regions:
        check_near(NameText.REGION(region=region.name), region.T_bin_region)
    check_near(NameText.SCANNER(), cell.scanner.T_world_scanner)
    check_near(NameText.ROBOT(), cell.T_world_robot)
    for fixture in cell.fixtures:
        check_near(fixture.name, fixture.T_world_fixture)
    for arm in cell.arms:
        for T in arm.Ts_world_place:
            check_near(NameText.PLACE(arm=arm.name), T)
        for place in arm.part_places:
            check_near(NameText.PART_PLACE(arm=arm.name), place.T_world_part)
        lower, upper, _ = cell.robot.limits(arm.joints)
        if not np.all((arm.home >= lower) & (arm.home <= upper)):
            raise CommandRefused(ChangeRefusal.HOME_OUTSIDE(arm=arm.name))
        carrier = cell.scanner.on_arm
        if carrier and carrier.arm == arm.name and not np.array_equal(arm.home, carrier.view.q):
            raise CommandRefused(ChangeRefusal.WAITS_AT_VIEW(arm=arm.name, view=carrier.view.name))


def _name_text(name: NameText | str) -> Message | str:
    return name() if isinstance(name, NameText) else name


def named_plan(state: State, digest: str) -> Plan:
    """The current plan, provided that it is the one meant.

    Raises:
        CommandRefused: there is none, or it is another one.
    """
    check_text("plan", digest)
    if state.plan is None:
        raise CommandRefused(Refusal.NO_PLAN())
    if state.plan.digest != digest:
        raise CommandRefused(Refusal.OTHER_PLAN(plan=state.plan.digest[:12], named=digest[:12]))
    return state.plan
