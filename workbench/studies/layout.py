"""A first cell around a robot that nobody has used here: where bin, home and places could be.

It is a start for a person to change, found by trying: the bin goes where the arms reach most of
it with the tool pointing down, home is above the bin and to the arm's side, places beside it.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, Fixture, ScannerMount
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Floats, Solid, pose_from_rpy
from workbench.model.robot import Robot
from workbench.planning.collision.pairing import Phase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import Chain, chain_of
from workbench.planning.kinematics.inverse import configurations
from workbench.studies.targets import judged

FEWEST_JOINTS = 5
"""An arm with fewer turning joints cannot point its tool where it likes."""

FLANGES = (r"tool0$", r"flange$", r"link_?8$", r"hand(_link)?$", r"ee_link$", r"tool")
"""Names of links that a tool is screwed to, the surest first."""

DISTANCES = (0.4, 0.5, 0.6, 0.7)
HEIGHTS = (-0.45, -0.3, -0.15, 0.0)
"""Of the bin, as shares of the arm's reach: before the robot, and from its first joint."""

ABOUT_LEVEL = 0.2
"""How much reach a bin at the height of the arm's first joint is worth, per reach of height."""

DIRECTIONS = (0.0, np.pi / 2, -np.pi / 2, np.pi)
TURNS = (0.0, np.pi / 2, np.pi / 4, -np.pi / 4)
STARTS = 60
SAMPLES = 400
DROP = 0.02
"""[m] A part is let go of so far above a tray."""


def flanges_of(robot: Robot) -> tuple[str, ...]:
    """The links at the ends of one or two arms, as far as the joints tell.

    Raises:
        InputError: no chain has `FEWEST_JOINTS` turning joints, or there are more than two.
    """
    lengths: dict[str, int] = {}
    for joint in robot.joints:
        if joint.kind == "revolute" and not any(_beyond(robot, joint.child, "revolute")):
            lengths[joint.child] = sum(j.kind == "revolute" for j in robot.chain(joint.child))
    longest = max(lengths.values(), default=0)
    ends = [end for end, length in lengths.items() if length == longest]
    if longest < FEWEST_JOINTS or len(ends) > 2:
        names = ", ".join(ends) or "none"
        raise InputError(
            f"robot {robot.name}: its arms cannot be told from its joints (ends of chains with "
            f"{longest} turning joints: {names}); name the links that carry tools with --flange"
        )
    return tuple(_flange(robot, end) for end in ends)


def _beyond(robot: Robot, link: str, kind: str) -> Iterator[str]:
    """The links after joints of a kind somewhere beyond a link."""
    for joint in robot.joints:
        if joint.parent == link:
            if joint.kind == kind:
                yield joint.child
            yield from _beyond(robot, joint.child, kind)


def _flange(robot: Robot, end: str) -> str:
    """The link a tool is screwed to, among those fixed to the last one that turns."""
    fixed = [end]
    for link in fixed:  # grows while it is walked
        fixed += [j.child for j in robot.joints if j.parent == link and j.kind == "fixed"]
    for pattern in FLANGES:
        for link in fixed:
            if re.search(pattern, link):
                return link
    return end


def without_hands(robot: Robot, flanges: Sequence[str]) -> tuple[Robot, tuple[str, ...]]:
    """The robot without what hangs on its flanges, and the names of what was left out."""
    gone: list[str] = []
    for flange in flanges:
        ends = [flange]
        for link in ends:  # grows while it is walked
            ends += [joint.child for joint in robot.joints if joint.parent == link]
        gone += [link for link in ends[1:] if link not in flanges]
    links = tuple(link for link in robot.links if link.name not in gone)
    joints = tuple(joint for joint in robot.joints if joint.child not in gone)
    return Robot(robot.name, links, joints, robot.disabled_pairs), tuple(gone)


