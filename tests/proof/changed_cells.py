"""Cells that have changed since a plan was made, by a seed; the plan says it was made for them."""

from dataclasses import replace

import numpy as np
from bent_case import Case, Draw, near_a_way, one_of, small
from judge_files import Files

from workbench.app.picking.pipeline import plan_pick
from workbench.model.cell import Arm, Cell, Fixture, Tool
from workbench.model.geometry import Box, Cylinder, Solid, pose_from_rpy
from workbench.model.motion import Corners, MotionModel
from workbench.model.part import GraspLibrary

LINKS: dict[Corners, str] = {
    "stop": "abb-socket",
    "blend": "abb-socket/2",
    "streamed": "streamed",
}
"""What a controller makes of corners, and a protocol of that kind; the last is the tests' own."""


def _changed(case: Case, files: Files, **changes) -> Case:
    """Another cell, for which the plan says that it was made."""
    cell = replace(case.cell, **changes)
    return Case(cell, files, case.scene, replace(case.plan, cell_digest=cell.digest))


def fixture_added(case: Case, draw: Draw) -> Case:
    at, size = np.round(near_a_way(case, draw), 4), np.round(draw.uniform(0.005, 0.06, 3), 4)
    files = case.files.copied()
    solid = {"name": "post", "shape": "box", "size_mm": size * 1000}
    files.cell.setdefault("fixture", []).append(
        {"name": "new", "position_mm": at * 1000, "solid": [solid]}
    )
    new = Fixture("new", pose_from_rpy(at), (Solid("post", Box(size), pose_from_rpy(np.zeros(3))),))
    return _changed(case, files, fixtures=(*case.cell.fixtures, new))


def base_moved(case: Case, draw: Draw) -> Case:
    """The robot stands a little elsewhere, or turned."""
    off = draw.normal(size=3) * small(draw, 0.0001, 0.02)
    off[2] = abs(off[2])
    turn = small(draw, 0.01, 3.0) * one_of((-1.0, 0.0, 1.0), draw)
    files = case.files.copied()
    robot = files.cell["robot"]
    robot["position_mm"] = np.array(robot.get("position_mm", (0, 0, 0))) + off * 1000
    robot["rpy_deg"] = np.array(robot.get("rpy_deg", (0, 0, 0))) + [0, 0, turn]
    return _changed(case, files, T_world_robot=_shifted(case.cell.T_world_robot, off, turn))


def _shifted(T, off, turn):
    """A pose moved by `off` (3,) [m], and turned about the axis z of its base by `turn` [deg]."""
    moved = pose_from_rpy(np.zeros(3), (0.0, 0.0, np.deg2rad(turn))) * T
    moved.translation = T.translation + off
    return moved


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

    def scaled(tool: Tool) -> Tool:
        if key == "body":
            body = list(tool.body)
            body[k] = _scaled(body[k], factor)
            return replace(tool, body=tuple(body))
        fingers = list(tool.fingers)
        fingers[k] = replace(fingers[k], solid=_scaled(fingers[k].solid, factor))
        return replace(tool, fingers=tuple(fingers))

    return _changed(case, files, arms=_with_tool(case.cell, name, scaled))


def _with_tool(cell: Cell, name: str, change) -> tuple[Arm, ...]:
    """The arms of a cell, with a tool changed on each that carries it."""
    return tuple(
        replace(arm, tool=change(arm.tool)) if arm.tool.name == name else arm for arm in cell.arms
    )


def _scaled(solid: Solid, factor: float) -> Solid:
    match solid.shape:
        case Box(size=size):
            return replace(solid, shape=Box(np.asarray(size) * factor))
        case Cylinder(radius=radius, length=length):
            return replace(solid, shape=Cylinder(radius * factor, length * factor))
        case _:
            return solid


def tool_exchanged(case: Case, draw: Draw) -> Case:
    """The tool is longer or shorter, turned on its flange, of another stroke, or gives way less."""
    files, name = case.files.copied(), one_of(case.cell.arms, draw).tool.name
    table = next(tool for tool in files.cell["tool"] if tool["name"] == name)
    tool = next(arm.tool for arm in case.cell.arms if arm.tool.name == name)
    if draw.random() < 0.6:
        off, turn = draw.normal(size=3) * small(draw, 0.0001, 0.02), small(draw, 0.01, 10.0)
        tcp = table["tcp"]
        tcp["position_mm"] = np.array(tcp["position_mm"]) + off * 1000
        tcp["rpy_deg"] = np.array(tcp.get("rpy_deg", (0, 0, 0))) + [0, 0, turn]
        changes = {"T_flange_tcp": _shifted(tool.T_flange_tcp, off, turn)}
    elif tool.fingers and draw.random() < 0.7:
        stroke = float(draw.uniform(0.0, 0.035)), float(draw.uniform(0.036, 0.06))
        table["stroke_mm"] = [value * 1000 for value in stroke]
        changes = {"stroke": stroke}
    else:
        press = tool.press * draw.uniform(0.0, 1.5)
        table["press_mm"] = press * 1000
        changes = {"press": press}
    return _changed(
        case, files, arms=_with_tool(case.cell, name, lambda tool: replace(tool, **changes))
    )


