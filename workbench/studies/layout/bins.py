"""Where the bin of a first cell could be, and how large, found by trying.

It is a start for a person to change: the bin goes where the arms reach most of it with the tool
pointing down; and where they also find homes and places, and a plan for a simulated pile; a
smaller one where none of the usual size will do.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from workbench.model.cell import Arm, Cell, Fixture, ScannerMount
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Floats, Solid, pose_from_rpy
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import Report, silent
from workbench.studies.layout.bases import front_of
from workbench.studies.layout.homes import with_homes
from workbench.studies.layout.places import with_places
from workbench.studies.layout.trial import takes_parts
from workbench.studies.targets import judge_targets

DISTANCES = (0.4, 0.5, 0.6, 0.7)
HEIGHTS = (-0.45, -0.3, -0.15, 0.0)
"""Of the bin, as shares of the arm's reach: before the robot, and from its first joint."""

SIZES = (1.0, 0.8, 0.6, 0.45)
"""Of the bin, as shares of the usual one."""

ABOUT_LEVEL = 0.2
"""How much reach a bin at the height of the arm's first joint is worth, per reach of height."""

BIN_DIRECTIONS = (0.0, np.pi / 2, -np.pi / 2, np.pi)
POSES_A_BIN = 400

REACHED_SHARE = 0.75
"""Share of poses in a bin that an arm reaches: with less a smaller one is searched for."""

BEST_TAKEN_AFTER, SEARCH_ENDS_AFTER = 40.0, 60.0
"""[s] Processor time after which the best bin found is taken, and the search ends without one."""

PATIENCE_OF_SIZE = 12.0
"""[s] Processor time after which a smaller bin is tried where no bin of a size has homes."""

SCARA_AXES = 4
"""An arm with this many axes, one of which slides, keeps its tool upright."""

TURNS_TRIED = (0.0, np.pi / 2)
"""[rad] Of the tool about the vertical, at each place in a bin."""

MOST_TRIED = 32
"""Bins of one size for which homes and places are searched for, the best first."""

MOST_WHOLE = 2
"""Bins of one size, with homes and places, from which parts are taken on trial."""

TABLE_SIDE, TABLE_END = 0.5, 0.2
"""[m] How far a table reaches beyond its bin, to either side, and before and behind it."""


@dataclass(frozen=True, slots=True, eq=False)
class LaidOut:
    """A cell with everything at its place, and what was chosen, in words.

    `takes` is whether there is a plan for a simulated pile in its bin; True where nobody tried.
    """

    cell: Cell
    notes: tuple[str, ...]
    takes: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class _Spot:
    """A bin that was tried; `reached` is the share of poses in it of the worse arm.

    `takes` is whether there is a plan for a simulated pile in it.
    """

    cell: Cell
    reached: float
    worth: float
    takes: bool = False


def laid_out(cell: Cell, *, moves_bin: bool = True, report: Report = silent) -> LaidOut:
    """The cell with its bin where the arms reach it best, homes, places, table and scanner.

    Args:
        cell: with its arms and tools, and fixtures that are kept; a table is added when there
            are none.
        moves_bin: False leaves the bin where it is, and as large.
        report: called with the share done and what is tried.

    Raises:
        InputError: the arms reach no bin before, beside or behind the robot.
    """
    if not moves_bin:
        found = with_homes(_with_scanner(cell))
        if found is None:
            raise InputError(f"robot {cell.robot.name}: {_no_home(cell)}")
        return LaidOut(with_places(found), ())
    best: _Spot | None = None
    start = processor_time()

    def is_late() -> bool:
        return processor_time() - start > (SEARCH_ENDS_AFTER if best is None else BEST_TAKEN_AFTER)

    for number, share in enumerate(SIZES):
        size = np.round(share * np.asarray(cell.bin.size), 2)
        report(number / len(SIZES), f"a place for a bin of {_mm(size)} mm")
        if is_late():
            break
        for spot in _complete(replace(cell, bin=replace(cell.bin, size=size)), report, is_late):
            report(0.5, f"a plan for parts in the bin of {_mm(size)} mm")
            tried = replace(spot, takes=takes_parts(spot.cell))
            if best is None or (tried.takes, tried.reached) > (best.takes, best.reached):
                best = tried
            if best.takes and best.reached >= REACHED_SHARE:
                return LaidOut(best.cell, tuple(_describe(cell, best)), best.takes)
    if best is None:
        raise InputError(_nothing(cell))
    return LaidOut(best.cell, tuple(_describe(cell, best)), best.takes)