def laid_out(cell: Cell, *, moves_bin: bool = True) -> Cell:
    """The cell with its bin where the arms reach it best, homes, places, table and scanner.

    Args:
        cell: with its arms and tools, and fixtures that are kept; a table is added when there
            are none.
        moves_bin: False leaves the bin where it is.

    Raises:
        InputError: the arms reach no bin before, beside or behind the robot.
    """
    if not moves_bin:
        return _with_places(_with_homes(_with_scanner(cell)))
    reach, feet = _reach(cell), _feet(cell)
    before = cell
    best = -1.0
    for direction, share, height in product(DIRECTIONS, DISTANCES, HEIGHTS):
        out = np.array([np.cos(direction), np.sin(direction), 0.0])
        p = np.round(feet + share * reach * out + [0, 0, height * reach], 2)
        tried = replace(
            before, bin=replace(before.bin, T_world_bin=pose_from_rpy(p, (0, 0, direction)))
        )
        reached = _share_reached(tried) - ABOUT_LEVEL * abs(height)
        if reached > best + 1e-9:
            best, cell = reached, tried
    if best <= 0:
        raise InputError(
            f"robot {cell.robot.name}: no bin of {_sizes(cell)} mm was found that its arms reach "
            "with the tool straight down; is z of the flange the way out of it?"
        )
    if not cell.fixtures:
        cell = _with_table(cell)
    return _with_places(_with_homes(_with_scanner(cell)))


def _sizes(cell: Cell) -> str:
    return " x ".join(f"{size * 1000:.0f}" for size in cell.bin.size)


def _reach(cell: Cell) -> float:
    """How far a tool gets from its arm's first joint, seen at random configurations [m]."""
    rng = np.random.default_rng(0)
    farthest = 0.0
    for arm in cell.arms:
        chain = chain_of(cell, arm)
        for q in rng.uniform(chain.lower, chain.upper, (SAMPLES, len(arm.joints))):
            p = chain.pose(q).translation
            farthest = max(farthest, float(np.linalg.norm(p - chain.p[0])))
    return farthest


def _feet(cell: Cell) -> Floats:
    """The middle between the first joints of the arms (3,)."""
    return np.mean([chain_of(cell, arm).p[0] for arm in cell.arms], axis=0)


def _share_reached(cell: Cell) -> float:
    """The share of a few poses in the bin that the worse arm takes up clear of everything."""
    length, width, height = cell.bin.size
    poses = [
        cell.bin.T_world_bin * pose_from_rpy((x * length, y * width, height / 3), (np.pi, 0, turn))
        for x, y in ((0, 0), (0.3, 0.3), (-0.3, 0.3), (0.3, -0.3), (-0.3, -0.3))
        for turn in (0.0, np.pi / 2)
    ]
    world = World(cell, ())
    shares: list[float] = []
    for arm in cell.arms:
        moving = frozenset({arm.name})
        world.enter(Phase(moving, {arm.name: arm.tool.stroke[1]}, straight=moving))
        found = judged(world, arm, poses, 0, among=world.pairs.alone(arm.name))
        shares.append(sum(target.q is not None for target in found) / len(found))
    return min(shares)


def _with_table(cell: Cell) -> Cell:
    """A table top under the bin, as large as bin and trays need."""
    length, width, _ = cell.bin.size
    top = Solid(
        "table_top",
        Box(np.array([length + 0.4, width + 1.0, 0.03])),
        pose_from_rpy((0, 0, -cell.bin.wall - 0.002 - 0.015)),
        (0.82, 0.8, 0.76),
    )
    return replace(cell, fixtures=(Fixture("table", cell.bin.T_world_bin, (top,)),))


def _with_scanner(cell: Cell) -> Cell:
    """A scanner that looks down at the whole bin, out of the arms' way."""
    length, width, height = cell.bin.size
    far, fov = 1.3, cell.scanner.field_of_view
    far = max(far, 1.25 * max(length, width) / (2 * np.tan(fov / 2)))
    long_side = np.pi / 2 if width > length else 0.0
    T_bin_scanner = pose_from_rpy((0, 0, height + far), (np.pi, 0, long_side))
    mount = ScannerMount(
        cell.bin.T_world_bin * T_bin_scanner,
        cell.scanner.resolution,
        fov,
        cell.scanner.depth_noise,
        near=far * 0.6,
        far=far + height + 0.2,
    )
    return replace(cell, scanner=mount)


def _with_homes(cell: Cell) -> Cell:
    """Homes above the bin's rim and to the arm's side, tool down, clear of the other arm."""
    for away, up in product((0.6, 0.9, 0.3, 0.0), (0.25, 0.15, 0.35)):
        homes = _homes(cell, away, up)
        if homes is not None:
            return replace(
                cell,
                arms=tuple(
                    replace(arm, home=home) for arm, home in zip(cell.arms, homes, strict=True)
                ),
            )
    raise InputError(
        f"robot {cell.robot.name}: no home above a bin of {_sizes(cell)} mm was found that the arm "
        "reaches clear of the table and of itself, with the tool straight down; a small arm needs "
        "a smaller bin or a shorter tool in a cell.toml of its own, as robots/tx2_90/cell.toml is"
    )


