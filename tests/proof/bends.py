"""Plans, scenes and cells bent by a seed; nobody knows beforehand whether it does any harm."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from bending import with_leg
from bent_case import Case, Draw, near_a_way, one_of, small
from changed_cells import CHANGES, other_bin

from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import ArmPlan, Guarantee, Leg, Step, Strategy
from workbench.model.scan import Detection, Obstacle
from workbench.proof.claims.places.layers import kept_box

Bend = Callable[[Case, Draw], Case]


def bent(case: Case, draw: Draw) -> tuple[str, Case]:
    """A case with one thing changed, and what that was."""
    pallets = any(one.pallet for arm in case.cell.arms for one in arm.part_places)
    kinds = (*KINDS, *OF_PALLETS) if pallets else KINDS
    if case.cell.other_bins:
        kinds = (*kinds, other_bin)
    kind = kinds[draw.integers(len(kinds))]
    return kind.__name__, kind(case, draw)


def _leg(case: Case, draw: Draw) -> tuple[ArmPlan, Leg]:
    one = one_of(case.plan.arms, draw)
    return one, one_of(one.legs, draw)


def _put(case: Case, one: ArmPlan, leg: Leg, **changes) -> Case:
    if "q" in changes:
        changes["q"] = case.cell.controller.motion.rounded(changes["q"])
    return replace(case, plan=with_leg(case.plan, one.arm, leg.name, **changes))


# -- ways -------------------------------------------------------------------------------------


def moved(case: Case, draw: Draw) -> Case:
    """One waypoint elsewhere, by a twentieth of a degree to thirty."""
    one, leg = _leg(case, draw)
    q, row = np.array(leg.q), draw.integers(1, max(len(leg.q) - 1, 2))
    way = draw.normal(size=q.shape[1])
    q[row] += way / np.linalg.norm(way) * np.deg2rad(small(draw, 0.05, 30))
    return _put(case, one, leg, q=q, t=leg.t * 3)


def dropped(case: Case, draw: Draw) -> Case:
    """Some waypoints left out, so that the way between the others is cut."""
    one, leg = _leg(case, draw)
    stays = draw.random(len(leg.q)) < draw.uniform(0.2, 0.9)
    stays[[0, -1]] = True
    return _put(case, one, leg, q=leg.q[stays], t=leg.t[stays] * 3)


def cut_short(case: Case, draw: Draw) -> Case:
    """Straight from the first waypoint to the last."""
    one, leg = _leg(case, draw)
    return _put(case, one, leg, q=leg.q[[0, -1]], t=leg.t[[0, -1]] * 3)


def swung(case: Case, draw: Draw) -> Case:
    """A way that swings out, as a whole, between its ends."""
    one, leg = _leg(case, draw)
    swing = np.sin(np.linspace(0.0, np.pi, len(leg.q)))[:, None]
    way = draw.normal(size=leg.q.shape[1]) * np.deg2rad(small(draw, 0.05, 20))
    return _put(case, one, leg, q=leg.q + swing * way, t=leg.t * 3)


def doubled(case: Case, draw: Draw) -> Case:
    """A stretch of a way run again."""
    one, leg = _leg(case, draw)
    k = int(draw.integers(1, len(leg.q)))
    rows = [*range(k + 1), *range(k - 1, len(leg.q))]
    return _put(case, one, leg, q=leg.q[rows], t=np.linspace(0, leg.t[-1] * 6, len(rows)))


def reversed_(case: Case, draw: Draw) -> Case:
    one, leg = _leg(case, draw)
    return _put(case, one, leg, q=leg.q[::-1], t=leg.t[-1] - leg.t[::-1])


def swapped(case: Case, draw: Draw) -> Case:
    """Two legs have each other's ways."""
    one, leg = _leg(case, draw)
    other = one_of(one.legs, draw)
    first = _put(case, one, leg, q=other.q, t=other.t)
    return _put(first, one, other, q=leg.q, t=leg.t)


def other_order(case: Case, draw: Draw) -> Case:
    """Steps of the sequence exchanged, left out, doubled or run at once."""
    steps = list(case.plan.sequence)
    k, m = draw.integers(len(steps), size=2).tolist()
    match draw.integers(4):
        case 0:
            steps[k], steps[m] = steps[m], steps[k]
        case 1:
            del steps[k]
        case 2:
            steps.insert(m, steps[k])
        case _ if k != m:
            steps[k] = Step((*steps[k].runs, *steps[m].runs))
            del steps[m]
    return replace(case, plan=replace(case.plan, sequence=tuple(steps)))


