"""Facts computed for a command from scan and robot, since `decide` itself computes none."""

import functools
from collections.abc import Sequence
from dataclasses import replace

from workbench.app.core.after_a_miss import is_sure
from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.command import Command, refuse_input
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.state import Phase, State
from workbench.app.picking.pile_check import check_pile, with_kinds
from workbench.app.picking.sightlines import sees_from
from workbench.app.picking.stations import put_down
from workbench.model.calibration import BinCheck
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.part import Bin
from workbench.model.plan import Plan, Proof, Proven
from workbench.model.scan import Scan
from workbench.perception.bins.bin_check import check_bin
from workbench.plugins.planner import planner_named
from workbench.proof.claims.moved import moved_parts
from workbench.proof.claims.spot import Spot, spot_of


def bin_check_of(state: State) -> BinCheck | None:
    """The check of the bin by the state's scan; None without a scan."""
    return None if state.scan is None else _check_bin(state.scan, state.cell.bin)


# It takes some 10 ms, and is asked for at every drawing.
@functools.lru_cache(maxsize=2)
def _check_bin(scan: Scan, bin: Bin) -> BinCheck:
    return check_bin(scan, bin)


# It takes some 10 ms, and is asked for in every browser.
@functools.lru_cache(maxsize=2)
def nearest_place(cell: Cell, plan: Plan, proof: Proof) -> Spot | None:
    """Place of the smallest clearance on the plan's free legs; None if it is not small."""
    try:
        return None if proof.nearest is None else spot_of(cell, plan, proof.nearest)
    except InputError:
        # A recorded plan, and a cell that has no such part any more.
        return None


def nearest_of(row: Sequence[Proven]) -> int:
    """Index of the plan with the smallest clearance of a row."""
    return min(range(len(row)), key=lambda number: row[number].proof.clearance)


def with_facts(state: State, command: Command) -> Command:
    """A command with the facts that it needs, computed from it and the state.

    Args:
        state: before the command.
        command: as received, or as recorded by an older version.
    """
    if isinstance(command, LinkEnded) and state.plan is not None:
        if command.placed is None:
            command = replace(command, placed=put_down(state.cell, state.plan))
        if command.may_have_moved is None and is_sure(state, command):
            grasped = [arm.detection for arm in state.plan.picks]
            parts, disturbed = state.plan.detections, state.disturbed
            moved = moved_parts(state.cell, parts, grasped, disturbed)
            command = replace(command, may_have_moved=moved and tuple(sorted(moved)))
        return command
    if isinstance(command, GoOn) and state.phase is Phase.SENDING and command.sees_from is None:
        last = state.plans[-1]
        placed = put_down(state.cell, last)
        return replace(command, sees_from=sees_from(state.cell, last), placed=placed)
    return command


def check_installed(state: State, command: Command) -> None:
    """Check that a command's needs are met: the planner can be loaded, the pile fits.

    This is no rule: a session can be replayed on an installation with fewer packages.

    Raises:
        CommandRefused: they are not; the message states what is available.
    """
    command = command.plan if isinstance(command, GoOn) else command
    with refuse_input():
        match command:
            case MakePlan(overrides=overrides):
                planner_named(overrides.on(state.cell.policy).planner)
            case TryEmptying(kinds=kinds, count=count):
                check_pile(with_kinds(state.cell, kinds), count)
            case _:
                pass