def _homes(cell: Cell, away: float, up: float) -> list[Floats] | None:
    """One clear configuration for each arm, the one nearest to the middle of its limits."""
    world = World(cell, ())
    world.enter(Phase(frozenset(arm.name for arm in cell.arms)))
    homes: dict[str, Floats] = {}
    for arm in cell.arms:
        chain = world.chains[arm.name]
        p = _beside(cell, arm, away, cell.bin.size[2] + up)
        rng = np.random.default_rng(0)
        starts = rng.uniform(chain.lower, chain.upper, (STARTS, len(arm.joints)))
        answers: list[Floats] = []
        for turn in TURNS:
            T = cell.bin.T_world_bin * pose_from_rpy(p, (np.pi, 0, turn))
            answers += list(configurations(chain, T, starts).q)
        answers.sort(key=lambda q: _awkwardness(chain, q))
        among = world.pairs.alone(arm.name) if len(homes) + 1 < len(cell.arms) else None
        for q in map(world.motion.rounded, answers):
            whole = world.configuration({**homes, arm.name: q})
            if world.contact(whole, among) is None:
                homes[arm.name] = q
                break
        else:
            return None
    return [homes[arm.name] for arm in cell.arms]


def _awkwardness(chain: Chain, q: Floats) -> tuple[bool, float]:
    """Orders configurations (n,): far from the limits first, then with the elbow high."""
    middle, half = (chain.lower + chain.upper) / 2, (chain.upper - chain.lower) / 2
    is_near_limit = bool(np.abs((q - middle) / half).max() > 0.9)
    return is_near_limit, -float(chain.joint_positions(q)[:, 2].mean())


def _beside(cell: Cell, arm: Arm, away: float, height: float) -> Floats:
    """A point (3,) in the bin's frame, `away` half widths to the arm's side of its middle."""
    side = _side(cell, arm)
    return np.array([0.0, side * away * float(cell.bin.size[1]) / 2, height])


def _side(cell: Cell, arm: Arm) -> float:
    """-1 or 1: on which side of the bin's middle, along its y, an arm works."""
    if len(cell.arms) == 1:
        return -1.0
    feet = {one.name: chain_of(cell, one).p[0] for one in cell.arms}
    T_bin_world = cell.bin.T_world_bin.inverse()
    mine = T_bin_world.act(feet[arm.name])[1]
    others = [T_bin_world.act(p)[1] for name, p in feet.items() if name != arm.name]
    return -1.0 if mine <= min(others) else 1.0


def _with_places(cell: Cell) -> Cell:
    """A tray beside the bin for each arm, where the arm reaches it."""
    arms: list[Arm] = []
    fixtures = list(cell.fixtures)
    for arm in cell.arms:
        found = _place(cell, arm)
        if found is None:
            arms.append(arm)
            continue
        places, top = found
        arms.append(replace(arm, Ts_world_place=places))
        tray = Solid("tray_top", Box(np.array([0.16, 0.16, 0.01])), pose_from_rpy((0, 0, -0.005)))
        fixtures.append(Fixture(f"tray_{arm.name}", top, (tray,)))
    return replace(cell, arms=tuple(arms), fixtures=tuple(fixtures))


def _place(cell: Cell, arm: Arm) -> tuple[tuple[pin.SE3, ...], pin.SE3] | None:
    """Poses where the arm can release a part, one turned four ways, and the tray's top."""
    world = World(cell, ())
    moving = frozenset({arm.name})
    world.enter(Phase(moving, straight=moving))
    _, width, _ = cell.bin.size
    for gap, x, height in product((0.15, 0.2, 0.28), (0.0, -0.1, 0.1), (0.08, 0.15)):
        p = np.array([x, _side(cell, arm) * (width / 2 + gap), height])
        poses = [cell.bin.T_world_bin * pose_from_rpy(p, (np.pi, 0, turn)) for turn in TURNS]
        targets = judged(world, arm, poses, 0)
        clear = tuple(target.T_world_tcp for target in targets if target.q is not None)
        if clear:
            top = cell.bin.T_world_bin * pose_from_rpy(p - [0, 0, 2 * DROP])
            return clear, top
    return None
