"""Klamp't robots (`.rob`) to robots.

Each link hangs on its parent by one joint, a transform and then a turn about or a slide along
`axis`.  What the format has for masses, motors and sensors is passed over; robots whose base moves
freely (`floating` and the like) are refused, since those of a cell stand where they are.

Source: https://github.com/krishauser/Klampt, manual, "File types"
"""

import math
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import MB, read_whole
from workbench.formats.meshes.reading import LARGEST_EXTENT, read_mesh
from workbench.formats.robots.urdf import read_urdf
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats, Mesh, Solid, frozen, pose_from_matrix
from workbench.model.robot import Joint, JointKind, Link, Robot

LARGEST_FILE = 10 * MB
MOST_LINKS = 1000
MOST_LEVELS = 8
"""Sub-robots within sub-robots."""

USUAL_SPEED = math.pi
"""[rad/s, m/s] Of a joint whose file gives none."""

UNIT = 1e-3
"""How far an axis may be from length 1: files carry few digits."""

WELDED = ("weld",)
FLOATING = ("floating", "floatingplanar", "ballandsocket")
GREY = (0.6, 0.6, 0.62)

Words = Mapping[str, list[list[str]]]
"""Item -> its lines, each the words after the item."""


def read_rob(path: Path, *, depth: int = 0) -> Robot:
    """A robot from a `.rob` file; links keep their names, joints are called like their links.

    Raises:
        FileError: an item has the wrong number of values or one that is none, a mesh is
            missing, parents go round in a circle.
    """
    words = _words(path)
    if depth > MOST_LEVELS:
        raise FileError(path, f"is mounted more than {MOST_LEVELS} robots deep")
    given = _numbers(path, words, "parents", None)
    parents = [round(value) for value in np.clip(given, -2, MOST_LINKS).tolist()]
    count = len(parents)
    if not 0 < count <= MOST_LINKS:
        raise FileError(path, f"parents: 1 to {MOST_LINKS} links are expected, not {count}")
    for number, parent in enumerate(parents):
        if not -1 <= parent < number:
            raise FileError(path, f"parents: link {number} hangs on {parent}, which is not before")
    names = _names(path, words, count)
    welded = _read_welds(path, words, count)
    scale = float(_numbers(path, words, "scale", 1, [1.0])[0])
    Ts = _transforms(path, words, count, scale)
    directions = _numbers(path, words, "axis", 3 * count, [0.0, 0.0, 1.0] * count)
    axes = [_unit(path, axis) for axis in directions.reshape(-1, 3)]
    kinds = _kinds(path, words, count)
    lower, upper = (_angles(path, words, item, count, default) for item, default in LIMITS)
    speed = _angles(path, words, "velmax", count, math.inf)
    root = _root_name(path.stem, names)
    links = [Link(root), *_links(path, words, names, scale)]
    joints: list[Joint] = []
    for k, name in enumerate(names):
        parent = root if parents[k] < 0 else names[parents[k]]
        is_fixed = k in welded or lower[k] == upper[k]
        T = Ts[k] * _move(kinds[k], axes[k], lower[k]) if is_fixed else Ts[k]
        kind: JointKind = "fixed" if is_fixed else kinds[k]
        limits = (max(lower[k], -_most(kind)), min(upper[k], _most(kind)))
        low, high = map(float, limits)
        if not is_fixed and not low < high:
            raise FileError(path, f"qmin, qmax: {quote(name)} would go from {low:g} to {high:g}")
        fast = float(speed[k]) if 0 < speed[k] < math.inf else USUAL_SPEED
        joints.append(Joint(name, kind, parent, name, T, axes[k], low, high, fast))
    pairs = _pairs(path, words, names)
    robot = Robot(path.stem, tuple(links), tuple(joints), pairs | _neighbours(joints))
    for line in words.get("mount", []):
        robot = _mount(path, robot, names, line, depth)
    return robot


LIMITS = (("qmin", -math.inf), ("qmax", math.inf))


def _words(path: Path) -> Words:
    try:
        text = read_whole(path, LARGEST_FILE).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(path, "is not a text file in UTF-8") from None
    found: dict[str, list[list[str]]] = {}
    plain = "\n".join(line.partition("#")[0].rstrip() for line in text.splitlines())
    for line in plain.replace("\\\n", " ").splitlines():
        try:
            words = shlex.split(line, posix=True)
        except ValueError as error:
            raise FileError(path, f"line {quote(line.strip())}: {error}") from None
        if words:
            found.setdefault(words[0].lower(), []).append(words[1:])
    if "parents" not in found:
        raise FileError(path, "has no line `parents`: is this a Klamp't robot?")
    return found


def _numbers(
    path: Path, words: Words, item: str, count: int | None, default: list[float] | None = None
) -> Floats:
    if item not in words:
        if default is None:
            raise FileError(path, f"has no line {item!r}")
        return np.array(default)
    values = [word for line in words[item] for word in line]
    try:
        numbers = np.array([float(value) for value in values])
    except ValueError:
        raise FileError(path, f"{item}: numbers are expected") from None
    if count is not None and len(numbers) != count:
        raise FileError(path, f"{item}: {count} numbers are expected, {len(numbers)} are given")
    if np.isnan(numbers).any():
        raise FileError(path, f"{item}: holds a value that is not a number")
    return numbers


