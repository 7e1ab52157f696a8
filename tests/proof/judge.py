"""A judge of plans that shares nothing with the proof but the plan: MuJoCo, and files read anew.

MuJoCo reads the robot's URDF and moves it, and measures distances.  Tools, bin, fixtures and parts
are taken from their TOML files by the few lines below, margins and pairs from the rules in
`docs/proof.md`.  Ways are sampled so densely that no joint turns further than `STEP` between two
looks; a plan is refused when a margin is missed by more than `BEYOND`, which samples cannot hide.
"""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

STEP = 0.004
"""[rad]"""

BEYOND = 0.0006
"""[m] The proof's resolution, and what the two measure differently."""

FAR = 0.03
"""[m] Pairs whose boxes are further apart are not measured."""

STRAIGHT = ("approach", "extract")


@dataclass(frozen=True)
class Refusal:
    """What is too near: two groups of bodies, how near [m], how near they may be, and the leg."""

    arms: tuple[str, ...]
    leg: str
    pair: tuple[str, str]
    distance: float
    need: float


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


class Judge:
    """Of plans for one shipped cell."""

    def __init__(self, folder: Path, parts: Path) -> None:
        self._folder, self._parts = folder, parts
        self._file = tomllib.loads((folder / "cell.toml").read_text())
        self._arms = {arm["name"]: arm for arm in self._file["arm"]}
        self._tools = {tool["name"]: tool for tool in self._file["tool"]}
        srdf = ElementTree.parse(folder / self._file["robot"]["srdf"]).getroot()
        self._apart = {
            frozenset((one.get("link1"), one.get("link2")))
            for one in srdf.iter("disable_collisions")
        }

    def refusal(self, plan) -> Refusal | None:
        """Why a plan must not be run, None where nothing was found."""
        scene = Scene(self, plan)
        held: dict[int, object] = {}
        placed: dict[int, np.ndarray] = {}
        for step in plan.sequence:
            runs = [(plan.arm(arm), plan.arm(arm).leg(leg)) for arm, leg in step.runs]
            refusal = scene.along(runs, held, placed)
            if refusal is not None:
                return refusal
            for one, leg in runs:
                scene.q[one.arm] = np.asarray(leg.q[-1])
                if leg.name == "approach":
                    held[one.detection] = one
                elif leg.name == "place":
                    T = scene.tcp(one.arm) @ one.T_tcp_part.homogeneous
                    del held[one.detection]
                    placed[one.detection] = T
        return None


