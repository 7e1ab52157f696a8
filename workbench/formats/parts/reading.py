"""Parts and their grasps: `part.toml` and `grasps.toml`, in millimetres and degrees."""

from collections import Counter
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.shipped import find
from workbench.formats.files.toml_keys import MISSING, Table, quote, read_toml
from workbench.formats.meshes.face_colours import read_face_colours
from workbench.formats.meshes.pieces.convex_pieces import groups_of, pieces_of
from workbench.formats.meshes.solids import read_mesh_entry, read_solid
from workbench.formats.parts.scales import (
    LEAST_SCALE,
    MOST_OFFSET,
    MOST_SCALE,
    grow_mesh,
    grow_solid,
    scale_mesh,
    scale_solid,
)
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats, Mesh, Solid
from workbench.model.part import (
    TURN_MARK,
    Entry,
    Grasp,
    GraspLibrary,
    GraspPair,
    GraspPattern,
    Part,
)
from workbench.model.symmetry import MOST_FOLD, Symmetry, SymmetryAxis

MOST_PIECES = 128
"""That a mesh is divided into."""

MOST_GROUPS, GROUPED = 16, 10
"""More pieces than these are put into groups, which may be this many times as much too large."""

BODY_TOLERANCE, BODY_TOLERANCE_SHARE = 0.0005, 0.005
"""[m] By which they may be larger than the mesh; the share is that of its longest side."""

MOST_GRASPS = 10_000
"""Of one part, patterns and symmetry written out."""

MOST_FRICTION = 5.0
"""Of what is held, no unit: nothing dry that fingers are lined with has more."""

LONGEST_NAME = 60
"""Characters in the name of a grasp."""

LEAST_TILT_DEG, MOST_TILT_DEG = 1.0, 85.0
"""That a part which stays upright may have."""

ROUNDED = 1e-5
"""What two directions may lack to a right angle: they are written with six digits."""


def read_part(name: str | Path, shape: tuple[float, float] | None = None) -> Part:
    """A part by name under `parts/`, or by the path of its folder or `part.toml`.

    Without `[[piece]]` tables its mesh is divided into convex pieces that are no more than
    `tolerance_mm` too large, as long as `MOST_PIECES` are enough.

    Args:
        name: of the part.
        shape: its size over its CAD file, no unit, and by which its surface lies outside of that
            [m]; None: as the file states them.

    Raises:
        FileError: names the file and the key that is wrong.
    """
    place = find("parts", str(name))
    path = place / "part.toml" if place.is_dir() else place
    table = read_toml(path)
    part_name = table.text("name")
    mass = table.number("mass_g", low=0.01, high=1e6) / 1000
    friction = table.number("friction", 0.0, low=0.0, high=MOST_FRICTION) or None
    mesh_table = table.table("mesh")
    mesh = read_mesh_entry(mesh_table, convex=False)
    colours = None
    if mesh_table.flag("use_colours", False):
        colours = read_face_colours(path.parent / mesh_table.text("file"), len(mesh.triangles))
    scale = mesh_table.number("scale", 1.0, low=LEAST_SCALE, high=MOST_SCALE)
    offset = mesh_table.number("offset_mm", 0.0, low=-MOST_OFFSET, high=MOST_OFFSET) / 1000
    scale, offset = shape or (scale, offset)
    stated = mesh_table.has("tolerance_mm")
    off = mesh_table.number("tolerance_mm", 0.0, low=0.0, high=MOST_OFFSET) / 1000
    upright, tilt = read_upright(table.table("upright")) if table.has("upright") else (None, 0.0)
    mesh_table.finish()
    symmetry = _symmetry(table.table("symmetry")) if table.has("symmetry") else Symmetry()
    fixed = np.array(symmetry.point)
    as_filed, mesh = mesh, grow_mesh(scale_mesh(mesh, scale, fixed), offset)
    pieces = tuple(scale_solid(read_solid(piece), scale, fixed) for piece in table.tables("piece"))
    tolerance = table.number("tolerance_mm", tolerance_of(mesh) * 1000, low=0.01, high=100) / 1000
    # Bodies of a smaller part stay as they are: shrunk ones would no longer meet each other.
    room = off + (max(offset, 0.0) if pieces else 0.0)
    if not pieces and offset == 0.0 and scale < 1.0:
        # None is made anew: these are too large by no more than those of the file.
        pieces = tuple(scale_solid(p, scale, fixed) for p in _pieces(table, as_filed, tolerance))
    elif not pieces:
        pieces = _pieces(table, mesh, tolerance)
    if room > 0.0:
        pieces = tuple(grow_solid(piece, room) for piece in pieces)
    table.finish()
    grasps = path.parent / "grasps.toml"
    library = read_grasps(grasps) if grasps.is_file() else GraspLibrary()
    count = len(library.grasps) * (1 + len(symmetry.turns))
    if count > MOST_GRASPS:
        raise FileError(
            grasps,
            f"stands for {count:,} grasps with the symmetry written out; {MOST_GRASPS:,} are "
            "allowed",
        )
    return Part(
        part_name, mesh, pieces, mass, symmetry, library, friction, colours,
        off if stated else None, scale, offset, upright, tilt,
    )  # fmt: skip