def _angles(path: Path, words: Words, item: str, count: int, default: float) -> Floats:
    """Values of joints [rad, m]; `<item>deg` gives degrees."""
    if f"{item}deg" in words:
        return np.deg2rad(_numbers(path, words, f"{item}deg", count))
    return _numbers(path, words, item, count, [default] * count)


def _names(path: Path, words: Words, count: int) -> list[str]:
    names = words.get("links", [[f"link_{k}" for k in range(count)]])[0]
    if len(names) != count or len(set(names)) != count:
        raise FileError(path, f"links: {count} different names are expected")
    for name in names:
        if not name or not name.isprintable():
            raise FileError(path, f"links: {quote(name)} is no name")
    return list(names)


def _kinds(path: Path, words: Words, count: int) -> list[JointKind]:
    letters = words.get("jointtype", [["r"] * count])[0]
    known: Mapping[str, JointKind] = {"r": "revolute", "p": "prismatic"}
    if len(letters) != count or not set(letters) <= set(known):
        raise FileError(path, f"jointtype: {count} letters r or p are expected")
    return [known[letter] for letter in letters]


def _read_welds(path: Path, words: Words, count: int) -> set[int]:
    welded: set[int] = set()
    for line in words.get("joint", []):
        if not line or line[0].lower() in FLOATING:
            raise FileError(path, f"joint {' '.join(line)}: a robot that moves freely is not read")
        if line[0].lower() in WELDED:
            welded |= {_index(path, word, count) for word in line[1:]}
    return welded


def _index(path: Path, word: str, count: int) -> int:
    if not re.fullmatch(r"[0-9]{1,5}", word) or int(word) >= count:
        raise FileError(path, f"{quote(word)} is not the number of a link, 0 to {count - 1}")
    return int(word)


def _transforms(path: Path, words: Words, count: int, scale: float) -> list[pin.SE3]:
    """`T_parent_joint` of every link; rows of the rotation come first, then the translation.

    The manual speaks of columns, but Klamp't 0.10 reads rows, and its robots are written so.
    """
    if "tparent" in words:
        rows = _numbers(path, words, "tparent", 12 * count).reshape(-1, 12)
        Ts = [_pose(path, row, scale) for row in rows]
    else:
        Ts = _denavit_hartenberg(path, words, count, scale)
    shift = _numbers(path, words, "translation", 3, [0.0] * 3)
    turn = _numbers(path, words, "rotation", 9, np.eye(3).ravel().tolist())
    Ts[0] = _pose(path, np.concatenate([turn, shift]), 1.0) * Ts[0]
    return Ts


def _pose(path: Path, row: Floats, scale: float) -> pin.SE3:
    matrix = np.column_stack([row[:9].reshape(3, 3), row[9:] * scale])
    try:
        return pose_from_matrix(matrix)
    except InputError as error:
        raise FileError(path, str(error)) from None


def _denavit_hartenberg(path: Path, words: Words, count: int, scale: float) -> list[pin.SE3]:
    alpha, theta = (_angles(path, words, item, count, 0.0) for item in ("alpha", "theta"))
    a, d = (_numbers(path, words, item, count, [0.0] * count) * scale for item in ("a", "d"))
    if not any(item in words for item in ("alpha", "alphadeg", "a", "d", "theta", "thetadeg")):
        raise FileError(path, "has neither a line `tparent` nor Denavit-Hartenberg parameters")
    if not np.isfinite([alpha, theta, a, d]).all():
        raise FileError(path, "alpha, theta, a, d: finite numbers are expected")
    return [
        pin.SE3(pin.rpy.rpyToMatrix(alpha[k], 0.0, 0.0), np.array([a[k], 0.0, 0.0]))
        * pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, theta[k]), np.array([0.0, 0.0, d[k]]))
        for k in range(count)
    ]


def _move(kind: JointKind, axis: Floats, value: float) -> pin.SE3:
    if value == 0.0 or not math.isfinite(value):
        return pin.SE3.Identity()
    if kind == "prismatic":
        return pin.SE3(np.eye(3), axis * value)
    return pin.SE3(pin.exp3(axis * value), np.zeros(3))


def _most(kind: JointKind) -> float:
    return 10.0 if kind == "prismatic" else 2 * math.pi


def _unit(path: Path, axis: Floats) -> Floats:
    """An axis of length 1; a longer axis makes Klamp't move the joint further than commanded."""
    length = float(np.linalg.norm(axis))
    if not abs(length - 1.0) < UNIT:
        raise FileError(path, f"axis: must be a unit vector, {quote(axis.tolist())} is given")
    return frozen(axis / length)


