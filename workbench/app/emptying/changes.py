"""Single changes of a cell, by message: what an engineer would try where a bin does not empty.

Each makes another cell of a cell, or None where there is nothing to change.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
import pinocchio as pin

from workbench.model.cell import LIFT_NAMES, ORDER_NAMES, Arm, Cell, Finger, Tool
from workbench.model.derived.by_tcp import with_tcp_at
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.model.messages.changes import ChangeText
from workbench.model.messages.message import Message
from workbench.model.messages.plans import OrderText
from workbench.model.part import Entry, Grasp, GraspPattern, Part
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.kinematics.chain import chain_of, is_solution
from workbench.planning.kinematics.quickness import tool_acceleration

SUGGESTED = 12
"""Grasps that are suggested and added as spares."""

SPARE = -9
"""Their priority: behind all that people have authored."""

SAME_TURN = 1e-6
"""[rad] Turns that differ by less are one."""

MOST_TILT = np.deg2rad(60.0)


@dataclass(frozen=True, slots=True)
class Change:
    """A change as people read it, what kind it is (`CHANGE_KINDS`), and the cell with it."""

    kind: str
    said: Message
    made: Callable[[Cell], Cell | None]


def changes_of(cell: Cell) -> Iterator[Change]:
    """All changes that could be tried in a cell; some of them may change nothing in it."""
    for by in (0.001, 0.002):
        yield Change("fingers", ChangeText.FINGERS_THINNER(by=by), partial(_thinner, by=by))
    for by in (0.01, 0.02):
        yield Change("fingers", ChangeText.FINGERS_LONGER(by=by), partial(_longer, by=by))
    yield Change("fingers", ChangeText.AS_OPEN(), partial(_policy, least_air=0.0015))
    for by in (-0.006, -0.003, 0.003):
        text = ChangeText.LESS_OPEN if by < 0 else ChangeText.MORE_OPEN
        yield Change("fingers", text(by=abs(by)), partial(_open, by=by))
    for degrees in (15, 30):
        by = float(np.deg2rad(degrees))
        yield Change("grasps", ChangeText.TILTED(by=by), partial(_tilt, by=by))
    yield Change("grasps", ChangeText.MORE_TURNS(), _add_turns)
    yield Change("grasps", ChangeText.SUGGESTED(count=SUGGESTED), _suggest)
    for mm in (1, 3):
        yield Change("grasps", ChangeText.LESS_DEEP(by=mm / 1000), partial(_shallow, by=mm))
    yield Change("lifts", ChangeText.ALL_LIFTS(), partial(_policy, lifts=LIFT_NAMES))
    yield Change("lifts", ChangeText.UP_ALONE(), partial(_policy, lifts=("up",)))
    yield Change("margins", ChangeText.NEAR_MARGIN(), partial(_halve, name="near_margin"))
    yield Change("margins", ChangeText.MARGIN(), partial(_halve, name="margin"))
    yield from _of_surroundings()
    for name in ORDER_NAMES:
        says = ChangeText.ORDER(order=OrderText[name.upper()]())
        yield Change("order", says, partial(_policy, order=name))
    for arm in cell.arms:
        for tool in arm.tools:
            if tool.name != arm.tool.name:
                said = ChangeText.TOOL(arm=arm.name, tool=tool.name)
                yield Change("tool", said, partial(_with_tool, arm=arm.name, tool=tool.name))


def _of_surroundings() -> Iterator[Change]:
    """Those of the bin, the homes and the places."""
    for by in (0.01, 0.02):
        yield Change("bin", ChangeText.WALLS_LOWER(by=by), partial(_lower, by=by))
    yield Change("bin", ChangeText.BIN_NEARER(by=0.05), partial(_away, by=-0.05))
    yield Change("bin", ChangeText.BIN_FARTHER(by=0.05), partial(_away, by=0.05))
    for degrees in (45, 90):
        by = float(np.deg2rad(degrees))
        yield Change("bin", ChangeText.BIN_TURNED(by=by), partial(_bin_turned, by=by))
    yield Change("arms", ChangeText.HOME_HIGHER(by=0.05), partial(_home_higher, by=0.05))
    yield Change("arms", ChangeText.PLACES_HIGHER(by=0.03), partial(_places, rise=0.03, turn=0.0))
    turn = np.pi / 4
    yield Change("arms", ChangeText.PLACES_TURNED(by=turn), partial(_places, rise=0.0, turn=turn))


def apply_change(cell: Cell, said: Message | None) -> Cell:
    """The cell with the change that is called so; with none it is as it was."""
    if said is None:
        return cell
    by_message = {change.said: change for change in changes_of(cell)}
    return by_message[said].made(cell) or cell


def _policy(cell: Cell, **values: object) -> Cell | None:
    policy = replace(cell.policy, **values)  # type: ignore[arg-type]
    return None if policy == cell.policy else replace(cell, policy=policy)


def _halve(cell: Cell, name: str) -> Cell | None:
    return _policy(cell, **{name: getattr(cell.policy, name) / 2})


def _with_tools(cell: Cell, made: Callable[[Tool], Tool | None]) -> Cell | None:
    """The cell with other tools on its arms."""
    tools = [made(arm.tool) for arm in cell.arms]
    if not any(tools):
        return None
    arms = tuple(
        replace(arm, tool=tool or arm.tool) for arm, tool in zip(cell.arms, tools, strict=True)
    )
    return replace(cell, arms=arms)


def _thinner(cell: Cell, by: float) -> Cell | None:
    """Fingers that are boxes, less thick on the outside."""
    return _with_tools(
        cell, lambda tool: _with_fingers(tool, lambda finger: np.asarray(finger.direction), -by)
    )


def _longer(cell: Cell, by: float) -> Cell | None:
    """Fingers that are boxes, longer at their tips, and the TCP with them."""

    def edit(tool: Tool) -> Tool | None:
        T, out = tool.T_flange_tcp, tool.T_flange_tcp.rotation[:, 2]
        longer = _with_fingers(tool, lambda finger: out, by)
        tcp = pin.SE3(T.rotation, T.translation + by * out)
        return None if longer is None else with_tcp_at(longer, tcp)

    return _with_tools(cell, edit)


def _with_fingers(tool: Tool, way: Callable[[Finger], np.ndarray], by: float) -> Tool | None:
    """The tool with every finger resized along its way; None where one cannot be, or none is."""
    solids = [_resize(finger.solid, way(finger), by) for finger in tool.fingers]
    fingers = tuple(
        replace(finger, solid=solid)
        for finger, solid in zip(tool.fingers, solids, strict=True)
        if solid is not None
    )
    is_whole = fingers and len(fingers) == len(tool.fingers)
    return replace(tool, fingers=fingers) if is_whole else None


def _resize(solid: Solid, way: np.ndarray, by: float) -> Solid | None:
    """A box longer by so much [m] to the side of `way`; None where it is none, or lies askew."""
    T = solid.T_owner_shape
    along = T.rotation.T @ way
    axis = int(np.argmax(np.abs(along)))
    if not isinstance(solid.shape, Box) or abs(along[axis]) < 0.999:
        return None
    size = np.array(solid.shape.size)
    if size[axis] + by <= 0.0005:
        return None
    size[axis] += by
    moved = pin.SE3(T.rotation, T.translation + by / 2 * way)
    return replace(solid, shape=Box(size), T_owner_shape=moved)


def _with_grasps(cell: Cell, made: Callable[[Part], tuple[Entry, ...] | None]) -> Cell | None:
    """The cell with other grasps of its parts."""
    found = [made(part) for part in cell.parts]
    if not any(found):
        return None
    parts = tuple(
        part if entries is None
        else replace(part, library=replace(part.library, entries=entries))
        for part, entries in zip(cell.parts, found, strict=True)
    )  # fmt: skip
    return replace(cell, parts=parts)


def _each(part: Part, made: Callable[[Grasp], Grasp]) -> tuple[Entry, ...] | None:
    """The library with every grasp made into another; None where none is."""
    before = [grasp_of(entry) for entry in part.library.entries]
    after = [made(grasp) for grasp in before]
    if all(a is b for a, b in zip(after, before, strict=True)):
        return None
    return tuple(map(with_grasp, part.library.entries, after))


def _open(cell: Cell, by: float) -> Cell | None:
    """As far as all fingers can go that open for a grasp as it is."""
    strokes = [arm.tool.stroke for arm in cell.arms if arm.tool.fingers]

    def edit(grasp: Grasp) -> Grasp:
        able = [(low, high) for low, high in strokes if low <= grasp.opening <= high]
        if not able:
            return grasp
        lows, highs = zip(*able, strict=True)
        wide = min(max(grasp.opening + by, grasp.grip + 0.002, *lows), *highs)
        is_changed = (wide - grasp.opening) * by > 0.0
        return replace(grasp, opening=wide) if is_changed else grasp

    return _with_grasps(cell, lambda part: _each(part, edit))


def _tilt(cell: Cell, by: float) -> Cell | None:
    def edit(grasp: Grasp) -> Grasp:
        tilt = max(grasp.tilt, min(grasp.tilt + by, MOST_TILT))
        return grasp if tilt == grasp.tilt else replace(grasp, tilt=tilt)

    return _with_grasps(cell, lambda part: _each(part, edit))


def _add_turns(cell: Cell) -> Cell | None:
    """Between every two turns of a pattern one more."""

    def edit(part: Part) -> tuple[Entry, ...] | None:
        entries = tuple(
            replace(entry, angles=(*entry.angles, *more))
            if isinstance(entry, GraspPattern) and (more := _between(entry.angles))
            else entry
            for entry in part.library.entries
        )
        same = all(a is b for a, b in zip(entries, part.library.entries, strict=True))
        return None if same else entries

    return _with_grasps(cell, edit)


def _between(angles: tuple[float, ...]) -> list[float]:
    """The middles [rad] between turns, from the last to the first only where they go all around."""
    every = sorted(angles)
    gaps = [b - a for a, b in pairwise(every)]
    if gaps and 2 * np.pi - (every[-1] - every[0]) < max(gaps) + SAME_TURN:
        gaps.append(2 * np.pi - (every[-1] - every[0]))
    return [a + gap / 2 for a, gap in zip(every, gaps, strict=False) if gap > SAME_TURN]


def _shallow(cell: Cell, by: int) -> Cell | None:
    """Copies of all grasps that reach less deep, as spares behind their own."""

    def edit(part: Part) -> tuple[Entry, ...]:
        def copy(grasp: Grasp) -> Grasp:
            T = grasp.T_part_tcp
            back = pin.SE3(T.rotation, T.act(np.array([0.0, 0.0, -by / 1000])))
            name, priority = f"{grasp.name}-less-deep", min(grasp.priority, 0) - 1
            return replace(grasp, name=name, T_part_tcp=back, priority=priority)

        more = _each(part, copy) or ()
        return (*part.library.entries, *more)

    return _with_grasps(cell, edit)


def _suggest(cell: Cell) -> Cell | None:
    def edit(part: Part) -> tuple[Entry, ...]:
        tool = cell.arms[0].tool
        found = suggest(
            part,
            tool,
            most=SUGGESTED,
            seed=0,
            name="what-if",
            acceleration=tool_acceleration(cell, tool),
        )
        more = tuple(replace(suggestion.grasp, priority=SPARE) for suggestion in found)
        return (*part.library.entries, *more)

    return _with_grasps(cell, edit)


def _lower(cell: Cell, by: float) -> Cell | None:
    size = np.array(cell.bin.size)
    if size[2] - by < by:
        return None
    size[2] -= by
    return replace(cell, bin=replace(cell.bin, size=size))


def _move(cell: Cell, T_bin_moved: pin.SE3) -> Cell:
    """The cell with its bin moved, and the scanner with it."""
    T = cell.bin.T_world_bin * T_bin_moved
    step = T * cell.bin.T_world_bin.inverse()
    mount = replace(cell.scanner, T_world_scanner=step * cell.scanner.T_world_scanner)
    return replace(cell, bin=replace(cell.bin, T_world_bin=T), scanner=mount)


def _away(cell: Cell, by: float) -> Cell | None:
    """The bin farther from the middle between the arms' first joints, on the level."""
    feet = np.mean([chain_of(cell, arm).p[0] for arm in cell.arms], axis=0)
    way = cell.bin.T_world_bin.translation - feet
    way[2] = 0.0
    if np.linalg.norm(way) < 2 * abs(by):
        return None
    step = by * way / np.linalg.norm(way)
    return _move(cell, pin.SE3(np.eye(3), cell.bin.T_world_bin.rotation.T @ step))