class Scene:
    """MuJoCo's model of the cell with the parts of one plan."""

    def __init__(self, judge: Judge, plan) -> None:
        self._judge, self._plan = judge, plan
        file, folder = judge._file, judge._folder
        text = (folder / file["robot"]["urdf"]).read_text()
        options = (
            f'<mujoco><compiler meshdir="{folder}" strippath="false" fusestatic="false" '
            'discardvisual="true" boundmass="0.001" boundinertia="0.001"/></mujoco>'
        )
        head = text.index(">", text.index("<robot")) + 1
        spec = mujoco.MjSpec.from_string(text[:head] + options + text[head:])
        self._groups: dict[str, str] = {}
        for arm in judge._arms.values():
            tool = judge._tools[arm["tool"]]
            for solid in (*tool.get("body", ()), *tool.get("finger", ())):
                self._add(spec, f"tool {arm['name']}", f"{arm['name']} {solid['name']}", solid)
        bin_ = file["bin"]
        for name, size, at in _slabs(bin_["size_mm"], bin_.get("wall_mm", 3)):
            box = {"name": name, "shape": "box", "size_mm": size}
            self._add(
                spec, "still", f"bin {name}", box, pose_of(bin_) @ pose_of({"position_mm": at})
            )
        for fixture in file.get("fixture", ()):
            for solid in fixture["solid"]:
                name = f"{fixture['name']} {solid['name']}"
                self._add(spec, "still", name, solid, pose_of(fixture) @ pose_of(solid))
        for number, seen in enumerate(plan.obstacles):
            box = {"name": "seen", "shape": "box", "size_mm": np.asarray(seen.size) * 1000}
            self._add(spec, "still", f"seen {number}", box, seen.T_world_box.homogeneous)
        self._pieces: dict[str, tuple[int, np.ndarray]] = {}
        for number, one in enumerate(plan.detections):
            part = tomllib.loads((judge._parts / one.part / "part.toml").read_text())
            for k, piece in enumerate(part["piece"]):
                self._add(spec, f"part {number}", f"piece {number} {k}", piece)
                self._pieces[f"piece {number} {k}"] = number, pose_of(piece)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._name_geoms()
        self._T_robot = pose_of(file["robot"])
        self.q = {name: self._home(arm) for name, arm in judge._arms.items()}

    def _add(self, spec, group: str, name: str, solid, T=None) -> None:
        body = spec.worldbody.add_body(name=name, mocap=True)
        self._groups[name] = group
        kind, size, mesh = mujoco.mjtGeom.mjGEOM_BOX, np.zeros(3), ""
        match solid["shape"]:
            case "box":
                size = np.array(solid["size_mm"]) / 2000
            case "cylinder" | "capsule" as shape:
                kind = getattr(mujoco.mjtGeom, f"mjGEOM_{shape.upper()}")
                size[:2] = solid["radius_mm"] / 1000, solid["length_mm"] / 2000
            case "sphere":
                kind, size[0] = mujoco.mjtGeom.mjGEOM_SPHERE, solid["radius_mm"] / 1000
            case "mesh":
                assert solid["unit"] == "m"
                kind, mesh = mujoco.mjtGeom.mjGEOM_MESH, f"mesh {name}"
                spec.add_mesh(name=mesh, file=str(self._judge._folder / solid["file"]))
        body.add_geom(type=kind, size=size, meshname=mesh)
        if T is not None:
            body.pos, body.quat = T[:3, 3], _quat(T[:3, :3])

    def _name_geoms(self) -> None:
        """Group, arm and whether it is moved by it, of every geom."""
        of_joint = {joint: arm for arm in self._judge._arms for joint in self._joints(arm)}
        self.group, self.carrier = [], []
        for g in range(self.model.ngeom):
            body = int(self.model.geom_bodyid[g])
            name = self.model.body(body).name
            self.group.append(self._groups.get(name, f"link {name}"))
            arm = self.group[-1][5:] if self.group[-1].startswith("tool ") else ""
            while not arm and body:
                joint = int(self.model.body_jntadr[body])
                if joint >= 0:
                    arm = of_joint.get(self.model.joint(joint).name, "")
                body = int(self.model.body_parentid[body])
            self.carrier.append(arm)

    def _joints(self, arm: str) -> list[str]:
        """The joints of an arm along its chain: those that its flange hangs on."""
        body = self.model.body(self._judge._arms[arm]["flange"]).id
        joints: list[str] = []
        while body:
            first = int(self.model.body_jntadr[body])
            if first >= 0:
                joints.append(self.model.joint(first).name)
            body = int(self.model.body_parentid[body])
        return joints[::-1]

    def _home(self, arm) -> np.ndarray:
        """[rad] Along the chain; the file has it in the controller's order."""
        home = np.deg2rad(arm["home_deg"])
        axes = arm.get("axes", range(1, len(home) + 1))
        return home[np.array(axes) - 1] * np.array(arm.get("signs", np.ones(len(home))))

    def tcp(self, arm: str) -> np.ndarray:
        """`T_world_tcp` (4, 4) where the arms stand now."""
        self._moved()
        tool = self._judge._tools[self._judge._arms[arm]["tool"]]
        return self._flange(arm) @ pose_of(tool["tcp"])

    def _moved(self) -> None:
        for arm, q in self.q.items():
            for joint, value in zip(self._joints(arm), q, strict=True):
                self.data.joint(joint).qpos = value
        mujoco.mj_kinematics(self.model, self.data)

    def _flange(self, arm: str) -> np.ndarray:
        body, T = self.data.body(self._judge._arms[arm]["flange"]), np.eye(4)
        T[:3, :3], T[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        return self._T_robot @ T

    def _hang(self, openings, held, placed) -> None:
        """Tools at their flanges, parts where they are."""
        self._moved()
        tools = {arm: self._flange(arm) for arm in self.q}
        for arm, entry in self._judge._arms.items():
            tool = self._judge._tools[entry["tool"]]
            for solid in (*tool.get("body", ()), *tool.get("finger", ())):
                T = tools[arm] @ pose_of(solid)
                if "opens_along" in solid:
                    way = np.array(solid["opens_along"], float)
                    shift = way / np.linalg.norm(way) * openings[arm] / 2
                    T[:3, 3] += tools[arm][:3, :3] @ shift
                self._put(f"{arm} {solid['name']}", T)
        for name, (number, T_piece) in self._pieces.items():
            T = self._plan.detections[number].T_world_part.homogeneous
            if number in held:
                one = held[number]
                tool = self._judge._tools[self._judge._arms[one.arm]["tool"]]
                T = tools[one.arm] @ pose_of(tool["tcp"]) @ one.T_tcp_part.homogeneous
            elif number in placed:
                T = placed[number]
            self._put(name, T @ T_piece)
        mujoco.mj_kinematics(self.model, self.data)

    def _put(self, name: str, T: np.ndarray) -> None:
        # The robot stands at MuJoCo's origin: everything else is seen from there.
        T = np.linalg.inv(self._T_robot) @ T
        mocap = int(self.model.body_mocapid[self.model.body(name).id])
        self.data.mocap_pos[mocap], self.data.mocap_quat[mocap] = T[:3, 3], _quat(T[:3, :3])

    def along(self, runs, held, placed) -> Refusal | None:
        """The first thing that is too near while legs run, at any speeds against each other."""
        openings = {name: 0.0 for name in self.q}
        openings.update({one.arm: leg.opening for one, leg in runs})
        gone: dict[str, bool] = {}
        starts = {one.arm: None for one, _ in runs}
        asked: dict[tuple[bool, ...], tuple[np.ndarray, np.ndarray]] = {}
        for states in _states(runs):
            self.q.update(states)
            self._hang(openings, held, placed)
            for one, _ in runs:
                here = self.tcp(one.arm)[:3, 3]
                starts[one.arm] = here if starts[one.arm] is None else starts[one.arm]
                gone[one.arm] = bool(np.linalg.norm(here - starts[one.arm]) > 0.011)
            now = tuple(gone.values())
            if now not in asked:
                asked[now] = self._pairs(runs, held, placed, gone)
            pairs, needs = asked[now]
            a, b = pairs.T
            radii, at = self.model.geom_rbound, self.data.geom_xpos
            room = np.linalg.norm(at[a] - at[b], axis=1) - radii[a] - radii[b]
            for k in np.flatnonzero(room < needs).tolist():
                first, second = pairs[k].tolist()
                distance = mujoco.mj_geomDistance(self.model, self.data, first, second, FAR, None)
                if distance < needs[k] - BEYOND:
                    legs = "/".join(leg.name for _, leg in runs)
                    arms, pair = tuple(gone), (self.group[first], self.group[second])
                    return Refusal(arms, legs, pair, distance, float(needs[k]))
        return None

    def _pairs(self, runs, held, placed, gone) -> tuple[np.ndarray, np.ndarray]:
        """The geoms (p, 2) that are compared while legs run, and what they keep (p,) [m]."""
        legs = {one.arm: leg.name for one, leg in runs}
        targets = {f"part {one.detection}": one.arm for one, leg in runs if leg.name == "approach"}
        holders = {f"part {number}": one.arm for number, one in held.items()}
        put = {
            f"part {one.detection}": one.arm for one in self._plan.arms if one.detection in placed
        }
        carriers = [
            holders.get(group, carrier)
            for group, carrier in zip(self.group, self.carrier, strict=True)
        ]
        needs = {
            (a, b): self._need(a, b, carriers, legs, targets, holders, put, gone)
            for a, b in combinations(range(self.model.ngeom), 2)
            if {carriers[a], carriers[b]} & legs.keys()
        }
        asked = {pair: need for pair, need in needs.items() if need is not None}
        return np.array(list(asked)), np.array(list(asked.values()))

    def _need(self, a, b, carriers, legs, targets, holders, own, gone) -> float | None:
        """What two geoms have to keep [m]; None where nothing is asked of them."""
        policy, groups = self._judge._file["policy"], {self.group[a], self.group[b]}
        if len(groups) == 1 or self._is_allowed(groups):
            return None
        arms = {carriers[a], carriers[b]}
        tools = {f"tool {arm}" for arm in legs}
        margin, near = policy["margin_mm"] / 1000, policy["near_margin_mm"] / 1000
        straight = {arm for arm, leg in legs.items() if leg in STRAIGHT}
        for part, arm in (targets | holders | own).items():
            # Grips, and hands that leave what they have put down, are the proof's own matter.
            if groups == {part, f"tool {arm}"}:
                return None
        is_held = bool(groups & holders.keys())
        if len(arms) == 1:
            within = margin if is_held else policy["self_margin_mm"] / 1000
            return near if is_held and arms & straight else within
        (arm,) = arms & legs.keys() if "" in arms else ("",)
        if arm in straight and (is_held or groups & tools):
            # What a part comes off is the proof's own matter, too.
            is_on_bed = is_held and legs[arm] == "extract" and not gone[arm]
            return None if is_on_bed else near
        return margin

    def _is_allowed(self, groups) -> bool:
        names = frozenset(
            f"{group[5:]}_tool" if group.startswith("tool ") else group.removeprefix("link ")
            for group in groups
        )
        return names in self._judge._apart


def _states(runs) -> Iterator[dict[str, np.ndarray]]:
    """Configurations [rad] on the ways of legs: one leg densely, two in all combinations."""
    dense = {}
    for one, leg in runs:
        rows = [np.asarray(leg.q[0])]
        for start, end in zip(leg.q[:-1], leg.q[1:], strict=True):
            count = int(np.ceil(np.abs(end - start).max() / STEP)) or 1
            rows += [start + (end - start) * k / count for k in range(1, count + 1)]
        dense[one.arm] = rows
    if len(dense) == 1:
        ((arm, rows),) = dense.items()
        yield from ({arm: row} for row in rows)
        return
    (first, ones), (second, others) = dense.items()
    for row in ones[:: max(len(ones) // 40, 1)]:
        for other in others[:: max(len(others) // 40, 1)]:
            yield {first: row, second: other}


def _slabs(size_mm, wall) -> Iterator[tuple[str, tuple, tuple]]:
    """Floor and walls of a bin: name, size and middle [mm], from the middle of its floor."""
    x, y, z = size_mm
    yield "floor", (x + 2 * wall, y + 2 * wall, wall), (0, 0, -wall / 2)
    for sign in (1, -1):
        yield f"x{sign}", (wall, y + 2 * wall, z), (sign * (x + wall) / 2, 0, z / 2)
        yield f"y{sign}", (x, wall, z), (0, sign * (y + wall) / 2, z / 2)


def _quat(R: np.ndarray) -> np.ndarray:
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(R).ravel())
    return quat