def _complete(cell: Cell, report: Report, is_late: Callable[[], bool]) -> Iterator[_Spot]:
    """Whole cells with bins of one size, the best first, `MOST_WHOLE` of them."""
    spots, whole = sorted(_spots(cell, is_late), key=lambda spot: -spot.worth), 0
    start = processor_time()
    for number, spot in enumerate(spots[:MOST_TRIED]):
        is_hopeless = not whole and processor_time() - start > PATIENCE_OF_SIZE
        if is_late() or is_hopeless:
            return
        report(0.5, f"homes and places around bin {number + 1} of {_mm(cell.bin.size)} mm")
        found = with_homes(_with_scanner(spot.cell))
        if found is not None:
            placed = with_places(found)
            if all(arm.Ts_world_place for arm in placed.arms):
                whole += 1
                yield replace(spot, cell=placed)
        if whole == MOST_WHOLE:
            return


def _spots(cell: Cell, is_late: Callable[[], bool]) -> Iterator[_Spot]:
    """Bins of which the arms reach something, with a table under each; those found in time."""
    reach, feet = _reach(cell), _feet(cell)
    for direction, share, height in product(BIN_DIRECTIONS, DISTANCES, _heights(cell)):
        if is_late():
            return
        out = np.array([np.cos(direction), np.sin(direction), 0.0])
        p = np.round(feet + share * reach * out + [0, 0, height * reach], 2)
        T = pose_from_rpy(p, (0, 0, direction))
        front = front_of(cell, direction, float(p[2])) - float((p - feet) @ out)
        if front > -float(cell.bin.size[0]) / 2 - cell.bin.wall:
            continue  # the robot's base would stand in the bin
        tried = replace(cell, bin=replace(cell.bin, T_world_bin=T))
        whole = tried if cell.fixtures else _with_table(tried, front)
        reached = _share_reached(whole)
        if reached > 0:
            yield _Spot(whole, reached, reached - ABOUT_LEVEL * abs(height))


def _heights(cell: Cell) -> tuple[float, ...]:
    """Of the bin, as shares of the reach; where an arm goes up and down by one axis, its own."""
    if not any(_is_scara(cell, arm) for arm in cell.arms):
        return HEIGHTS
    reach, feet = _reach(cell), _feet(cell)
    rng = np.random.default_rng(0)
    heights: list[float] = []
    for arm in cell.arms:
        chain = chain_of(cell, arm)
        for q in rng.uniform(chain.lower, chain.upper, (POSES_A_BIN, len(arm.joints))):
            heights.append(float(chain.pose(q).translation[2] - feet[2]) / reach)
    # Low in the arm's stroke, since above the bin it needs the rest to lift a part over the rim.
    own = np.quantile(heights, (0.1, 0.2, 0.3)) - float(cell.bin.size[2]) / 2 / reach
    return tuple(float(height) for height in own)


def _is_scara(cell: Cell, arm: Arm) -> bool:
    """Whether an arm has few axes, one of which slides: it keeps its tool upright."""
    return len(arm.joints) <= SCARA_AXES and bool(np.any(chain_of(cell, arm).slides))


def _describe(usual: Cell, spot: _Spot) -> Iterator[str]:
    """What was chosen, and what a person may look at."""
    bin = spot.cell.bin
    smaller = np.any(np.asarray(bin.size) < np.asarray(usual.bin.size) - 1e-9)
    why = f", since the arm reaches none of {_mm(usual.bin.size)} mm well enough" if smaller else ""
    yield (
        f"the bin is {_mm(bin.size)} mm inside, at "
        f"{_mm(bin.T_world_bin.translation, ', ')} mm{why}; "
        f"{spot.reached:.0%} of the poses tried in it are reached: bin in cell.toml"
    )
    if not spot.takes:
        yield (
            "there is no plan for a simulated pile of two parts in the bin"
            f"{_few_axes(usual)}: another tool, --flange or --part may help, or a bin that you "
            "place yourself"
        )


