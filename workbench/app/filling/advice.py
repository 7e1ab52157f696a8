"""What other tool or bin would take the parts that no grip of the tools takes."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.emptying.changes import changes_of
from workbench.app.filling.clearing import Stays
from workbench.app.filling.hand import hands_for
from workbench.app.filling.work import Work
from workbench.model.cell import Cell, Tool
from workbench.model.geometry import Cylinder, Solid
from workbench.model.messages.changes import ChangeText
from workbench.model.messages.message import Message
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection
from workbench.planning.collision.surroundings import Surroundings
from workbench.planning.collision.tool_check import ToolCheck

CHANGES_TRIED = (ChangeText.FINGERS_THINNER, ChangeText.WALLS_LOWER)
"""Changes of the cell that are tried, besides a cup."""

LOOKED = 6
"""Parts that are checked, at most."""

HOLDING = 12
"""Grips that fit and are checked whether they hold."""

CUP_WIDTH, CUP_LENGTH = 0.008, 0.06
"""[m] How wide the cup is that is tried instead of fingers, and how long."""

MOST_CHANGES = 3
"""Changes that are named."""


def advice(
    cell: Cell, stuck: Sequence[Stays], seed: int, work: Work
) -> tuple[tuple[tuple[Message, int], ...], int]:
    """The changes that let a hand hold most of some parts, the best first, and how many they hold.

    Args:
        cell: that the parts lie in; it picks them alone.
        stuck: the parts.
        seed: of what is left to chance.
        work: is counted; once it is done, what is known is the answer.

    Returns:
        Changes with how many of the parts a hand would hold, and of how many.
    """
    if not stuck:
        return (), 0
    part = replace(cell.parts[0], library=GraspLibrary())
    chosen = np.random.default_rng(seed).permutation(len(stuck))[:LOOKED].tolist()
    found: list[tuple[Message, int]] = []
    for said, other in _others(cell):
        other = replace(other, parts=(part,))
        hands = hands_for(other, part, seed, work)
        count = 0
        for k in chosen:
            if work.is_over():
                return _best(found), len(chosen)
            tools = ToolCheck(Surroundings(other, _in_bin(cell, other, stuck[k].pile)))
            for hand in hands:
                free = np.flatnonzero(hand.free(tools, stuck[k].number))
                some = np.random.default_rng(seed).permutation(free)[:HOLDING].tolist()
                if any(hand.grip(n) is not None for n in some):
                    count += 1
                    break
        if count:
            found.append((said, count))
    return _best(found), len(chosen)


def _best(found: list[tuple[Message, int]]) -> tuple[tuple[Message, int], ...]:
    return tuple(sorted(found, key=lambda counted_change: -counted_change[1])[:MOST_CHANGES])


def _others(cell: Cell) -> Iterator[tuple[Message, Cell]]:
    """Other cells, with what is other; those that fit the most kinds of parts first."""
    if any(arm.tool.fingers for arm in cell.arms):
        arms = tuple(replace(arm, tool=_cup(arm.tool)) for arm in cell.arms)
        yield ChangeText.CUP(by=CUP_WIDTH), replace(cell, arms=arms)
    for change in changes_of(cell):
        other = change.made(cell) if change.said.text in CHANGES_TRIED else None
        if other is not None:
            yield change.said, other


def _cup(tool: Tool) -> Tool:
    """A slim cup where the fingers of a tool end."""
    back = pin.SE3(np.eye(3), np.array([0.0, 0.0, -CUP_LENGTH / 2]))
    body = Solid("cup", Cylinder(CUP_WIDTH / 2, CUP_LENGTH), tool.T_flange_tcp * back)
    bare = replace(tool, fingers=(), stroke=(0.0, 0.0), tcps=(), tcp="")
    return replace(bare, name=f"{tool.name}-cup", body=(body,))


def _in_bin(cell: Cell, other: Cell, pile: Sequence[Detection]) -> tuple[Detection, ...]:
    step = other.bin.T_world_bin * cell.bin.T_world_bin.inverse()
    return tuple(
        replace(detection, T_world_part=step * detection.T_world_part) for detection in pile
    )
