"""The path on which an arm puts down its tool in one slot and takes another one from its slot.

It is planned in three worlds: with the old tool, with a bare flange, and with the new tool.  In
each of them every tool that the arm does not carry stands in its slot.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.load import change_loads
from workbench.model.messages.plans import leg_message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.motion import TOOL_LEGS, LegName
from workbench.model.plan import Leg, Plan
from workbench.model.robot import ToolSlot
from workbench.model.scan import Scene
from workbench.model.tools.slots import slot_of, standing_name, with_mounted
from workbench.planning.collision.motion import arm_contact
from workbench.planning.collision.pairing import DEEPEST_IN_SLOT, LegPhase
from workbench.planning.collision.world import World
from workbench.planning.empty_hand.alone import arm_alone, plan_alone, random_of
from workbench.planning.kinematics.inverse import configurations, starts_of
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.put_down import home_of
from workbench.planning.picking.route import free_path, leg_of
from workbench.planning.planners.clock import processor_time, working_time

POINT_STEP = 0.02
"""[m] From waypoint to waypoint on straight legs."""

MOST_POSTURES = 4
"""Postures at each slot for which the free legs are planned."""


@dataclass(frozen=True, slots=True, eq=False)
class _Visit:
    """The straight paths from a slot: with the tool (m, n) [rad], and of the bare flange (k, n)."""

    carrying: Floats
    bare: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Worlds:
    """The worlds of a change by what the arm carries, in the order of its legs."""

    arm: str
    old: World
    bare: World
    new: World


def route_change(
    cell: Cell, arm_name: str, tool: str, scene: Scene, *, seed: int, deadline: float
) -> Plan | Verdict:
    """A plan in which an arm changes its tool.

    Args:
        cell: in which the arm carries its old tool; both tools have a slot.
        arm_name: which arm.
        tool: that it carries afterwards.
        scene: what the plan states of the bin: no parts, and obstacles that fill it.
        seed: of the request.
        deadline: [s] on the clock of `processor_time`, when planning gives up.

    Returns:
        The plan; or the verdict on the path that came farthest.
    """
    began, arm = working_time(), cell.arm(arm_name)
    cells = (cell, with_mounted(cell, arm_name, ""), with_mounted(cell, arm_name, tool))
    worlds = _Worlds(arm_name, *(World(each, (), scene.obstacles) for each in cells))
    for world in (worlds.old, worlds.bare, worlds.new):
        world.deadline = deadline
    legs = _legs(worlds, arm.tool.name, tool, seed)
    if isinstance(legs, Verdict):
        return legs
    loads = change_loads(arm.tool, cells[2].arm(arm_name).tool)
    arm_plan = replace(arm_alone(arm, legs, loads), tool=tool)
    return plan_alone(cell, scene, arm_plan, seed=seed, began=began)


def slot_problem(cell: Cell, arm_name: str, tool: str) -> Verdict | None:
    """Why an arm cannot put down one of its tools in its slot and leave; None when it can."""
    worlds = [World(with_mounted(cell, arm_name, name), ()) for name in (tool, "")]
    slot = slot_of(cell.arm(arm_name), tool)
    assert slot is not None
    found = list(_visits(worlds[0], worlds[1], arm_name, slot, seed=0))
    return None if isinstance(found[0], _Visit) else found[0]


def _legs(worlds: _Worlds, old: str, new: str, seed: int) -> tuple[Leg, ...] | Verdict:
    """The legs for the first postures at both slots between which there are free paths."""
    name, arm = worlds.arm, worlds.bare.arm(worlds.arm)
    visits: list[list[_Visit]] = []
    for tool, carrying, leg in ((old, worlds.old, "stow"), (new, worlds.new, "undock")):
        slot = slot_of(arm, tool)
        assert slot is not None
        found = list(_visits(carrying, worlds.bare, name, slot, seed))
        visits.append([visit for visit in found if isinstance(visit, _Visit)])
        if not visits[-1]:
            verdict = next(each for each in found if isinstance(each, Verdict))
            return verdict.with_note(VerdictNote.LEG(leg=leg_message(leg)))
    home = home_of(worlds.bare, arm)
    refusal = Verdict(Reason.NO_PATH, Stage.ROUTE)
    for there, here in product(*visits):
        rng = random_of(arm, seed)
        free: dict[LegName, Floats] = {}
        between: tuple[tuple[LegName, World, Floats, Floats], ...] = (
            ("reach", worlds.old, home, there.carrying[-1]),
            ("cross", worlds.bare, there.bare[-1], here.bare[-1]),
            ("home", worlds.new, here.carrying[-1], home),
        )
        for leg, world, start, goal in between:
            if processor_time() > world.deadline:
                return Verdict(Reason.OUT_OF_TIME, Stage.ROUTE)
            _enter(world, name)
            path = free_path(world, world.arm(name), start[None], goal, rng)
            if isinstance(path, Verdict):
                refusal = replace(path, note=VerdictNote.LEG(leg=leg_message(leg)))
                break
            free[leg] = path
        if len(free) == 3:
            straight: dict[LegName, Floats] = {
                "stow": there.carrying[::-1],
                "retract": there.bare,
                "dock": here.bare[::-1],
                "undock": here.carrying,
            }
            return _timed(worlds, free | straight)
    return refusal


def _timed(worlds: _Worlds, paths: Mapping[LegName, Floats]) -> tuple[Leg, ...]:
    """The legs along their paths (m, n) [rad], each with what the arm carries on it."""
    of = {"reach": worlds.old, "stow": worlds.old, "undock": worlds.new, "home": worlds.new}
    legs: list[Leg] = []
    for name in TOOL_LEGS:
        world = of.get(name, worlds.bare)
        arm = world.arm(worlds.arm)
        legs.append(leg_of(world, arm, name, paths[name], float(arm.tool.stroke[1]), None))
    return tuple(legs)


def _enter(world: World, arm: str, straight: Sequence[str] = ()) -> None:
    """The phase of a leg of the arm, with the fingers of its tool wide open."""
    opening = float(world.arm(arm).tool.stroke[1])
    world.enter(LegPhase(frozenset({arm}), {arm: opening}, straight=frozenset(straight)))


def _visits(
    carrying: World, bare: World, name: str, slot: ToolSlot, seed: int
) -> Iterator[_Visit | Verdict]:
    """The straight paths from a slot, by the postures of the arm there; or why there is none.

    Args:
        carrying: the world in which the arm carries the tool of the slot.
        bare: that in which it carries none.
        name: of the arm.
        slot: of the tool.
        seed: of the request.
    """
    arm, chain = bare.arm(name), bare.chains[name]
    standing = [slot.fixture] if slot.fixture else []
    ways = (
        (carrying, slot.T_world_outside, standing),
        (bare, slot.T_world_before, [*standing, standing_name(arm, slot.tool)]),
    )
    follow_from = partial(follow, chain, points=2 + int(slot.distance / POINT_STEP))
    refusal, count = Verdict(Reason.OUT_OF_REACH, Stage.ROUTE), 0
    for q in configurations(chain, slot.T_world_flange, starts_of(chain, arm, seed)).q:
        q_slot = np.clip(bare.motion.rounded(q), chain.lower, chain.upper)
        paths: list[Floats] = []
        for world, T_world_end, fixtures in ways:
            path, share = follow_from(q_slot, T_world_end)
            path = np.clip(bare.motion.rounded(path), chain.lower, chain.upper)
            if share < 1.0:
                break
            _enter(world, name, (name,))
            deep = world.allow_start_contacts(world.configuration({name: q_slot}), fixtures)
            if deep is not None:
                # So it is in every posture.
                note = VerdictNote.DEEP_IN_SLOT(most=DEEPEST_IN_SLOT)
                yield deep.refuse(Reason.IN_COLLISION, Stage.ROUTE, q_slot, note)
                return
            met = arm_contact(world, name, path)
            if met is not None:
                contact, at, _ = met
                refusal = contact.refuse(Reason.IN_COLLISION, Stage.ROUTE, at)
                break
            paths.append(path)
        if len(paths) == len(ways):
            yield _Visit(*paths)
            count += 1
            if count >= MOST_POSTURES:
                return
    if not count:
        yield refusal
