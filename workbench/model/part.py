"""A part to be picked, its grasps, its bin, and its target poses."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from workbench.model.digest import LATER, FactsRepr, Shared, digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import (
    Bools,
    Box,
    Floats,
    Mesh,
    Solid,
    frozen,
    own,
    pose_from_rpy,
    put,
    transform,
)
from workbench.model.messages.cells import CellText
from workbench.model.symmetry import Symmetry, make_turn

SAME_PLACE, SAME_TURN = 5e-4, np.deg2rad(0.5)
"""[m, rad] Grips that differ by less are the same."""


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """Where and how a tool takes the part.  The TCP's z axis points into the part.

    `approach` (3,) and `retreat` (3,) are unit directions of travel in the TCP frame, with lengths
    in m: the tool arrives along `approach` over `approach_length`.  When `retreat` is None the
    extraction follows the cell's policy.  `opening` [m] is that of the fingers on arrival, `grip`
    [m] that on the part.  `arms`, `tool` and `tcp` restrict the grasp; empty means any.  The tool
    may rotate by `free_rotation` [rad] about its z, both ways, and by `tilt` [rad] about its
    closing axis y; it may shift by `slide` [m] along its x.  `is_found`: for one part only.
    """

    name: str
    T_part_tcp: pin.SE3
    opening: float
    grip: float
    approach: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    approach_length: float = 0.06
    retreat: Floats | None = None
    retreat_length: float = 0.1
    priority: int = 0
    is_enabled: bool = True
    arms: tuple[str, ...] = ()
    free_rotation: float = 0.0
    tool: str = ""
    tilt: float = 0.0
    slide: float = 0.0
    is_found: bool = field(default=False, metadata=LATER)
    tcp: str = field(default="", metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_part_tcp", "approach", "retreat")


@dataclass(frozen=True, slots=True, eq=False)
class GraspPattern:
    """One grasp repeated around, along and across an axis.

    The axis runs along `axis` (3,) through `through` (3,) [m].  Copies are shifted by each of
    `offsets` [m] along the axis and by each of `across_offsets` [m] along `across` (3,).  Then they
    are turned by each of `angles` [rad] about the axis.
    """

    grasp: Grasp
    axis: Floats
    angles: tuple[float, ...] = (0.0,)
    offsets: tuple[float, ...] = (0.0,)
    through: Floats = field(default_factory=lambda: np.zeros(3))
    across: Floats = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    across_offsets: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        own(self, "axis", "through", "across")

    @property
    def name(self) -> str:
        """That of the grasp which is repeated."""
        return self.grasp.name

    @property
    def count(self) -> int:
        """How many grasps it stands for."""
        return len(self.angles) * len(self.offsets) * len(self.across_offsets)

    @property
    def grasps(self) -> tuple[Grasp, ...]:
        """The copies, named `<name>-<row>-<column>` by offset and angle, counted from 1.

        With several offsets across, their number comes third.
        """
        return tuple(
            replace(
                self.grasp,
                name=f"{self.grasp.name}-{row}-{column}{f'-{third}' if third else ''}",
                T_part_tcp=make_turn(self.axis, angle, self.through)
                * pin.SE3(np.eye(3), offset * self.axis + beside * self.across)
                * self.grasp.T_part_tcp,
            )
            for row, offset in enumerate(self.offsets, start=1)
            for column, angle in enumerate(self.angles, start=1)
            for third, beside in self._across()
        )

    def _across(self) -> Iterator[tuple[int, float]]:
        is_one = len(self.across_offsets) == 1
        yield from ((0 if is_one else k, d) for k, d in enumerate(self.across_offsets, start=1))


Entry = Grasp | GraspPattern
"""What is authored as one thing."""


@dataclass(frozen=True, slots=True, eq=False)
class GraspPair:
    """While one arm takes a part by `first`, the other takes one by `second`: names of entries.

    `is_ordered`: the arm with `first` goes first.
    """

    first: str
    second: str
    is_ordered: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class GraspLibrary:
    """All grasps of a part, as authored: single grasps and patterns.

    `pairs`: if there are any, two arms take parts of this kind only by these pairs.
    `searches`: if no grasp takes a part, a planning searches all grips of the tools.
    `grasps` holds all single grasps, with patterns expanded, in authored order.
    """

    entries: tuple[Entry, ...] = ()
    pairs: tuple[GraspPair, ...] = ()
    searches: bool = field(default=False, metadata=LATER)
    grasps: tuple[Grasp, ...] = field(init=False, repr=False, metadata={"derived": True})

    def __post_init__(self) -> None:
        put(self, grasps=tuple(grasp for entry in self.entries for grasp in grasps_of(entry)))

    def allows(self, first: str, second: str) -> bool:
        """Whether two arms may take parts by these grasps, the first one going first."""
        if not self.pairs:
            return True
        first_name, second_name = (
            None if entry is None else entry.name for entry in map(self.entry_of, (first, second))
        )
        return any(
            (pair.first, pair.second) == (first_name, second_name)
            or (not pair.is_ordered and (pair.second, pair.first) == (first_name, second_name))
            for pair in self.pairs
        )

    def entry_of(self, grasp: str) -> Entry | None:
        """The entry that a grasp, or what a symmetry makes of one, comes from; None: of none."""
        authored = grasp.split(TURN_MARK)[0]
        return next((e for e in self.entries for g in grasps_of(e) if g.name == authored), None)


DOWN, PLACE_LIFT = (0.0, 0.0, -1.0), 0.05
"""The direction of the last linear motion to a place; [m] its length."""


@dataclass(frozen=True, slots=True, eq=False)
class PartPlace:
    """Target pose of a part at the release, with any grasp.

    `T_world_part` is the pose; poses by the part's symmetry are equivalent.  `part` is its kind;
    empty: any.  The part may be rotated by up to `free_rotation` [rad] about the z of
    `T_world_part`, both ways.  `tolerance` [m] of its origin and `turn_tolerance` [rad] limit the
    error of a plan.  `approach` (3,) is the direction of the last linear motion, `length` [m] long.

    Places of a `pallet` with layers have its number, from 1 for each arm; 0: no pallet.  `layer`
    counts from 1, the lowest.  A place is available when all places beneath are full and none
    above is.  `name` is for recipes; several places may share it.  `centred` [m, rad] are the
    standard deviations in a nest that centres the part; None without one.
    """

    T_world_part: pin.SE3
    part: str = ""
    free_rotation: float = 0.0
    tolerance: float = 0.002
    turn_tolerance: float = np.deg2rad(3.0)
    approach: tuple[float, float, float] = field(default=DOWN, metadata=LATER)
    pallet: int = field(default=0, metadata=LATER)
    layer: int = field(default=1, metadata=LATER)
    name: str = field(default="", metadata=LATER)
    length: float = field(default=PLACE_LIFT, metadata=LATER)
    centred: tuple[float, float] | None = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_world_part")

    def is_for(self, part: str) -> bool:
        """Whether parts of that kind may lie there."""
        return self.part in ("", part)


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """A level surface on which an arm may put a part to regrasp it.

    `T_base_station` is the middle of the surface with z up, in the frame of its fixture, or of the
    world if the fixture is empty.  `size` (2,) [m] is along its x and y.
    """

    name: str
    T_base_station: pin.SE3
    size: Floats
    fixture: str = ""

    def __post_init__(self) -> None:
        own(self, "T_base_station", "size")


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A box in which parts are searched and taken: a compartment, or the usable part of a bin.

    `T_bin_region` is the middle of its lower side with z up, in the frame of the bin; `size` (3,)
    [m] along its axes.
    """

    name: str
    T_bin_region: pin.SE3
    size: Floats

    def __post_init__(self) -> None:
        own(self, "T_bin_region", "size")

    def near(self, p_bin: Floats, by: float = 0.0) -> Bools:
        """Which points (n, 3) [m] in the bin's frame are in it, or at most `by` [m] outside."""
        half, p = self.size / 2, transform(self.T_bin_region.inverse(), p_bin)
        return np.asarray(np.all(np.abs(p - [0.0, 0.0, half[2]]) <= half + by, axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class Bin:
    """An open box, or without walls a surface, on which parts lie; z up from its middle.

    `size` (3,) [m]: inner length and width, and height of the walls; without `has_walls`, the
    height up to which parts may lie.  `wall` [m] is the thickness of floor and walls.  If there are
    `regions`, parts are taken only from these.  Several bins have names, and numbers from 1 on.
    `p_world_drop` [m] is the TCP's position for dropping a part back; None: over the bin.
    """

    T_world_bin: pin.SE3
    size: Floats
    wall: float = 0.003
    has_walls: bool = field(default=True, metadata=LATER)
    regions: tuple[Region, ...] = field(default=(), metadata=LATER)
    name: str = field(default="", metadata=LATER)
    number: int = field(default=0, metadata=LATER)
    p_world_drop: tuple[float, ...] | None = field(default=None, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_world_bin", "size")

    def gives(self, part: "Part", T_world_part: pin.SE3) -> bool:
        """Whether a part may be taken where it lies: by its middle, within the regions if any.

        Without regions it is all in a bin with walls, and what is over a floor without.
        """
        if self.has_walls and not self.regions:
            return True
        p_bin = self.T_world_bin.actInv(T_world_part).act(part.mesh.middle)
        if self.regions:
            return any(region.near(p_bin[None])[0] for region in self.regions)
        return bool((np.abs(p_bin[:2]) <= self.size[:2] / 2).all())

    @property
    def solids(self) -> tuple[Solid, ...]:
        """Floor, and walls where it has any, as boxes in its frame: floor, x+, x-, y+, y-."""
        (length, width, height), wall = self.size, self.wall
        outer, colour = (length + 2 * wall, width + 2 * wall), (0.45, 0.52, 0.6)

        def slab(name: str, size: tuple[float, ...], centre: tuple[float, ...]) -> Solid:
            return Solid(f"bin_{name}", Box(np.array(size)), pose_from_rpy(centre), colour)

        if not self.has_walls:
            return (slab("floor", (length, width, wall), (0, 0, -wall / 2)),)
        return (
            slab("floor", (*outer, wall), (0, 0, -wall / 2)),
            slab("wall_front", (wall, outer[1], height), ((length + wall) / 2, 0, height / 2)),
            slab("wall_back", (wall, outer[1], height), (-(length + wall) / 2, 0, height / 2)),
            slab("wall_left", (length, wall, height), (0, (width + wall) / 2, height / 2)),
            slab("wall_right", (length, wall, height), (0, -(width + wall) / 2, height / 2)),
        )


TURN_MARK = "@"
"""In a grasp's name, before the turn of the part's symmetry that it comes from."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Part(Shared, FactsRepr):
    """A part: its surface, convex solids for collision and physics, symmetry and grasps.

    `grasps` are those of library and symmetry, without repeats, opened by `tolerance`.  `friction`
    (no unit) is that against the hand, `tolerance` [m] the largest distance of the surface from the
    mesh; None: not stated.  `colours` (m, 3) of triangles, sRGB 0..255, decide between kinds or
    rotations.  The part is `scale` times as large as its file, its surface `offset` [m] outside.
    In the hand, `upright` (3,) is at most `tilt` [rad] from vertical; None: it may rotate.
    """

    name: str
    mesh: Mesh
    pieces: tuple[Solid, ...]
    mass: float
    symmetry: Symmetry
    library: GraspLibrary
    friction: float | None = field(default=None, metadata=LATER)
    colours: np.ndarray | None = field(default=None, metadata=LATER)
    tolerance: float | None = field(default=None, metadata=LATER)
    scale: float = field(default=1.0, metadata=LATER)
    offset: float = field(default=0.0, metadata=LATER)
    upright: Floats | None = field(default=None, metadata=LATER)
    tilt: float = field(default=0.0, metadata=LATER)
    digest: str = field(init=False, repr=False)
    grasps: tuple[Grasp, ...] = field(init=False, repr=False, metadata={"derived": True})

    def __post_init__(self) -> None:
        if self.colours is not None:
            shape, count = np.shape(self.colours), len(self.mesh.triangles)
            if shape != (count, 3):
                given = {"part": self.name, "triangles": count, "shape": str(shape)}
                raise InputError(CellText.TRIANGLE_COLOURS(**given))
            put(self, colours=frozen(self.colours, np.uint8))
        if self.upright is not None:
            put(self, upright=frozen(self.upright / np.linalg.norm(self.upright)))
        authored = with_symmetry(self.library, self.symmetry)
        grasps = tuple(widen_grasp(grasp, self.tolerance) for grasp in authored)
        put(self, digest=digest_of(self), grasps=grasps)

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        size = " x ".join(f"{side * 1000:.0f}" for side in np.ptp(self.mesh.points, axis=0))
        counts = {"grasps": len(self.grasps), "triangles": len(self.mesh.triangles)}
        return {"name": self.name, "mm": size, **counts}


def grasps_of(entry: Entry) -> tuple[Grasp, ...]:
    """The grasps that an entry stands for."""
    return entry.grasps if isinstance(entry, GraspPattern) else (entry,)


def widen_grasp(grasp: Grasp, tolerance: float | None) -> Grasp:
    """The grasp, if it closes, open on arrival for a part `tolerance` [m] larger all around."""
    if not tolerance or grasp.grip == 0.0:
        return grasp
    return replace(grasp, opening=grasp.opening + 2 * tolerance)


def with_symmetry(library: GraspLibrary, symmetry: Symmetry) -> tuple[Grasp, ...]:
    """The grasps of a library, and what a symmetry makes of them, no grip twice."""
    found, turns = list(library.grasps), symmetry.turns
    # Where the grips found so far are: only those nearby are compared, as a gear has thousands.
    places = np.empty((len(found) * (1 + len(turns)), 3))
    for row, grasp in enumerate(found):
        places[row] = grasp.T_part_tcp.translation
    for grasp in library.grasps:
        for turn, motion in turns:
            T = motion * grasp.T_part_tcp
            copy = replace(grasp, name=f"{grasp.name}{TURN_MARK}{turn}", T_part_tcp=T)
            far = np.abs(places[: len(found)] - T.translation).max(axis=1)
            # In its own frame a grip may differ by SAME_PLACE along each axis.
            near = np.flatnonzero(far <= 2.0 * SAME_PLACE)
            if not any(is_same_grip(found[row], copy) for row in near):
                places[len(found)] = T.translation
                found.append(copy)
    return tuple(found)


def is_same_grip(grasp: Grasp, other: Grasp) -> bool:
    """Whether another grasp takes the part as this one does, its free rotation included."""
    T = grasp.T_part_tcp.actInv(other.T_part_tcp)
    if np.abs(T.translation).max() > SAME_PLACE or T.rotation[2, 2] < np.cos(SAME_TURN):
        return False
    # Fingers that close on something can change places.
    half = np.pi if grasp.grip > 0 else 2 * np.pi
    turn = np.arctan2(T.rotation[1, 0], T.rotation[0, 0]) % half
    is_turned = min(turn, half - turn) <= grasp.free_rotation + SAME_TURN
    first, second = ((g.arms, g.tool, g.tcp) for g in (grasp, other))
    return bool(is_turned) and first == second