def _links(path: Path, words: Words, names: list[str], scale: float) -> list[Link]:
    files = words.get("geometry", [[""] * len(names)])[0]
    if len(files) != len(names):
        raise FileError(path, f"geometry: {len(names)} files are expected, {len(files)} are given")
    scales = np.array([1.0])
    if "geomscale" in words:
        scales = _numbers(path, words, "geomscale", None)
    if len(scales) not in (1, len(names)):
        raise FileError(path, f"geomscale: 1 or {len(names)} numbers are expected")
    scales = np.broadcast_to(scales, len(names)) * scale
    turned = _geometry_transforms(path, words, names)
    links: list[Link] = []
    for k, (name, file) in enumerate(zip(names, files, strict=True)):
        if not file:
            links.append(Link(name))
            continue
        if not scales[k] > 0:
            raise FileError(path, f"geomscale: {scales[k]:g} must be positive")
        mesh = read_mesh(path.parent / file, float(scales[k]))
        if k in turned:
            mesh = _place(path, mesh, turned[k], scale)
        solid = Solid(f"{name}_0", mesh, pin.SE3.Identity(), GREY)
        links.append(Link(name, (solid,), (solid,)))
    return links


def _place(path: Path, mesh: Mesh, T: Floats, scale: float) -> Mesh:
    """A mesh moved by a transform (4, 4), which may also stretch and mirror it."""
    R, shift = T[:3, :3], T[:3, 3] * scale
    largest = max(np.abs(R).max(), np.abs(shift).max())
    if not largest < LARGEST_EXTENT or abs(np.linalg.det(R)) < 1e-9:
        raise FileError(path, f"geomtransform: {quote(T.tolist())} puts no mesh anywhere")
    is_mirrored = np.linalg.det(R) < 0
    triangles = mesh.triangles[:, ::-1] if is_mirrored else mesh.triangles
    return Mesh(mesh.points @ R.T + shift, triangles)


def _geometry_transforms(path: Path, words: Words, names: list[str]) -> dict[int, Floats]:
    found: dict[int, Floats] = {}
    for line in words.get("geomtransform", []):
        values = _numbers(path, {"geomtransform": [line[1:]]}, "geomtransform", 16)
        found[_index(path, line[0], len(names))] = values.reshape(4, 4)
    return found


def _pairs(path: Path, words: Words, names: list[str]) -> frozenset[tuple[str, str]]:
    """Pairs of links that `noselfcollision` excludes, by number or name."""
    pairs: set[tuple[str, str]] = set()
    for line in words.get("noselfcollision", []):
        ends = [w if w in names else names[_index(path, w, len(names))] for w in line]
        if len(ends) % 2:
            raise FileError(path, "noselfcollision: holds half a pair")
        for a, b in zip(ends[::2], ends[1::2], strict=True):
            pairs.add((min(a, b), max(a, b)))
    return frozenset(pairs)


def _neighbours(joints: list[Joint]) -> frozenset[tuple[str, str]]:
    """A link and its parent are not checked by Klamp't either."""
    return frozenset(
        (min(joint.parent, joint.child), max(joint.parent, joint.child)) for joint in joints
    )


def _root_name(stem: str, names: Sequence[str]) -> str:
    root = f"{stem}_root"
    while root in names:
        root += "_"
    return root


def _mount(path: Path, robot: Robot, names: list[str], line: list[str], depth: int) -> Robot:
    """The robot with another one on one of its links."""
    if len(line) < 2:
        raise FileError(path, "mount: a link and a file are expected")
    link = line[0] if line[0] in names else names[_index(path, line[0], len(names))]
    file = path.parent / line[1]
    values = line[2:14]
    T = pin.SE3.Identity()
    if len(values) == 12:
        T = _pose(path, _numbers(path, {"mount": [values]}, "mount", 12), 1.0)
    elif values and values[0].lower() != "as":
        raise FileError(path, "mount: 12 numbers are expected after the file")
    sub = read_urdf(file) if file.suffix.lower() == ".urdf" else read_rob(file, depth=depth + 1)
    known = {known_link.name for known_link in robot.links}
    prefix = f"{sub.name}_" if any(sub_link.name in known for sub_link in sub.links) else ""
    if any(prefix + sub_link.name in known for sub_link in sub.links):
        raise FileError(path, f"mount: {line[1]} is mounted twice under the same names")

    def add_prefix(name: str) -> str:
        return prefix + name

    mount = Joint(
        add_prefix(sub.root), "fixed", link, add_prefix(sub.root), T, np.array([0.0, 0.0, 1.0])
    )
    return Robot(
        robot.name,
        (
            *robot.links,
            *(replace(sub_link, name=add_prefix(sub_link.name)) for sub_link in sub.links),
        ),
        (
            *robot.joints,
            mount,
            *(
                replace(
                    joint,
                    name=add_prefix(joint.name),
                    parent=add_prefix(joint.parent),
                    child=add_prefix(joint.child),
                )
                for joint in sub.joints
            ),
        ),
        robot.disabled_pairs
        | frozenset((add_prefix(a), add_prefix(b)) for a, b in sub.disabled_pairs)
        | {(min(link, add_prefix(sub.root)), max(link, add_prefix(sub.root)))},
    )
