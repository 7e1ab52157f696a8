"""Plans, scenes and cells bent by a seed; nobody knows beforehand whether it does any harm."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from bending import with_leg
from judged_files import Files

from workbench.model.cell import Cell, Fixture
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.model.plan import ArmPlan, Guarantee, Leg, Plan, Step, Strategy
from workbench.model.scan import Detection, Obstacle, Scene


@dataclass(frozen=True, eq=False)
class Case:
    """A plan in a cell and a scene; the cell also as the judge reads it."""

    cell: Cell
    files: Files
    scene: Scene
    plan: Plan


Draw = np.random.Generator
Bend = Callable[[Case, Draw], Case]


def bent(case: Case, draw: Draw) -> tuple[str, Case]:
    """A case with one thing changed, and what that was."""
    kind = KINDS[draw.integers(len(KINDS))]
    return kind.__name__, kind(case, draw)


def one_of(items, draw: Draw):
    return items[draw.integers(len(items))]


def small(draw: Draw, low: float, high: float) -> float:
    """Of any size between two, small ones as often as large ones."""
    return float(10 ** draw.uniform(np.log10(low), np.log10(high)))


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


def _near_a_way(case: Case, draw: Draw) -> np.ndarray:
    """A place (3,) [m] above the bin, or by where parts are put."""
    if draw.random() < 0.6:
        room = np.append(case.cell.bin.size[:2] * 0.9, 0.35)
        return case.cell.bin.T_world_bin.act((draw.random(3) - [0.5, 0.5, -0.05]) * room)
    T = one_of(case.cell.arm(one_of(case.plan.arms, draw).arm).Ts_world_place, draw)
    return T.translation + draw.normal(0, 0.08, 3)


def seen(case: Case, draw: Draw) -> Case:
    """Something that the scan shows; the plan may not know it."""
    turn = (0.0, 0.0, draw.uniform(0.0, 3.0))
    box = Obstacle(pose_from_rpy(_near_a_way(case, draw), turn), draw.uniform(0.005, 0.06, 3))
    boxes = (*case.plan.obstacles, box)
    scene = replace(case.scene, obstacles=boxes)
    if draw.random() < 0.2:
        return replace(case, scene=scene)
    return replace(case, scene=scene, plan=replace(case.plan, obstacles=boxes))


# -- cells that have changed since ------------------------------------------------------------


def _changed(case: Case, files: Files, **changes) -> Case:
    """Another cell, for which the plan says that it was made."""
    cell = replace(case.cell, **changes)
    return Case(cell, files, case.scene, replace(case.plan, cell_digest=cell.digest))


def fixture_added(case: Case, draw: Draw) -> Case:
    at, size = np.round(_near_a_way(case, draw), 4), np.round(draw.uniform(0.005, 0.06, 3), 4)
    files = case.files.copied()
    solid = {"name": "post", "shape": "box", "size_mm": size * 1000}
    files.cell.setdefault("fixture", []).append(
        {"name": "new", "position_mm": at * 1000, "solid": [solid]}
    )
    new = Fixture("new", pose_from_rpy(at), (Solid("post", Box(size), pose_from_rpy(np.zeros(3))),))
    return _changed(case, files, fixtures=(*case.cell.fixtures, new))


def base_moved(case: Case, draw: Draw) -> Case:
    """The robot stands a little elsewhere."""
    off = draw.normal(size=3) * small(draw, 0.0001, 0.02)
    off[2] = abs(off[2])
    files = case.files.copied()
    robot = files.cell["robot"]
    robot["position_mm"] = np.array(robot.get("position_mm", (0, 0, 0))) + off * 1000
    return _changed(case, files, T_world_robot=pose_from_rpy(off) * case.cell.T_world_robot)


def other_tool(case: Case, draw: Draw) -> Case:
    """A solid of the tool larger or smaller: all arms that carry it have another."""
    files, name = case.files.copied(), one_of(case.cell.arms, draw).tool.name
    table = next(tool for tool in files.cell["tool"] if tool["name"] == name)
    key = one_of([key for key in ("body", "finger") if table.get(key)], draw)
    k, factor = int(draw.integers(len(table[key]))), draw.uniform(0.7, 1.7)
    solid = table[key][k]
    for length in ("size_mm", "radius_mm", "length_mm"):
        if length in solid:
            solid[length] = np.array(solid[length]) * factor

    def tool_of(arm):
        tool = arm.tool
        if tool.name != name:
            return tool
        if key == "body":
            body = list(tool.body)
            body[k] = _scaled(body[k], factor)
            return replace(tool, body=tuple(body))
        fingers = list(tool.fingers)
        fingers[k] = replace(fingers[k], solid=_scaled(fingers[k].solid, factor))
        return replace(tool, fingers=tuple(fingers))

    arms = tuple(replace(arm, tool=tool_of(arm)) for arm in case.cell.arms)
    return _changed(case, files, arms=arms)


def _scaled(solid: Solid, factor: float) -> Solid:
    match solid.shape:
        case Box(size=size):
            return replace(solid, shape=Box(np.asarray(size) * factor))
        case Cylinder(radius=radius, length=length):
            return replace(solid, shape=Cylinder(radius * factor, length * factor))
        case _:
            return solid


def other_margins(case: Case, draw: Draw) -> Case:
    """The cell asks for more than when the plan was made: as if planned with lower margins."""
    files, policy = case.files.copied(), case.cell.policy
    key = one_of(("margin", "near_margin", "self_margin", "sink", "release"), draw)
    value = getattr(policy, key) * small(draw, 0.2, 3) + 0.002 * draw.random()
    files.cell["policy"][f"{key}_mm"] = value * 1000
    return _changed(case, files, policy=replace(policy, **{key: value}))


def slower(case: Case, draw: Draw) -> Case:
    """The cell allows another share of the joints' speeds."""
    files, share = case.files.copied(), float(draw.uniform(0.2, 0.9))
    files.cell["policy"]["speed"] = share
    return _changed(case, files, policy=replace(case.cell.policy, speed=share))