def other_margins(case: Case, draw: Draw) -> Case:
    """The cell asks for more than when the plan was made: as if planned with lower margins."""
    files, policy = case.files.copied(), case.cell.policy
    key = one_of(("margin", "near_margin", "self_margin", "sink", "release"), draw)
    value = getattr(policy, key) * small(draw, 0.2, 3) + 0.002 * draw.random()
    files.cell["policy"][f"{key}_mm"] = value * 1000
    return _changed(case, files, policy=replace(policy, **{key: value}))


def planned_closer(case: Case, draw: Draw) -> Case:
    """Planned anew with lower margins, past a fixture or what a scan shows, or for a thin tool."""
    cell, policy = case.cell, case.cell.policy
    less = {
        key: getattr(policy, key) * float(draw.uniform(0.0, 0.95))
        for key in ("margin", "near_margin", "self_margin")
    }
    lower = replace(cell, policy=replace(policy, **less))
    seen = case.scene.obstacles
    match draw.integers(4):
        case 1 if seen:
            seen = ()
        case 2 if cell.fixtures:
            gone = one_of(cell.fixtures, draw)
            lower = replace(cell, fixtures=tuple(f for f in cell.fixtures if f is not gone))
        case 3:
            name, factor = one_of(cell.arms, draw).tool.name, float(draw.uniform(0.3, 0.95))
            lower = replace(cell, arms=_with_tool(cell, name, lambda tool: _thinner(tool, factor)))
    plan = plan_pick(
        lower,
        case.scene.detections,
        case.scene.scan_digest,
        strategy=str(case.plan.strategy),
        obstacles=seen,
        seed=int(draw.integers(1000)),
    ).plan
    if plan is None:
        return case
    known = replace(plan, cell_digest=cell.digest, obstacles=case.scene.obstacles)
    return replace(case, plan=known)


def _thinner(tool: Tool, factor: float) -> Tool:
    fingers = (replace(one, solid=_scaled(one.solid, factor)) for one in tool.fingers)
    body = tuple(_scaled(solid, factor) for solid in tool.body)
    return replace(tool, body=body, fingers=tuple(fingers))


def slower(case: Case, draw: Draw) -> Case:
    """The cell allows another share of the joints' speeds, or an arm another acceleration."""
    files = case.files.copied()
    if draw.random() < 0.5:
        share = float(draw.uniform(0.2, 0.9))
        files.cell["policy"]["speed"] = share
        return _changed(case, files, policy=replace(case.cell.policy, speed=share))
    name, share = one_of(case.plan.arms, draw).arm, float(draw.uniform(0.3, 1.3))
    table = files.arm(name)
    table["acceleration_deg"] = table.get("acceleration_deg", 600) * share
    arms = tuple(
        replace(arm, acceleration=arm.acceleration * share) if arm.name == name else arm
        for arm in case.cell.arms
    )
    return _changed(case, files, arms=arms)


def other_controller(case: Case, draw: Draw) -> Case:
    """A controller that stops, rounds corners or is streamed, and rounds them more or less."""
    files, corners = case.files.copied(), one_of(tuple(LINKS), draw)
    zone = float(draw.uniform(0.05, 0.5))
    files.cell["controller"]["protocol"] = LINKS[corners]
    files.cell["policy"]["zone"] = zone
    motion = MotionModel(LINKS[corners], corners, "deg", 2, 0.01, 2)
    return _changed(
        case,
        files,
        controller=replace(case.cell.controller, motion=motion),
        policy=replace(case.cell.policy, zone=zone),
    )


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
        key = "part_position_mm" if "part_position_mm" in place else "position_mm"
        place[key] = np.array(place[key]) + off * 1000
    shift = pose_from_rpy(off)
    arms = tuple(
        replace(
            arm,
            Ts_world_place=tuple(shift * T for T in arm.Ts_world_place),
            part_places=tuple(
                replace(nest, T_world_part=shift * nest.T_world_part) for nest in arm.part_places
            ),
        )
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


def other_bin(case: Case, draw: Draw) -> Case:
    """Another bin elsewhere, often where the arms go, turned, larger, thicker or without walls."""
    files, number = case.files.copied(), int(draw.integers(len(case.cell.other_bins)))
    box, table = case.cell.other_bins[number], files.cell["other_bins"][number]
    at, turn = box.T_world_bin.translation, small(draw, 0.1, 90)
    if draw.random() < 0.6:
        at = near_a_way(case, draw)
    at = np.round(at + draw.normal(size=3) * small(draw, 0.0002, 0.02), 4)
    size, wall = np.asarray(box.size) * draw.uniform(0.2, 1.5, 3), float(draw.uniform(0.001, 0.01))
    has_walls = bool(draw.random() < 0.8)
    table |= {"position_mm": at * 1000, "rpy_deg": (0, 0, turn), "size_mm": size * 1000}
    table |= {"wall_mm": wall * 1000, "walls": has_walls}
    T = pose_from_rpy(at, (0, 0, np.deg2rad(turn)))
    moved = replace(box, T_world_bin=T, size=size, wall=wall, has_walls=has_walls)
    others = tuple(moved if known is box else known for known in case.cell.other_bins)
    return _changed(case, files, other_bins=others)


CHANGES = (
    fixture_added, base_moved, other_tool, tool_exchanged, other_margins, planned_closer, slower,
    other_controller, grasp_changed, place_moved, bin_moved,
)  # fmt: skip