def tolerance_of(mesh: Mesh) -> float:
    """By how much [m] convex pieces of a mesh may be larger, where its part says nothing of it."""
    return max(BODY_TOLERANCE, BODY_TOLERANCE_SHARE * float(np.ptp(mesh.points, axis=0).max()))


def _pieces(table: Table, mesh: Mesh, tolerance: float) -> tuple[Solid, ...]:
    """Convex pieces of the mesh, for collision and physics, where nobody has written any."""
    found = pieces_of(mesh, tolerance=tolerance, most=MOST_PIECES)
    if found is None:
        raise table.error("mesh", "is flat: give at least one [[piece]], for collision and physics")
    return tuple(
        Solid(f"piece_{number}", piece, pin.SE3.Identity())
        for number, piece in enumerate(
            groups_of(mesh, found, tolerance=GROUPED * tolerance, most=MOST_GROUPS), start=1
        )
    )


def _symmetry(table: Table) -> Symmetry:
    x, y, z = table.numbers("point_mm", 3, [0, 0, 0], low=-1e5, high=1e5) / 1000
    main, *also = map(_axis, (table, *table.tables("also")))
    symmetry = Symmetry(main.axis, main.fold, (x, y, z), tuple(also))
    table.finish()
    try:
        symmetry.check()
    except InputError as error:
        raise table.error("also", str(error)) from None
    return symmetry


def read_upright(table: Table) -> tuple[Floats, float]:
    """The axis (3,) that stays upright while the part is carried, and its largest tilt [rad].

    Raises:
        FileError: names the key that is wrong.
    """
    axis = _direction(table, "axis", [0, 0, 1])
    tilt = np.deg2rad(table.number("tilt_deg", low=LEAST_TILT_DEG, high=MOST_TILT_DEG))
    table.finish()
    return axis, float(tilt)


def _axis(table: Table) -> SymmetryAxis:
    return SymmetryAxis(
        _direction(table, "axis", [0, 0, 1]), table.whole("fold", low=0, high=MOST_FOLD)
    )


def read_grasps(path: Path) -> GraspLibrary:
    """All `[[grasp]]` tables of a file, in its order; one with a `pattern` stands for many.

    Raises:
        FileError: names the file and the key that is wrong.
    """
    return library_of(read_toml(path))


def library_of(table: Table) -> GraspLibrary:
    """The library in the top table of a grasp file.

    Raises:
        FileError: names the file and the key that is wrong.
    """
    path = table.path
    entries = tuple(_entry(entry) for entry in table.tables("grasp"))
    names = tuple(entry.name for entry in entries)
    pairs = tuple(_pair(pair, names) for pair in table.tables("pair"))
    searches = table.flag("search", False)
    table.finish()
    if sum(map(_copies, entries)) > MOST_GRASPS:
        raise FileError(path, f"stands for more than {MOST_GRASPS} grasps")
    for name, times in Counter(names).items():
        if times > 1:
            raise FileError(path, f"the grasp name {name!r} is used {times} times")
    library = GraspLibrary(entries, pairs, searches)
    for name, times in Counter(grasp.name for grasp in library.grasps).items():
        if times > 1:
            raise FileError(path, f"the grasp name {name!r} is used {times} times")
    return library


