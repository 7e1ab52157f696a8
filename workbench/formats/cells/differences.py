"""How two cells differ, in words and by how much: for people, why a plan is stale."""

from collections.abc import Iterator
from dataclasses import fields

import numpy as np
import pinocchio as pin

from workbench.formats.parts.grasp_words import changes_in_words
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_view import view_name
from workbench.model.digest import digest_of
from workbench.model.geometry import shift_and_turn
from workbench.model.messages.cells import BinChoiceText, DifferenceText, ViewChoiceText
from workbench.model.messages.message import Message, all_of
from workbench.model.part import Part

MOST_NAMED = 3


def difference(before: Cell, after: Cell) -> Message:
    """What differs in the second cell, the first few things by name."""
    found = list(_differences(before, after))
    named = all_of(found[:MOST_NAMED]) or DifferenceText.CELL()
    more = len(found) - MOST_NAMED
    return DifferenceText.MORE(first=named, count=more) if more > 0 else named


def _differences(before: Cell, after: Cell) -> Iterator[Message]:
    if before.bin.name != after.bin.name:
        yield BinChoiceText.CHOSEN(name=after.bin.name)
    elif digest_of(before.bins[1:]) != digest_of(after.bins[1:]):
        yield DifferenceText.BINS()
    if view_name(before) != view_name(after):
        yield ViewChoiceText.CHOSEN(name=view_name(after))
    yield from _list_moves(DifferenceText.BIN(), before.bin.T_world_bin, after.bin.T_world_bin)
    if not np.array_equal(before.bin.size, after.bin.size) or before.bin.wall != after.bin.wall:
        yield DifferenceText.BIN_SIZE()
    if digest_of(before.bin.regions) != digest_of(after.bin.regions):
        yield DifferenceText.REGIONS()
    if before.bin.has_walls != after.bin.has_walls:
        yield (DifferenceText.WALLS if after.bin.has_walls else DifferenceText.NO_WALLS)()
    yield from _list_moves(DifferenceText.ROBOT(), before.T_world_robot, after.T_world_robot)
    yield from _list_moves(
        DifferenceText.SCANNER(), before.scanner.T_world_scanner, after.scanner.T_world_scanner
    )
    were = {fixture.name: fixture for fixture in before.fixtures}
    are = {fixture.name: fixture for fixture in after.fixtures}
    for name in were | are:
        if name not in are:
            yield DifferenceText.REMOVED(thing=name)
        elif name not in were:
            yield DifferenceText.ADDED(thing=name)
        else:
            yield from _list_moves(name, were[name].T_world_fixture, are[name].T_world_fixture)
    if digest_of(before.stations) != digest_of(after.stations):
        yield DifferenceText.STATIONS()
    if before.recipe != after.recipe:
        chosen = next((recipe for recipe in after.recipes if recipe.number == after.recipe), None)
        if chosen is None:
            yield DifferenceText.NO_RECIPE()
        else:
            yield DifferenceText.RECIPE(number=chosen.number, name=chosen.name)
    if before.recipes != after.recipes:
        yield DifferenceText.RECIPES()
    for arm, other in zip(before.arms, after.arms, strict=False):
        yield from _arm(arm, other)
    for field in fields(before.policy):
        old, new = getattr(before.policy, field.name), getattr(after.policy, field.name)
        if old != new:
            yield DifferenceText.KEY(key=field.name, old=_shown(old), new=_shown(new))
    yield from _parts(before.parts, after.parts)


def _shown(value: object) -> str:
    """A value of the policy, as people write it."""
    return ", ".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _list_moves(thing: Message | str, before: pin.SE3, after: pin.SE3) -> Iterator[Message]:
    shift, turn = shift_and_turn(before.actInv(after))
    is_moved, is_turned = shift > 1e-6, float(np.rad2deg(turn)) > 1e-3
    if is_moved and is_turned:
        yield DifferenceText.MOVED_AND_TURNED(thing=thing, shift=shift, turn=turn)
    elif is_moved:
        yield DifferenceText.MOVED(thing=thing, shift=shift)
    elif is_turned:
        yield DifferenceText.TURNED(thing=thing, turn=turn)


def _arm(before: Arm, after: Arm) -> Iterator[Message]:
    name = after.name
    if len(before.home) == len(after.home) and not np.array_equal(before.home, after.home):
        most = float(np.abs(after.home - before.home).max())
        yield DifferenceText.HOME(arm=name, turn=most)
    if digest_of(before.tool) != digest_of(after.tool):
        yield DifferenceText.OTHER_TOOL(arm=name)
    if digest_of(before.tool_slots) != digest_of(after.tool_slots):
        yield DifferenceText.TOOL_SLOTS(arm=name)
    places = [digest_of([arm.Ts_world_place, arm.part_places]) for arm in (before, after)]
    if places[0] != places[1]:
        yield DifferenceText.OTHER_PLACES(arm=name)


def _parts(before: tuple[Part, ...], after: tuple[Part, ...]) -> Iterator[Message]:
    were = {part.name: part for part in before}
    for part in after:
        old = were.pop(part.name, None)
        if old is None:
            yield DifferenceText.PART_ADDED(part=part.name)
        elif digest_of(old.library) != digest_of(part.library):
            changes = all_of(changes_in_words(old.library, part.library)) or ""
            yield DifferenceText.GRASPS(part=part.name, changes=changes)
        elif digest_of(old) != digest_of(part):
            yield DifferenceText.PART_CHANGED(part=part.name)
    for name in were:
        yield DifferenceText.PART_REMOVED(part=name)