def grasp_changed(case: Case, draw: Draw) -> Case:
    """The grasp that is used switched off, for another arm or tool, or of another length."""
    one, files = one_of(case.plan.arms, draw), case.files.copied()
    kind = case.plan.detections[one.detection].part
    changes, words = one_of(
        [
            ({"is_enabled": False}, {"enabled": False}),
            ({"arms": ("third",)}, {"arms": ["third"]}),
            ({"arms": (one.arm,)}, {"arms": [one.arm]}),
            ({"tool": "hook"}, {"tool": "hook"}),
            ({"approach_length": 0.05}, {"approach_length_mm": 50}),
            ({"opening": 0.03, "grip": 0.02}, {"opening_mm": 30, "grip_mm": 20}),
        ],
        draw,
    )
    for table in files.grasps[kind]:
        if table["name"] == one.grasp:
            table.update(words)
    part = case.cell.part(kind)
    grasps = tuple(replace(g, **changes) if g.name == one.grasp else g for g in part.grasps)
    other = replace(part, library=GraspLibrary(grasps))
    parts = tuple(other if p.name == kind else p for p in case.cell.parts)
    return _changed(case, files, parts=parts)


def place_moved(case: Case, draw: Draw) -> Case:
    """An arm's places are elsewhere than when the plan was made."""
    one, files, off = one_of(case.plan.arms, draw), case.files.copied(), draw.normal(size=3)
    off *= small(draw, 0.0001, 0.01)
    for place in files.arm(one.arm)["place"]:
        place["position_mm"] = np.array(place["position_mm"]) + off * 1000
    shift = pose_from_rpy(off)
    arms = tuple(
        replace(arm, Ts_world_place=tuple(shift * T for T in arm.Ts_world_place))
        if arm.name == one.arm
        else arm
        for arm in case.cell.arms
    )
    return _changed(case, files, arms=arms)


def bin_moved(case: Case, draw: Draw) -> Case:
    off, files = draw.normal(size=3) * small(draw, 0.0002, 0.01), case.files.copied()
    files.cell["bin"]["position_mm"] = np.array(files.cell["bin"]["position_mm"]) + off * 1000
    moved_bin = replace(case.cell.bin, T_world_bin=pose_from_rpy(off) * case.cell.bin.T_world_bin)
    return _changed(case, files, bin=moved_bin)


KINDS: tuple[Bend, ...] = (
    moved, dropped, cut_short, swung, doubled, reversed_, swapped, other_order, timed, shuffled,
    turned_in_hand, opened, other_grasp, other_part, put_elsewhere, other_word, sunk, pushed, added,
    removed, seen, fixture_added, base_moved, other_tool, other_margins, slower, grasp_changed,
    place_moved, bin_moved,
)  # fmt: skip
