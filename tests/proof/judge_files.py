"""A cell's files as the judge reads them: by these lines alone, in metres and radians."""

import copy
import tomllib
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import trimesh
from judge_symmetry import about, made, unit


def turned(rpy_deg) -> np.ndarray:
    """The rotation (3, 3) of fixed-axis angles about x, y and z."""
    (a, b, c), R = np.deg2rad(rpy_deg), np.eye(3)
    for axis, angle in ((2, c), (1, b), (0, a)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        one = np.eye(3)
        one[i, i] = one[j, j] = np.cos(angle)
        one[j, i], one[i, j] = np.sin(angle), -np.sin(angle)
        R = R @ one
    return R


def pose_of(table) -> np.ndarray:
    """The matrix (4, 4) of `position_mm` and `rpy_deg`, in metres."""
    T = np.eye(4)
    T[:3, :3] = turned(table.get("rpy_deg", (0, 0, 0)))
    T[:3, 3] = np.array(table.get("position_mm", (0, 0, 0))) / 1000
    return T


@dataclass(eq=False)
class Files:
    """Of one cell: `cell` is its TOML file, `parts` and `grasps` are those of its kinds of parts.

    Of several bins `bin` is the one that parts are taken from, and `other_bins` are the others.
    They may be changed, as the cell may after a plan was made.  `points` (n, 4) [m] are those of a
    part's mesh.  Of the kinds `searched` any grip may be found that no file has.
    """

    folder: Path
    cell: dict[str, Any]
    parts: dict[str, dict[str, Any]]
    grasps: dict[str, list[dict[str, Any]]]
    joints: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    chains: dict[str, list[str]] = field(default_factory=dict)
    never: set[frozenset[str | None]] = field(default_factory=set)
    points: dict[str, np.ndarray] = field(default_factory=dict)
    searched: set[str] = field(default_factory=set)

    def copied(self) -> "Files":
        """The same, to be changed."""
        cell, grasps = copy.deepcopy(self.cell), copy.deepcopy(self.grasps)
        changed = {"cell": cell, "grasps": grasps}
        return replace(self, **changed)

    def arm(self, name: str) -> dict[str, Any]:
        return next(arm for arm in self.cell["arm"] if arm["name"] == name)

    def tool(self, arm: str) -> dict[str, Any]:
        name = self.arm(arm)["tool"]
        return next(tool for tool in self.cell["tool"] if tool["name"] == name)

    def meant(self, kind: str, name: str) -> list[dict[str, Any]]:
        """The grasps that a name may mean: an authored one, or what a turn of the part makes of it.

        The name has the turn behind the other's.
        """
        authored, _, turn = name.partition("@")
        found = [grasp for grasp in self.grasps[kind] if grasp["name"] == authored]
        if not turn:
            return found
        moves = made(self.parts[kind], turn)
        return [grasp | {"T": move @ grasp["T"]} for grasp in found for move in moves]

    def taken_by(self, kind: str, one) -> list[dict[str, Any]]:
        """The grasps by which an arm of a plan may take a part, or the grip that was found."""
        if one.found is None:
            return self.meant(kind, one.grasp)
        if kind not in self.searched:
            return []
        sizes = {"opening_mm": one.found.opening * 1000, "grip_mm": one.found.grip * 1000}
        return [sizes | {"name": one.grasp, "T": one.found.T_part_tcp.homogeneous}]

    def policy(self, key: str) -> float:
        """A length of the policy [m], or another number of it."""
        usual = {"sink_mm": 1.0, "release_mm": 10.0, "near_margin_mm": 1.0, "zone": 0.2}
        value = self.cell["policy"].get(key, usual.get(key))
        return value / 1000 if key.endswith("_mm") else value

    def home(self, arm: str) -> np.ndarray:
        """[rad] Along the chain; the file has it in the controller's order."""
        entry = self.arm(arm)
        home = np.deg2rad(entry["home_deg"])
        axes = entry.get("axes", range(1, len(home) + 1))
        return home[np.array(axes) - 1] * np.array(entry.get("signs", np.ones(len(home))))

    def places(self, arm: str) -> list[np.ndarray]:
        """Where an arm may put parts, poses (4, 4) of its hand."""
        poses = []
        for place in self.arm(arm)["place"]:
            if "part_position_mm" in place:
                continue
            columns, rows = place.get("grid", (1, 1))
            pitch = np.array(place.get("pitch_mm", (0, 0))) / 1000
            for row in range(rows):
                for column in range(columns):
                    shift = np.eye(4)
                    shift[:2, 3] = np.array([column, row]) * pitch
                    poses.append(pose_of(place) @ shift)
        return poses

    def part_places(self, arm: str, kind: str) -> list[dict[str, Any]]:
        """Where parts of a kind shall lie: `T` (4, 4), and what is left free [m, rad]."""
        found = []
        for number, place in enumerate(self.arm(arm)["place"], start=1):
            if "part_position_mm" in place and place.get("part", kind) == kind:
                told = {key.removeprefix("part_"): value for key, value in place.items()}
                free = np.deg2rad(place.get("free_rotation_deg", 0))
                far = place.get("tolerance_mm", 2) / 1000
                turn = np.deg2rad(place.get("tolerance_deg", 3))
                comes = unit(place.get("approach", (0, 0, -1)))
                one = {"free": free, "far": far, "turn": turn, "comes": comes}
                columns, rows, layers = (*place.get("grid", (1, 1)), 1)[:3]
                pitch = np.array((*place.get("pitch_mm", (0, 0)), 0)[:3]) / 1000
                for layer, row, column in product(range(layers), range(rows), range(columns)):
                    T, shift = pose_of(told), np.eye(4)
                    shift[:2, 3] = np.array([column, row]) * pitch[:2]
                    T = T @ shift
                    T[2, 3] += layer * pitch[2]
                    pallet = number if layers > 1 else 0
                    found.append(one | {"T": T, "pallet": pallet, "layer": layer + 1})
        return found

    @property
    def corners(self) -> str:
        """Whether the robot comes to rest at each waypoint, rounds corners, or is streamed."""
        known = {"abb-socket": "stop", "abb-socket/2": "blend", "streamed": "streamed"}
        return known[self.cell["controller"]["protocol"]]


def read(folder: Path, parts: Path, name: str = "cell.toml", box: str = "") -> Files:
    """A cell's file in a folder, and those of the parts that it names, there or by their path.

    `box` names the bin of several that parts are taken from; empty: the first.
    """
    cell = tomllib.loads((folder / name).read_text())
    bins = cell["bin"] if isinstance(cell["bin"], list) else [cell["bin"]]
    cell["bin"] = next(table for table in bins if box in ("", table.get("name", "")))
    cell["other_bins"] = [table for table in bins if table is not cell["bin"]]
    kinds, grasps, points, searched = {}, {}, {}, set()
    for part in cell["parts"]:
        where = parts / part if (parts / part).is_dir() else folder / part
        table = tomllib.loads((where / "part.toml").read_text())
        kinds[table["name"]] = table
        library = tomllib.loads((where / "grasps.toml").read_text())
        grasps[table["name"]] = list(_grasps(library["grasp"]))
        if library.get("search", False):
            searched.add(table["name"])
        mesh = trimesh.load_mesh(where / table["mesh"]["file"])
        scale = {"mm": 0.001, "m": 1.0}[table["mesh"]["unit"]]
        corners = np.asarray(mesh.vertices) * scale
        points[table["name"]] = np.column_stack([corners, np.ones(len(corners))])
    files = Files(folder, cell, kinds, grasps, points=points, searched=searched)
    robot = ElementTree.parse(folder / cell["robot"]["urdf"]).getroot()
    above = {}
    for joint in robot.iter("joint"):
        if joint.find("child") is None:
            continue
        name = joint.get("name")
        above[joint.find("child").get("link")] = name, joint.find("parent").get("link")
        limit = joint.find("limit")
        if joint.get("type") in ("revolute", "prismatic") and limit is not None:
            files.joints[name] = tuple(float(limit.get(k)) for k in ("lower", "upper", "velocity"))
    for arm in cell["arm"]:
        link, chain = arm["flange"], []
        while link in above:
            joint, link = above[link]
            chain += [joint] if joint in files.joints else []
        files.chains[arm["name"]] = chain[::-1]
    srdf = ElementTree.parse(folder / cell["robot"]["srdf"]).getroot()
    for one in srdf.iter("disable_collisions"):
        files.never.add(frozenset((one.get("link1"), one.get("link2"))))
    return files


def _grasps(tables):
    """Every grasp by itself, with its pose `T` (4, 4) in the part's frame."""
    for table in tables:
        T = np.eye(4)
        z, y = unit(table["points_along"]), unit(table["closes_along"])
        T[:3, :3] = np.stack([np.cross(y, z), y, z], axis=1)
        T[:3, 3] = np.array(table["position_mm"]) / 1000
        pattern = table.get("pattern")
        if pattern is None:
            yield table | {"T": T}
            continue
        assert "across_mm" not in pattern
        axis = unit(pattern["axis"])
        through = np.array(pattern.get("through_mm", (0, 0, 0))) / 1000
        for row, offset in enumerate(pattern.get("offsets_mm", (0,)), start=1):
            for column, angle in enumerate(pattern.get("angles_deg", (0,)), start=1):
                turn = about(axis, np.deg2rad(angle), through)
                moved = np.eye(4)
                moved[:3, 3] = axis * offset / 1000
                yield table | {"name": f"{table['name']}-{row}-{column}", "T": turn @ moved @ T}
