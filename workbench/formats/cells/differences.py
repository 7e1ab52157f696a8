"""How two cells differ, in words and by how much: for people, why a plan is stale."""

from collections.abc import Iterator
from dataclasses import fields

import numpy as np
import pinocchio as pin

from workbench.formats.parts.grasp_words import changes_in_words
from workbench.model.cell import Arm, Cell
from workbench.model.digest import digest_of
from workbench.model.geometry import shift_and_turn
from workbench.model.part import Part

MOST_NAMED = 3


def difference(before: Cell, after: Cell) -> str:
    """What differs in the second cell, the first few things by name; empty when nothing does."""
    found = list(_differences(before, after))
    if not found and before.digest != after.digest:
        found = ["the cell was changed"]
    more = len(found) - MOST_NAMED
    named = found[:MOST_NAMED] + ([f"{more} more differences"] if more > 0 else [])
    return ", ".join(named)


def _differences(before: Cell, after: Cell) -> Iterator[str]:
    yield from _list_moves("the bin", before.bin.T_world_bin, after.bin.T_world_bin)
    if not np.array_equal(before.bin.size, after.bin.size) or before.bin.wall != after.bin.wall:
        yield "the bin has another size"
    if digest_of(before.bin.regions) != digest_of(after.bin.regions):
        yield "the regions of interest are others"
    if before.bin.has_walls != after.bin.has_walls:
        yield "the bin has walls" if after.bin.has_walls else "the bin has no walls any more"
    yield from _list_moves("the robot", before.T_world_robot, after.T_world_robot)
    yield from _list_moves(
        "the scanner", before.scanner.T_world_scanner, after.scanner.T_world_scanner
    )
    were = {fixture.name: fixture for fixture in before.fixtures}
    are = {fixture.name: fixture for fixture in after.fixtures}
    for name in were | are:
        if name not in are:
            yield f"{name} was taken away"
        elif name not in were:
            yield f"{name} was added"
        else:
            yield from _list_moves(name, were[name].T_world_fixture, are[name].T_world_fixture)
    if digest_of(before.stations) != digest_of(after.stations):
        yield "the stations are others"
    for arm, other in zip(before.arms, after.arms, strict=False):
        yield from _arm(arm, other)
    for field in fields(before.policy):
        old, new = getattr(before.policy, field.name), getattr(after.policy, field.name)
        if old != new:
            yield f"{field.name} was {old}, now it is {new}"
    yield from _parts(before.parts, after.parts)


def _list_moves(what: str, before: pin.SE3, after: pin.SE3) -> Iterator[str]:
    shift, turn = shift_and_turn(before.actInv(after))
    far, turned = shift * 1000, float(np.rad2deg(turn))
    if far > 1e-3 and turned > 1e-3:
        yield f"{what} was moved by {far:.1f} mm and turned by {turned:.1f} degrees"
    elif far > 1e-3:
        yield f"{what} was moved by {far:.1f} mm"
    elif turned > 1e-3:
        yield f"{what} was turned by {turned:.1f} degrees"


def _arm(before: Arm, after: Arm) -> Iterator[str]:
    name = f"the {after.name} arm"
    if len(before.home) == len(after.home) and not np.array_equal(before.home, after.home):
        most = float(np.rad2deg(np.abs(after.home - before.home).max()))
        yield f"the home of {name} was moved by up to {most:.1f} degrees"
    if digest_of(before.tool) != digest_of(after.tool):
        yield f"{name} has another tool"
    places = [digest_of([arm.Ts_world_place, arm.part_places]) for arm in (before, after)]
    if places[0] != places[1]:
        yield f"{name} has other places"


def _parts(before: tuple[Part, ...], after: tuple[Part, ...]) -> Iterator[str]:
    were = {part.name: part for part in before}
    for part in after:
        old = were.pop(part.name, None)
        if old is None:
            yield f"part {part.name} was added"
        elif digest_of(old.library) != digest_of(part.library):
            words = "; ".join(changes_in_words(old.library, part.library))
            yield f"part {part.name} has other grasps ({words})"
        elif digest_of(old) != digest_of(part):
            yield f"part {part.name} was changed"
    for name in were:
        yield f"part {name} was taken away"
