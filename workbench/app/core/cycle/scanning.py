"""Scans of the bin and of the reference plate: taken, read from a file, used."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pinocchio as pin

from workbench.app.core.cell.views import views_message
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.arm_scanner import (
    plate_problem,
    scan_problem,
    standing_joints,
    view_problem,
)
from workbench.app.core.hands import Taken, arms_that_may_hold, parts_taken_last
from workbench.app.core.people import Role
from workbench.app.core.picks import Avoided, SimulatedPile
from workbench.app.core.state import (
    Phase,
    ScanState,
    State,
    begin_stage,
    sent_for,
    stale_by,
)
from workbench.app.core.tasks import Begun, begin_task
from workbench.app.core.value_checks import (
    MOST_OBSERVATIONS,
    MOST_PARTS,
    SEED_LIMIT,
    check_among,
    check_configuration,
    check_integer,
    check_says,
    check_text,
)
from workbench.model.calibration import BallPlate, PlateObservation
from workbench.model.cell import Cell
from workbench.model.digest import LATER, called
from workbench.model.errors import CommandRefused
from workbench.model.geometry import Floats, frozen, put
from workbench.model.messages.commands import CommandText, StaleText
from workbench.model.messages.message import Message, all_of
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.states import StateText
from workbench.model.release import PickResult
from workbench.model.scan import ALL_KINDS, Scan

if TYPE_CHECKING:
    from workbench.app.core.cycle.ahead import GoOn

USUAL_PARTS = 2
"""In a simulated pile, where nobody states a number."""

SAME_POSE_WITHIN = 0.02
"""[rad, m] Joints nearer to each other than this are those of one pose of the plate."""


@dataclass(frozen=True, slots=True, eq=False)
class TakeScan(Command):
    """Trigger the scanner.  `seed`, `parts` and `part` shape the simulated pile; 0 parts: none.

    `part` is which kind falls, of those that the cell picks; "all": one of each in turn; empty:
    what kits consist of, or the first.  With `stays` the parts that are left of the same pile stay
    where they are, as long as some are left; otherwise the pile falls anew.
    """

    right: ClassVar[Right] = Right(CommandText.TAKE_SCAN, SAFE)

    seed: int = 0
    parts: int = USUAL_PARTS
    part: str = ""
    stays: bool = field(default_factory=bool, metadata=LATER)

    def check(self, state: State, asked: Asked) -> None:
        check_scan(state.cell, self)
        refuse(view_problem(state.cell, standing_joints(state.cell, asked.joints)))

    def apply(self, state: State, entry: Entry) -> Decision:
        return take_scan(state, entry, self)


@dataclass(frozen=True, slots=True, eq=False)
class UseScan(Command):
    """Take a scan from a file instead of the scanner."""

    right: ClassVar[Right] = Right(CommandText.USE_SCAN, SAFE)

    scan: Scan

    def check(self, state: State, asked: Asked) -> None:
        joints = standing_joints(state.cell, asked.joints)
        refuse(scan_problem(state.cell, self.scan, joints))

    def apply(self, state: State, entry: Entry) -> Decision:
        return with_scan(state, self.scan, entry.at), ()


@dataclass(frozen=True, slots=True, eq=False)
class SightPlate(Command):
    """Scan the reference plate while an arm stands at `q` (n,) [rad], chain order.

    The arm holds the plate, or carries the scanner.  `seed` is that of the simulated scanner's
    noise.
    """

    right: ClassVar[Right] = Right(CommandText.SIGHT_PLATE, SAFE, role=Role.ENGINEER)

    arm: str
    q: Floats
    plate: BallPlate
    seed: int = 0

    def __post_init__(self) -> None:
        put(self, q=frozen(self.q))

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        check_configuration(state.cell, self.arm, self.q)
        refuse(plate_problem(state.cell, self.arm, self.q, asked.joints))
        if len(state.observations) >= MOST_OBSERVATIONS:
            raise CommandRefused(ChangeRefusal.MOST_POSES_TAKEN(most=MOST_OBSERVATIONS))
        for other in state.observations:
            is_alike = other.is_used and other.arm == self.arm and other.q.shape == self.q.shape
            if is_alike and np.abs(other.q - self.q).max() < SAME_POSE_WITHIN:
                raise CommandRefused(ChangeRefusal.SAME_POSE(arm=self.arm, pose=other.name))

    def apply(self, state: State, entry: Entry) -> Decision:
        return sight_plate(state, entry, self)


@dataclass(frozen=True, slots=True, eq=False)
class UseObservations(Command):
    """Go on with these observations of the plate, some left out; `says` states so for people."""

    right: ClassVar[Right] = Right(CommandText.USE_OBSERVATIONS, SAFE, role=Role.ENGINEER)

    observations: tuple[PlateObservation, ...] = field(metadata=called("sightings"))
    says: Message | str

    def check(self, state: State, asked: Asked) -> None:
        check_says("says", self.says)
        if len(self.observations) > MOST_OBSERVATIONS:
            raise CommandRefused(ChangeRefusal.MOST_POSES(most=MOST_OBSERVATIONS))
        for observation in self.observations:
            check_text("name", observation.name)
            check_configuration(state.cell, observation.arm, observation.q)

    def apply(self, state: State, entry: Entry) -> Decision:
        return replace(state, observations=self.observations, message=self.says), ()


def check_scan(cell: Cell, command: TakeScan) -> None:
    """The scan can be taken in this cell.

    Raises:
        CommandRefused: it cannot.
    """
    check_among("part", command.part, ("", ALL_KINDS, *(part.name for part in cell.parts)))
    check_integer("seed", command.seed, 0, SEED_LIMIT - 1)
    check_integer("parts", command.parts, 0, MOST_PARTS)


def take_scan(
    state: State,
    entry: Entry,
    command: TakeScan,
    then: "GoOn | None" = None,
) -> Begun:
    """The scanner is triggered; with `then` the next steps of a cycle follow the scan."""
    arguments: dict[str, Any] = {
        "seed": command.seed,
        "parts": command.parts,
        "part": command.part,
    }
    pile = next_pile(state, command) if command.stays else None
    if pile is not None and pile.lifted:
        arguments["lifted"] = pile.lifted
    if state.cell.scanner.on_arm is not None:
        arguments["joints"] = standing_joints(state.cell, entry.joints)
    if state.earlier is not None:
        arguments["earlier"] = state.earlier
    return begin_task(state, entry, "scan", arguments, StateText.SCANNING(), then=then, pile=pile)


def next_pile(state: State, command: TakeScan) -> SimulatedPile | None:
    """The pile that a scan shows whose parts stay; None where no scanner is simulated.

    Once all parts were taken, the same pile falls again.
    """
    if state.cell.scanner.source != "simulated":
        return None
    return left_pile(state, command) or _fresh_pile(state, command)


def scan_of_pile(state: State, parts: int | None = None, *, drops_new: bool = False) -> TakeScan:
    """A scan as programs ask for it that name no seed: what is left of the pile, or new parts.

    Args:
        state: with the pile that the last scan has shown.
        parts: in a simulated pile; None: as many as it had, `USUAL_PARTS` at first.
        drops_new: new parts fall, whatever is left.
    """
    pile = state.pile
    if parts is None:
        parts = USUAL_PARTS if pile is None else pile.parts
    if pile is not None and not drops_new:
        again = TakeScan(pile.seed, parts, pile.part, stays=True)
        if left_pile(state, again) is not None:
            return again
    return TakeScan(state.number, parts, stays=True)


def left_pile(state: State, command: TakeScan) -> SimulatedPile | None:
    """The remaining pile that a scan requests; None: a new pile falls."""
    known, fresh = state.pile, _fresh_pile(state, command)
    if known is None or known.name != fresh.name:
        return None
    left = replace(known, lifted=(*known.lifted, *_lifted_since(state)))
    return left if left.left > 0 else None


def _fresh_pile(state: State, command: TakeScan) -> SimulatedPile:
    return SimulatedPile(command.seed, command.parts, command.part, state.cell.bin.name)


def _lifted_since(state: State) -> tuple[pin.SE3, ...]:
    """Poses `T_world_part` of the parts that were taken since the last scan.

    Without a report a part counts as picked, except after a fault.  Parts that an arm has dropped
    back after a fault are in the bin.
    """
    sent = sent_for(state)
    if sent is None:
        return ()
    return tuple(
        sent.plans[0].detections[taken.number].T_world_part
        for taken in parts_taken_last(state)
        if _is_out(state, taken)
    )


def _is_out(state: State, taken: Taken) -> bool:
    """Whether a part of a simulated pile has left the bin."""
    is_taken = taken.is_over or state.phase is Phase.SENDING
    if taken.outcome is None:
        return is_taken
    was_let_go = taken.arm in state.hands_emptied
    return taken.outcome.became is not PickResult.FAILED and (is_taken or not was_let_go)


def with_scan(state: State, scan: Scan, at: float) -> State:
    """The state with a new scan, taken at [s since the epoch]."""
    scanned = StateText.SCANNED(points=f"{len(scan.points):,}")
    return begin_stage(
        replace(
            state,
            avoided=_after_one_more_scan(state, at),
            unscanned=None,
            earlier=None,
            hands_open=tuple(sorted(arms_that_may_hold(state))),
        ),
        ScanState,
        phase=Phase.SCANNED,
        scan=scan,
        scene_digest=scan.digest,
        stale=None if state.phase is Phase.DONE else stale_by(state, StaleText.NEWER_SCAN()),
        message=all_of((scanned, views_message(replace(state, scan=scan)))),
    )


def _after_one_more_scan(state: State, at: float) -> tuple[Avoided, ...]:
    """The places still avoided after a new scan of the chosen bin at a time [s since the epoch]."""
    now = [
        replace(entry, scans=entry.scans - (entry.bin == state.cell.bin.name))
        for entry in state.avoided
    ]
    return tuple(entry for entry in now if entry.scans >= 0 and at < entry.until)


def sight_plate(state: State, entry: Entry, command: SightPlate) -> Begun:
    """The plate is scanned in one more pose."""
    numbers = (observation.name.rpartition(" ")[2] for observation in state.observations)
    last = max((int(number) for number in numbers if number.isdecimal()), default=0)
    arguments = {
        "name": f"pose {last + 1}",
        "arm": command.arm,
        "q": command.q,
        "plate": command.plate,
        "seed": command.seed,
    }
    return begin_task(state, entry, "sight", arguments, StateText.SCANNING_PLATE())
