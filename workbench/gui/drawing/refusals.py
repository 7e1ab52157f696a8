"""Where a candidate was refused: how arm or hand stand there, and the bodies that come too close.

A verdict names both bodies.  Where it has a configuration, the arm is shown in it; one that was
given before any arm was asked is about the hand alone, or about the part in it.
"""

from collections.abc import Iterator
from itertools import islice

import numpy as np
import pinocchio as pin

from workbench.gui.shared.look import Placed, Pose
from workbench.model.candidate import Candidate, Stage, Verdict
from workbench.model.geometry import Floats
from workbench.model.messages.verdicts import VerdictText
from workbench.planning.collision.bodies import part_label, tool_shapes
from workbench.planning.collision.legs import (
    approach_phase,
    grips,
    hand_turns,
    holding_phase,
)
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.picking.lifts import lifts
from workbench.planning.picking.put_down import ways_at_places
from workbench.planning.placing.assembling import arm_placing

MOST_GRIPS = 48
"""This many ways in which a hand may hold a part are tried, to find the one of a verdict."""

Stands = tuple[pin.SE3, float, pin.SE3]
"""How a hand stands: its `T_world_tcp`, its opening [m], and `T_world_part` of its part."""


def refused_pose(world: World, candidate: Candidate) -> Pose | None:
    """How arm or hand stand where a candidate was refused; None where that is not known.

    Args:
        world: of the cell and the detections; is put into the phase of what is shown.
        candidate: that works not.
    """
    verdict = candidate.verdict
    q = None if verdict.q is None else np.asarray(verdict.q)
    label, note = VerdictText.FAILED_AT(stage=verdict.stage.message), verdict.message
    if q is not None:
        if len(q) != len(world.arm(candidate.arm).joints):
            return None
        opening, meets = _met_by_arm(world, candidate, q)
        return Pose(label, q, opening, note, meets)
    if verdict.pair is None:
        return None
    stands = _stands(world, candidate)
    meets = _met_by_hand(world, candidate, stands)
    return Pose(label, None, stands[1], note, meets, stands[0])


def _met_by_arm(world: World, candidate: Candidate, q: Floats) -> tuple[float, tuple[Placed, ...]]:
    """How far fingers are open [m] at q (n,), and the two bodies there, if some are named."""
    arm, verdict, grasp = world.arm(candidate.arm), candidate.verdict, candidate.grasp
    is_holding = verdict.stage in (Stage.EXTRACT, Stage.PLACE)
    whole = world.configuration({arm.name: q})
    phases = _holding(world, candidate) if is_holding else [approach_phase(candidate, arm)]
    if verdict.pair is None:
        return grasp.opening, ()
    best: LegPhase | None = None
    least = np.inf
    for phase in phases:
        world.enter(phase)
        met = {frozenset(contact.pair): contact.distance for contact in world.contacts(whole)}
        distance = met.get(frozenset(verdict.pair), np.inf)
        off = abs(distance - (verdict.distance or 0.0))
        if best is None or off < least:
            best, least = phase, off
    assert best is not None  # there is always one phase
    world.enter(best)
    return best.openings[arm.name], world.place_shapes(whole, verdict.pair)


def _holding(world: World, candidate: Candidate) -> Iterator[LegPhase]:
    """The candidate's part in its hand, in each of the ways in which the grasp may hold it."""
    arm = world.arm(candidate.arm)
    T_world_part = world.detections[candidate.detection].T_world_part
    straight = candidate.verdict.stage is Stage.EXTRACT
    for T in islice(grips(arm.tool, candidate.grasp), MOST_GRIPS):
        T_tcp_part = (candidate.T_world_tcp * T).actInv(T_world_part)
        yield holding_phase(candidate, arm, T_tcp_part, straight=straight)


def _stands(world: World, candidate: Candidate) -> Stands:
    """How the hand alone stands where its verdict was given."""
    grasp, number = candidate.grasp, candidate.detection
    T, T_world_part = candidate.T_world_tcp, world.detections[number].T_world_part
    match candidate.verdict.stage:
        case Stage.EXTRACT:
            way = _way_to_contact(world, candidate)
            return _move(T, way), grasp.grip, _move(T_world_part, way)
        case Stage.PLACE:
            T_put = _put(world, candidate)
            return T_put * T_world_part.actInv(T), grasp.grip, T_put
        case _:
            arm = world.arm(candidate.arm)
            fit = world.tool_check.fits(arm, (grasp,), [(number, 0)])[0]
            if fit.pair is None:
                # The hand fits: what is wrong is how the part may be turned in it.
                return T * grips(arm.tool, grasp)[fit.turn], fit.opening, T_world_part
            return T, grasp.grip if fit.is_closed else fit.opening, T_world_part


def _move(T: pin.SE3, way: Floats) -> pin.SE3:
    return pin.SE3(T.rotation, T.translation + way)


def _way_to_contact(world: World, candidate: Candidate) -> Floats:
    """How far the part is lifted (3,) [m] until it, or its hand, meets what the verdict names."""
    number, arm = candidate.detection, world.arm(candidate.arm)
    pair = set(candidate.verdict.pair or ())
    T, own = candidate.T_world_tcp, part_label(number)
    for _, way in lifts(world, candidate, T):
        (met,) = world.part_ways.find_blocks(number, [way])
        if met is not None and pair == {own, met[0]}:
            return way * (met[1] / np.linalg.norm(way))
        on_way = world.tool_check.on_way(arm, T, candidate.grasp.grip, number, way)
        if on_way is not None and pair == set(on_way[0]):
            return way * (on_way[1] / np.linalg.norm(way))
    return np.zeros(3)


def _put(world: World, candidate: Candidate) -> pin.SE3:
    """Where the part stands in what the verdict names, at the first such place of its arm."""
    number = candidate.detection
    arm = arm_placing(world, world.arm(candidate.arm), number)
    T_world_part = world.detections[number].T_world_part
    if isinstance(arm, Verdict):
        return T_world_part
    T_tcp_part = candidate.T_world_tcp.actInv(T_world_part)
    ways = [place for place in ways_at_places(world, arm, number) if isinstance(place, pin.SE3)]
    turns = hand_turns(arm.tool)
    ways += [T * turn * T_tcp_part for T in arm.Ts_world_place for turn in turns]
    for T_put in ways:
        label = world.part_ways.standing_in(number, T_put, world.policy.margin)
        if label in (candidate.verdict.pair or ()):
            return T_put
    return T_world_part


def _met_by_hand(world: World, candidate: Candidate, stands: Stands) -> tuple[Placed, ...]:
    """The bodies that the verdict names, with the hand and its part as they stand."""
    arm, (T_world_tcp, opening, T_world_part) = world.arm(candidate.arm), stands
    labels, own = candidate.verdict.pair or (), part_label(candidate.detection)
    found: list[Placed] = [
        (shape.solid.shape, shape.at(arm.tool, T_world_tcp, opening))
        for shape in tool_shapes(arm.tool)
        if f"{arm.name} {shape.name}" in labels
    ]
    T_moved = T_world_part * world.detections[candidate.detection].T_world_part.inverse()
    for body in world.surroundings.bodies:
        if body.label in labels:
            found.append(
                (
                    body.shape,
                    T_moved * body.T_joint_body if body.label == own else body.T_joint_body,
                )
            )
    return tuple(found)