def other_legs(case: Case, draw: Draw) -> Case:
    """A leg left out of what an arm does, twice in it, in another's stead, or holding otherwise."""
    one = one_of(case.plan.arms, draw)
    legs = list(one.legs)
    k, m = draw.integers(len(legs), size=2).tolist()
    match draw.integers(4):
        case 0:
            del legs[k]
        case 1:
            legs.insert(m, legs[k])
        case 2:
            legs[k], legs[m] = legs[m], legs[k]
        case _:
            legs[k] = replace(legs[k], holding=not legs[k].holding)
    arms = tuple(replace(a, legs=tuple(legs)) if a is one else a for a in case.plan.arms)
    return replace(case, plan=replace(case.plan, arms=arms))


def timed(case: Case, draw: Draw) -> Case:
    one, leg = _leg(case, draw)
    return _put(case, one, leg, t=leg.t * small(draw, 0.3, 3))


def shuffled(case: Case, draw: Draw) -> Case:
    """The times between waypoints in another order."""
    one, leg = _leg(case, draw)
    steps = draw.permutation(np.diff(leg.t)) * small(draw, 0.7, 4)
    return _put(case, one, leg, t=np.concatenate([[0.0], np.cumsum(steps)]))


# -- hands ------------------------------------------------------------------------------------


def turned_in_hand(case: Case, draw: Draw) -> Case:
    """A part in the hand otherwise than it was taken."""
    one, size = one_of(case.plan.arms, draw), small(draw, 0.05, 4)
    way = pose_from_rpy(draw.normal(0, 0.001 * size, 3), draw.normal(0, 0.01 * size, 3))
    arms = tuple(
        replace(arm, T_tcp_part=arm.T_tcp_part * way) if arm is one else arm
        for arm in case.plan.arms
    )
    return replace(case, plan=replace(case.plan, arms=arms))


def opened(case: Case, draw: Draw) -> Case:
    """Fingers otherwise than the grasp says."""
    one, leg = _leg(case, draw)
    high = case.cell.arm(one.arm).tool.stroke[1]
    return _put(case, one, leg, opening=float(draw.uniform(0.0, max(high, 0.01))))


def other_grasp(case: Case, draw: Draw) -> Case:
    one = one_of(case.plan.arms, draw)
    part = case.cell.part(case.plan.detections[one.detection].part)
    name = one_of(part.grasps, draw).name
    arms = tuple(replace(arm, grasp=name) if arm is one else arm for arm in case.plan.arms)
    return replace(case, plan=replace(case.plan, arms=arms))


def other_part(case: Case, draw: Draw) -> Case:
    one = one_of(case.plan.arms, draw)
    number = int(draw.integers(len(case.plan.detections)))
    arms = tuple(replace(arm, detection=number) if arm is one else arm for arm in case.plan.arms)
    return replace(case, plan=replace(case.plan, arms=arms))


def put_elsewhere(case: Case, draw: Draw) -> Case:
    """The way to the place ends a little beside it."""
    one = one_of(case.plan.arms, draw)
    off = draw.normal(size=len(one.joints)) * np.deg2rad(small(draw, 0.01, 3))
    place, home = one.leg("place"), one.leg("home")
    down, out = np.array(place.q), np.array(home.q)
    down[-1] += off
    out[0] += off
    case = _put(case, one, place, q=down, t=place.t * 3)
    return _put(case, case.plan.arm(one.arm), home, q=out, t=home.t * 3)


def other_word(case: Case, draw: Draw) -> Case:
    """Said to be of another strategy, or safe under another condition."""
    if draw.random() < 0.5:
        said = one_of(list(Guarantee), draw)
        return replace(case, plan=replace(case.plan, guarantee=said))
    words = ["alternated", "coordinated", *(arm.name for arm in case.cell.arms)]
    return replace(case, plan=replace(case.plan, strategy=Strategy(one_of(words, draw))))


# -- scenes -----------------------------------------------------------------------------------


def _with_parts(case: Case, parts, known=None) -> Case:
    """The plan with other parts, and the scene with them or with what is known otherwise."""
    scene = replace(case.scene, detections=tuple(parts if known is None else known))
    return replace(case, scene=scene, plan=replace(case.plan, detections=tuple(parts)))


