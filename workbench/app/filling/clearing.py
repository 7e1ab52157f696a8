"""A pile emptied quickly, without paths and proofs; what stays for want of a grasp adds one."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.app.filling.families import Family, Pile, family_of
from workbench.app.filling.hand import Hand
from workbench.app.filling.work import CHECK_WORK, FALL, REACH_WORK, WORLD
from workbench.model.candidate import Pick, Reason
from workbench.model.cell import Cell
from workbench.model.messages.changes import FillText
from workbench.model.messages.message import Message
from workbench.model.part import Grasp
from workbench.model.scan import Detection
from workbench.perception.simulation.unloading import is_in_bin, unloaded
from workbench.planning.collision.world import World
from workbench.planning.grasps.grasp_check import GraspCheck
from workbench.planning.picking.propose import candidate_of
from workbench.planning.picking.resolve import resolve

WAYS = 4
"""Ways of a family by which an arm is tried at a part."""

WAYS_TRIED = 12
"""Ways of all families, at most."""

MOST_GRIPS, FEWEST_GRIPS = 24, 6
"""Grips by which an arm is tried at a part that no family takes, at most and at least."""

MOST_WORK = 1000.0
"""Points of work: once they are spent, more than the least are not tried."""

MOST_FAMILIES = 24
"""Families of a tool, at most."""

RISE = 0.1
"""[m] A part is lifted while the rest comes to lie anew."""


@dataclass(frozen=True, slots=True, eq=False)
class Stays:
    """A part, by its number, that stays in a pile, and why."""

    pile: Pile
    number: int
    reason: Message


def clear_collisions(
    cell: Cell,
    hands: Sequence[Hand],
    pile: Sequence[Detection],
    seed: int,
    is_over: Callable[[], bool],
) -> tuple[int, list[Stays]]:
    """Take out what families take, as long as some part comes out; others add families.

    Args:
        cell: that the pile lies in.
        hands: whose families grow.
        pile: how the parts lie.
        seed: of what is left to chance.
        is_over: asked now and then; True ends it.

    Returns:
        How many parts came out, and those that stay, where that is known.
    """
    rest = list(pile)
    rng = np.random.default_rng(seed)
    taken = 0
    while rest:
        world = World(cell, tuple(rest))
        hands[0].grower.work.add(WORLD * len(rest) * len(cell.parts[0].pieces))
        gone: list[int] = []
        for number in range(len(rest)):
            if is_over():
                return taken + len(gone), []
            if takes(hands, world, number, seed, rng) is not None:
                gone.append(number)
        why: list[Stays] = []
        if not gone:
            for number in range(len(rest)):
                if is_over():
                    return taken + len(gone), why
                reason = add_family(hands, world, number, seed, rng)
                if reason is not None:
                    why.append(Stays(tuple(rest), number, reason))
                else:
                    gone.append(number)
        if not gone:
            return taken, why
        taken += len(gone)
        hands[0].grower.work.add(FALL * len(rest) ** 2)
        rest = _without(cell, rest, gone)
    return taken, []


def takes(
    hands: Sequence[Hand], world: World, number: int, seed: int, rng: np.random.Generator
) -> Family | None:
    """The family by which an arm takes a part, which it notes; None where none does."""
    tried = 0
    for hand in hands:
        for family in sorted(hand.families, key=lambda other_family: -len(other_family.took)):
            if not hand.fits(family, world.tool_check, number):
                continue
            free = np.flatnonzero(hand.free_ways(family, world.tool_check, number))
            for k in rng.permutation(free)[:WAYS].tolist():
                tried += 1
                reason = _refuse_reach(hand, world, number, family.grasp(k), seed)
                if reason is None:
                    family.took.append((world.detections, number))
                    return family
                if tried >= WAYS_TRIED or reason == COVERED:
                    return None
    return None


COVERED = FillText.COVERED()


def _refuse_reach(hand: Hand, world: World, number: int, grasp: Grasp, seed: int) -> Message | None:
    """Why no arm takes a part by a grasp; None when one does."""
    reason = None
    for arm in hand.arms:
        before = world.checks
        result = resolve(world, candidate_of(world, number, grasp, arm), seed=seed)
        hand.grower.work.add(REACH_WORK + CHECK_WORK * (world.checks - before))
        if isinstance(result, Pick):
            return None
        if result.reason is Reason.EXTRACT_BLOCKED and result.q is None:
            return COVERED
        reason = result.reason.message
    return reason


def add_family(
    hands: Sequence[Hand], world: World, number: int, seed: int, rng: np.random.Generator
) -> Message | None:
    """Have a grip that takes a part add its family, None; else why none does."""
    reasons: Counter[Message] = Counter()
    work = hands[0].grower.work
    until = work.done + MOST_WORK
    for hand in hands:
        for k, found in _firmest(hand, world, number, rng):
            narrow = replace(hand.raw(k), T_part_tcp=found[0].T_part_tcp, grip=found[0].grip)
            reason = _refuse_reach(hand, world, number, narrow, seed)
            if reason is None:
                _add(hand, world, number, found[0])
                return None
            reasons[reason] += 1
            is_late = work.done > until and reasons.total() >= FEWEST_GRIPS
            if reason == COVERED or is_late:
                break
    return reasons.most_common(1)[0][0] if reasons else Reason.TOOL_COLLISION.message


def _firmest(
    hand: Hand, world: World, number: int, rng: np.random.Generator
) -> list[tuple[int, tuple[Grasp, GraspCheck]]]:
    """Some grips of the raster that fit at a part and hold it, those that hold best first."""
    holding: list[tuple[int, tuple[Grasp, GraspCheck]]] = []
    for k in rng.permutation(np.flatnonzero(hand.free(world.tool_check, number))).tolist():
        found = hand.grip(k)
        if found is not None:
            holding.append((k, found))
        if len(holding) == MOST_GRIPS:
            break
    return sorted(holding, key=lambda hold: -hand.goodness(*hold[1]))


def _add(hand: Hand, world: World, number: int, grasp: Grasp) -> None:
    if len(hand.families) >= MOST_FAMILIES:
        return
    part = hand.grower.part
    family = family_of(part, hand.arm, hand.grower.extend(grasp), hand.least_air)
    family.took.append((world.detections, number))
    hand.families.append(family)


def _without(cell: Cell, rest: Sequence[Detection], gone: Sequence[int]) -> list[Detection]:
    """What is left as some parts are gone and the last of them is lifted straight up."""
    stays = [detection for number, detection in enumerate(rest) if number not in gone]
    if not stays:
        return []
    last = rest[gone[-1]]
    T = last.T_world_part
    way = [T, pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, RISE]))]
    settled = unloaded(cell, [*stays, last], len(stays), way)
    return [
        detection
        for detection in settled
        if is_in_bin(cell.bin, cell.parts[0], detection.T_world_part)
    ]