def _few_axes(cell: Cell) -> str:
    """A remark on arms with fewer axes than six, in brackets."""
    axes = min(len(arm.joints) for arm in cell.arms)
    return f" (with {axes} axes an arm cannot turn its tool every way)" if axes < 6 else ""


def _no_home(cell: Cell) -> str:
    return (
        f"no home above the bin of {_mm(cell.bin.size)} mm was found that the arm reaches clear of "
        "the table and of itself, with the tool straight down"
    )


def _nothing(cell: Cell) -> str:
    sizes = [_mm(np.round(share * np.asarray(cell.bin.size), 2)) for share in SIZES]
    names = [arm.flange for arm in cell.arms]
    alone = f" For one of the arms alone: --flange {' or '.join(names)}." if len(names) > 1 else ""
    return (
        f"robot {cell.robot.name}: no bin of {' or '.join(sizes)} mm was found that its arms reach "
        f"with the tool straight down{_few_axes(cell)}, with a home and a place for parts next to "
        f"it; tried were {len(DISTANCES)} distances and {len(HEIGHTS)} heights before, beside and "
        f"behind it.{alone} "
        "Is the flange right (--flange), and its z the way out of it?"
    )


def _mm(lengths: Floats, between: str = " x ") -> str:
    return between.join(f"{value * 1000:.0f}" for value in lengths)


def _reach(cell: Cell) -> float:
    """How far a tool gets from its arm's first joint, seen at random configurations [m]."""
    rng = np.random.default_rng(0)
    farthest = 0.0
    for arm in cell.arms:
        chain = chain_of(cell, arm)
        for q in rng.uniform(chain.lower, chain.upper, (POSES_A_BIN, len(arm.joints))):
            p = chain.pose(q).translation
            farthest = max(farthest, float(np.linalg.norm(p - chain.p[0])))
    return farthest


def _feet(cell: Cell) -> Floats:
    """The middle between the first joints of the arms (3,)."""
    return np.mean([chain_of(cell, arm).p[0] for arm in cell.arms], axis=0)


def _share_reached(cell: Cell) -> float:
    """The share of a few poses in the bin that the worse arm takes up clear of everything.

    0 where an arm does not reach the middle: searches that find nothing take longest.
    """
    length, width, height = cell.bin.size
    poses = [
        cell.bin.T_world_bin * pose_from_rpy((x * length, y * width, height / 3), (np.pi, 0, turn))
        for x, y in ((0, 0), (0.3, 0.3), (-0.3, 0.3), (0.3, -0.3), (-0.3, -0.3))
        for turn in TURNS_TRIED
    ]
    middle, rest = poses[: len(TURNS_TRIED)], poses[len(TURNS_TRIED) :]
    world = World(cell, ())
    shares: list[float] = []
    for arm in cell.arms:
        moving = frozenset({arm.name})
        world.enter(LegPhase(moving, {arm.name: arm.tool.stroke[1]}, straight=moving))
        among = world.pairs.alone(arm.name)
        found = judge_targets(world, arm, middle, 0, among=among)
        if all(target.q is None for target in found):
            return 0.0
        found += judge_targets(world, arm, rest, 0, among=among)
        shares.append(sum(target.q is not None for target in found) / len(found))
    return min(shares)


def _with_table(cell: Cell, front: float) -> Cell:
    """A table top under the bin, as large as bin and trays need; `front` is where the base ends."""
    length, width, _ = cell.bin.size
    near = max(-length / 2 - TABLE_END, front + 0.01)
    far = length / 2 + TABLE_END
    top = Solid(
        "table_top",
        Box(np.array([far - near, width + 2 * TABLE_SIDE, 0.03])),
        pose_from_rpy(((near + far) / 2, 0, -cell.bin.wall - 0.002 - 0.015)),
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