def sunk(case: Case, draw: Draw) -> Case:
    """Every part deeper in the bin, or higher, than where it is."""
    shift = pose_from_rpy((0.0, 0.0, draw.uniform(-0.005, 0.005)))
    parts = [replace(d, T_world_part=shift * d.T_world_part) for d in case.plan.detections]
    return _with_parts(case, parts)


def pushed(case: Case, draw: Draw) -> Case:
    """One part moved and turned a little."""
    parts, size = list(case.plan.detections), small(draw, 0.05, 30)
    k = int(draw.integers(len(parts)))
    way = pose_from_rpy(draw.normal(0, 0.001 * size, 3), draw.normal(0, 0.01 * size, 3))
    parts[k] = replace(parts[k], T_world_part=parts[k].T_world_part * way)
    return _with_parts(case, parts, None if draw.random() < 0.7 else case.scene.detections)


def added(case: Case, draw: Draw) -> Case:
    """One more part somewhere in the bin; the plan may not know it."""
    kind = case.plan.detections[0].part
    at = (draw.random(3) - [0.5, 0.5, 0.0]) * [*case.cell.bin.size[:2], 0.1]
    T = case.cell.bin.T_world_bin * pose_from_rpy(at, draw.uniform(-np.pi, np.pi, 3))
    parts = (*case.plan.detections, Detection(kind, T))
    if draw.random() < 0.3:
        return replace(case, scene=replace(case.scene, detections=parts))
    return _with_parts(case, parts)


def removed(case: Case, draw: Draw) -> Case:
    """A part that is not taken left out of the plan; it may be gone from the scene too."""
    taken = {one.detection for one in case.plan.arms}
    last = len(case.plan.detections) - 1
    if last in taken:
        return replace(case, scene=replace(case.scene, detections=case.plan.detections[:-1]))
    parts = case.plan.detections[:-1]
    return _with_parts(case, parts, None if draw.random() < 0.6 else case.scene.detections)


def seen(case: Case, draw: Draw) -> Case:
    """Something that the scan shows; the plan may not know it."""
    turn = (0.0, 0.0, draw.uniform(0.0, 3.0))
    box = Obstacle(pose_from_rpy(near_a_way(case, draw), turn), draw.uniform(0.005, 0.06, 3))
    boxes = (*case.plan.obstacles, box)
    scene = replace(case.scene, obstacles=boxes)
    if draw.random() < 0.2:
        return replace(case, scene=scene)
    return replace(case, scene=scene, plan=replace(case.plan, obstacles=boxes))


def cleared(case: Case, draw: Draw) -> Case:
    """A part taken from a pallet; the plan may not know it."""
    kept = [box for box in case.scene.obstacles if box.part]
    if not kept:
        return stacked(case, draw)
    gone = one_of(kept, draw)
    boxes = tuple(box for box in case.scene.obstacles if box is not gone)
    scene = replace(case.scene, obstacles=boxes)
    if draw.random() < 0.2:
        return replace(case, scene=scene)
    return replace(case, scene=scene, plan=replace(case.plan, obstacles=boxes))


def stacked(case: Case, draw: Draw) -> Case:
    """One more part anywhere on a pallet; the plan alone may know it."""
    arm = one_of(case.cell.arms, draw)
    place = one_of([one for one in arm.part_places if one.pallet], draw)
    found = Detection(case.plan.detections[0].part, place.T_world_part)
    box = kept_box(case.cell, case.scene.obstacles, found, place.T_world_part)
    boxes = (*case.plan.obstacles, box)
    plan = replace(case.plan, obstacles=boxes)
    if draw.random() < 0.2:
        return replace(case, plan=plan)
    return replace(case, scene=replace(case.scene, obstacles=boxes), plan=plan)


OF_PALLETS: tuple[Bend, ...] = (cleared, stacked, cleared, stacked)
"""Of cells whose parts lie in layers."""

KINDS: tuple[Bend, ...] = (
    moved, dropped, cut_short, swung, doubled, reversed_, swapped, other_order, other_legs, timed,
    shuffled, turned_in_hand, opened, other_grasp, other_part, put_elsewhere, other_word, sunk,
    pushed, added, removed, seen, *CHANGES,
)  # fmt: skip