def _copies(entry: Entry) -> int:
    return entry.count if isinstance(entry, GraspPattern) else 1


def _pair(table: Table, names: tuple[str, ...]) -> GraspPair:
    first, second = (table.text(key, among=names) for key in ("first", "second"))
    pair = GraspPair(first, second, table.flag("ordered", False))
    table.finish()
    return pair


def _entry(table: Table) -> Entry:
    grasp = Grasp(
        name=_name(table),
        T_part_tcp=_tcp_pose(table),
        opening=table.number("opening_mm", low=0, high=1000) / 1000,
        grip=table.number("grip_mm", low=0, high=1000) / 1000,
        approach=_direction(table, "approach", [0, 0, 1]),
        approach_length=table.number("approach_length_mm", 60, low=1, high=1000) / 1000,
        retreat=_direction(table, "retreat", [0, 0, 1]) if table.has("retreat") else None,
        retreat_length=table.number("retreat_length_mm", 100, low=1, high=1000) / 1000,
        priority=table.whole("priority", 0, low=-1000, high=1000),
        is_enabled=table.flag("enabled", True),
        arms=table.texts("arms", ()),
        tool=table.text("tool", "", empty=True),
        tcp=table.text("tcp", "", empty=True),
        free_rotation=float(np.deg2rad(table.number("free_rotation_deg", 0, low=0, high=180))),
        tilt=float(np.deg2rad(table.number("tilt_deg", 0, low=0, high=90))),
        slide=table.number("slide_mm", 0, low=0, high=1000) / 1000,
    )
    if grasp.grip > grasp.opening:
        raise table.error("grip_mm", "is wider than opening_mm: the fingers could not close")
    pattern = _pattern(table.table("pattern"), grasp) if table.has("pattern") else None
    table.finish()
    return pattern or grasp


def _name(table: Table) -> str:
    name = table.text("name")
    if len(name) > LONGEST_NAME or TURN_MARK in name:
        problem = f"must be up to {LONGEST_NAME} characters without {TURN_MARK}, not {quote(name)}"
        raise table.error("name", problem)
    return name


def _tcp_pose(table: Table) -> pin.SE3:
    """TCP in the part frame from where it is, where z points, and where the fingers close (y)."""
    position = table.numbers("position_mm", 3, low=-10_000, high=10_000) / 1000
    z = _direction(table, "points_along")
    y = _direction(table, "closes_along")
    across = float(y @ z)
    if abs(across) > ROUNDED:
        raise table.error("closes_along", "must be perpendicular to points_along")
    y = y - across * z
    y /= np.linalg.norm(y)
    return pin.SE3(np.column_stack([np.cross(y, z), y, z]), position)


def _direction(table: Table, key: str, default: list[float] | None = None) -> Floats:
    usual = MISSING if default is None else default
    given = table.numbers(key, 3, usual, low=-1e6, high=1e6)
    length = float(np.linalg.norm(given))
    if length < 1e-9:
        raise table.error(key, "has no direction")
    return given / length


def _pattern(table: Table, grasp: Grasp) -> GraspPattern:
    pattern = GraspPattern(
        grasp=grasp,
        axis=_direction(table, "axis", [0, 0, 1]),
        angles=tuple(
            np.deg2rad(table.numbers("angles_deg", None, [0.0], low=-360, high=360)).tolist()
        ),
        offsets=tuple(
            (table.numbers("offsets_mm", None, [0.0], low=-10_000, high=10_000) / 1000).tolist()
        ),
        through=table.numbers("through_mm", 3, [0.0] * 3, low=-10_000, high=10_000) / 1000,
        across=_direction(table, "across", [1, 0, 0]),
        across_offsets=tuple(
            (table.numbers("across_mm", None, [0.0], low=-10_000, high=10_000) / 1000).tolist()
        ),
    )
    for key, values in (
        ("angles_deg", pattern.angles),
        ("offsets_mm", pattern.offsets),
        ("across_mm", pattern.across_offsets),
    ):
        if not values:
            raise table.error(key, "is an empty list, so the pattern would hold no grasp")
    table.finish()
    return pattern