def _bin_turned(cell: Cell, by: float) -> Cell:
    return _move(cell, pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, by)))


def _home_higher(cell: Cell, by: float) -> Cell | None:
    homes = [_risen(cell, arm, by) for arm in cell.arms]
    arms = tuple(
        replace(arm, home=home)
        for arm, home in zip(cell.arms, homes, strict=True)
        if home is not None
    )
    return replace(cell, arms=arms) if len(arms) == len(cell.arms) else None


def _risen(cell: Cell, arm: Arm, by: float) -> np.ndarray | None:
    chain = chain_of(cell, arm)
    T = chain.pose(np.asarray(arm.home))
    T = pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, by]))
    answers, residuals = chain.solve(T, np.asarray(arm.home)[None])
    return answers[0] if is_solution(residuals)[0] else None


def _places(cell: Cell, rise: float, turn: float) -> Cell | None:
    def edit(arm: Arm) -> Arm:
        more = tuple(
            pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, rise]))
            * pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, turn))
            for T in arm.Ts_world_place
        )
        return replace(arm, Ts_world_place=(*arm.Ts_world_place, *more))

    if not any(arm.Ts_world_place for arm in cell.arms):
        return None
    return replace(cell, arms=tuple(map(edit, cell.arms)))


def _with_tool(cell: Cell, arm: str, tool: str) -> Cell:
    known: Mapping[str, Tool] = {other.name: other for other in cell.arm(arm).tools}
    arms = tuple(
        replace(any_arm, tool=known[tool]) if any_arm.name == arm else any_arm
        for any_arm in cell.arms
    )
    return replace(cell, arms=arms)
