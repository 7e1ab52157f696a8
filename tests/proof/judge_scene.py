"""A cell in MuJoCo: it reads the robot's description, moves it, and measures distances."""

from xml.etree import ElementTree

import mujoco
import numpy as np
from judge_files import Files, pose_of, unit

SPARE = 14
"""Boxes that stand for what a scan shows and for fixtures that come later."""

ROUND = (int(mujoco.mjtGeom.mjGEOM_CYLINDER), int(mujoco.mjtGeom.mjGEOM_CAPSULE))

AWAY = np.array([0.0, 0.0, -100.0])
"""[m] Where a box is that is not there."""


class Scene:
    """A model of a cell with parts of some kinds; `set` puts everything where a case has it.

    `group`, `carrier` (g,): what each geom is part of, and the arm that carries it or "".
    `moves` (g, nq): which values move it; `turns` (g, nq): which of these only turn it about an
    axis about which it is round; `levers` (g, nq) [m/rad, m/m]: how far each moves it at most.
    """

    def __init__(self, files: Files, kinds: tuple[str, ...]) -> None:
        self.kinds = kinds
        spec = mujoco.MjSpec.from_string(_urdf(files))
        self._groups: dict[str, str] = {}
        self._slides: dict[str, list[str]] = {}
        self._resized: dict[str, tuple[str, str]] = {}
        for arm in files.cell["arm"]:
            self._add_tool(spec, files, arm)
        self._still: list[str] = []
        for name, solid, _ in _standing(files):
            self._add(spec, "still", name, solid, files)
            self._still.append(name)
        for k in range(SPARE):
            self._add(spec, "still", f"spare {k}", {"shape": "box", "size_mm": (1, 1, 1)}, files)
        self.pieces: list[tuple[int, np.ndarray, str]] = []
        for number, kind in enumerate(kinds):
            for k, piece in enumerate(files.parts[kind]["piece"]):
                name = f"piece {number} {k}"
                self._add(spec, f"part {number}", name, piece, files)
                self.pieces.append((number, pose_of(piece), name))
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, self.data)
        self._name_geoms(files)
        self.columns = {
            arm: np.array([self._column(joint) for joint in files.chains[arm]])
            for arm in self._slides
        }
        self.fingers = {
            arm: np.array([self._column(joint) for joint in joints], int)
            for arm, joints in self._slides.items()
        }
        self.hanging: list[tuple[int, int, np.ndarray]] = []

    def _column(self, joint: str) -> int:
        return int(self.model.jnt_qposadr[self.model.joint(joint).id])

    def _add_tool(self, spec, files: Files, arm) -> None:
        name, tool = arm["name"], files.tool(arm["name"])
        self._slides[name] = []
        for key in ("body", "finger"):
            for solid in tool.get(key, ()):
                label = f"{name} {solid['name']}"
                body = spec.body(arm["flange"]).add_body(name=label)
                if key == "finger":
                    slide = mujoco.mjtJoint.mjJNT_SLIDE
                    body.add_joint(name=label, type=slide, axis=unit(solid["opens_along"]))
                    self._slides[name].append(label)
                T = pose_of(solid)
                _add_geom(spec, body, label, solid, files, T)
                self._groups[label] = f"tool {name}"
                self._resized[label] = name, solid["name"]

    def _add(self, spec, group: str, name: str, solid, files: Files) -> None:
        body = spec.worldbody.add_body(name=name, mocap=True, pos=AWAY)
        _add_geom(spec, body, name, solid, files, np.eye(4))
        self._groups[name] = group

    def _name_geoms(self, files: Files) -> None:
        model = self.model
        of_joint = {joint: arm for arm, chain in files.chains.items() for joint in chain}
        self.group, self.carrier = [], []
        self.moves = np.zeros((model.ngeom, model.nq), bool)
        self.turns = np.zeros((model.ngeom, model.nq), bool)
        self.levers = np.zeros((model.ngeom, model.nq))
        self.geom_of: dict[str, int] = {}
        for g in range(model.ngeom):
            body = int(model.geom_bodyid[g])
            name = model.body(body).name
            self.geom_of.setdefault(name, g)
            group = self._groups.get(name, f"link {name}")
            self.group.append(group)
            arm = group[5:] if group.startswith("tool ") else ""
            joints = self._above(g, body, float(np.linalg.norm(model.geom_pos[g])))
            self.carrier.append(arm or of_joint.get(joints[0] if joints else "", ""))

    def _above(self, g: int, body: int, reach: float) -> list[str]:
        """Joints that move a geom, nearest first; `levers` get how far [m] each can be from it."""
        model, joints = self.model, []
        reach += float(model.geom_rbound[g])
        while body:
            first = int(model.body_jntadr[body])
            if first >= 0:
                column = int(model.jnt_qposadr[first])
                is_slide = model.jnt_type[first] == mujoco.mjtJoint.mjJNT_SLIDE
                self.moves[g, column] = True
                self.turns[g, column] = not joints and self._is_turned_alike(g, first)
                self.levers[g, column] = 1.0 if is_slide else reach
                reach += 0.1 if is_slide else 0.0
                joints.append(model.joint(first).name)
            reach += float(np.linalg.norm(model.body_pos[body]))
            body = int(model.body_parentid[body])
        return joints

    def _is_turned_alike(self, g: int, joint: int) -> bool:
        """Whether a geom fills the same space however a joint with nothing behind it is turned."""
        model, data = self.model, self.data
        if model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_HINGE or model.geom_type[g] not in ROUND:
            return False
        off, axis = data.geom_xpos[g] - data.xanchor[joint], data.xaxis[joint]
        along = data.geom_xmat[g].reshape(3, 3)[:, 2]
        return bool(abs(along @ axis) > 1 - 1e-9 and np.linalg.norm(np.cross(off, axis)) < 1e-6)

    def set(self, files: Files, boxes, parts: list[np.ndarray]) -> None:
        """Everything at its place that stands or lies: boxes (pose, size [m]), parts (4, 4)."""
        self.T_robot = pose_of(files.cell["robot"])
        self._T_back = np.linalg.inv(self.T_robot)
        spare = list(boxes)
        for name, solid, T in _standing(files):
            if name in self._still:
                self._put(name, T)
                self._resize(name, solid)
            else:
                assert solid["shape"] == "box"
                spare.append((T, np.array(solid["size_mm"]) / 1000))
        assert len(spare) <= SPARE, len(spare)
        for k in range(SPARE):
            g = self.geom_of[f"spare {k}"]
            T, size = spare[k] if k < len(spare) else (_at(AWAY), np.full(3, 0.001))
            self._put(f"spare {k}", T)
            self.model.geom_size[g] = size / 2
            self.model.geom_rbound[g] = np.linalg.norm(size) / 2
        for label, (arm, solid_name) in self._resized.items():
            tool = files.tool(arm)
            solids = (*tool.get("body", ()), *tool.get("finger", ()))
            solid = next(one for one in solids if one["name"] == solid_name)
            self._resize(label, solid)
        self.put_parts(dict(enumerate(parts)))

    def _resize(self, name: str, solid) -> None:
        if solid["shape"] != "mesh":
            g = self.geom_of[name]
            self.model.geom_size[g] = _size(solid)
            self.model.geom_rbound[g] = _around(solid)

    def put_parts(self, poses: dict[int, np.ndarray]) -> None:
        """Lay parts somewhere."""
        for number, T_piece, name in self.pieces:
            if number in poses:
                self._put(name, poses[number] @ T_piece)

    def _put(self, name: str, T: np.ndarray) -> None:
        # The robot stands at MuJoCo's origin: everything else is seen from there.
        T = self._T_back @ T
        mocap = int(self.model.body_mocapid[self.model.body(name).id])
        self.data.mocap_pos[mocap], self.data.mocap_quat[mocap] = T[:3, 3], _quat(T[:3, :3])

    def at(self, q: np.ndarray) -> None:
        """Move the robot there (nq,) [rad, m], with what it holds."""
        self.data.qpos[:] = q
        mujoco.mj_kinematics(self.model, self.data)
        for flange, g, T in self.hanging:
            R = self.data.xmat[flange].reshape(3, 3)
            self.data.geom_xpos[g] = self.data.xpos[flange] + R @ T[:3, 3]
            self.data.geom_xmat[g] = (R @ T[:3, :3]).ravel()

    def hang(self, files: Files, held: dict[int, tuple[str, np.ndarray]]) -> None:
        """From now on hands hold parts: number -> (arm, pose (4, 4) in the flange)."""
        self.hanging = []
        for number, T_piece, name in self.pieces:
            if number in held:
                arm, T = held[number]
                flange = int(self.model.body(files.arm(arm)["flange"]).id)
                self.hanging.append((flange, self.geom_of[name], T @ T_piece))

    def flange(self, files: Files, arm: str, q: np.ndarray) -> np.ndarray:
        """`T_world_flange` (4, 4) at the arm's joints (n,) [rad], others as they are."""
        self.data.qpos[self.columns[arm]] = q
        mujoco.mj_kinematics(self.model, self.data)
        body, T = self.data.body(files.arm(arm)["flange"]), np.eye(4)
        T[:3, :3], T[:3, 3] = body.xmat.reshape(3, 3), body.xpos
        return self.T_robot @ T

    def distance(self, first: int, second: int, most: float) -> float:
        """Between two geoms [m], up to `most`; negative: how deep they are in each other."""
        return mujoco.mj_geomDistance(self.model, self.data, first, second, most, None)


def _urdf(files: Files) -> str:
    """The robot's description with MuJoCo's options, and without what is only seen."""
    root = ElementTree.parse(files.folder / files.cell["robot"]["urdf"]).getroot()
    for link in root.iter("link"):
        for seen in link.findall("visual"):
            link.remove(seen)
    options = {"meshdir": str(files.folder), "strippath": "false", "fusestatic": "false"}
    options |= {"discardvisual": "true", "boundmass": "0.001", "boundinertia": "0.001"}
    ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler", options)
    return ElementTree.tostring(root, encoding="unicode")


def _add_geom(spec, body, name: str, solid, files: Files, T) -> None:
    kind, mesh = mujoco.mjtGeom.mjGEOM_MESH, ""
    if solid["shape"] == "mesh":
        assert solid["unit"] == "m"
        mesh = f"mesh {name}"
        spec.add_mesh(name=mesh, file=str(files.folder / solid["file"]))
    else:
        kind = getattr(mujoco.mjtGeom, f"mjGEOM_{solid['shape'].upper()}")
    quat = _quat(T[:3, :3])
    body.add_geom(type=kind, size=_size(solid), meshname=mesh, pos=T[:3, 3], quat=quat)


def _size(solid) -> np.ndarray:
    """As MuJoCo has it [m]."""
    size = np.zeros(3)
    match solid["shape"]:
        case "box":
            size = np.array(solid["size_mm"]) / 2000
        case "cylinder" | "capsule":
            size[:2] = solid["radius_mm"] / 1000, solid["length_mm"] / 2000
        case "sphere":
            size[0] = solid["radius_mm"] / 1000
    return size


def _around(solid) -> float:
    """The radius [m] of a ball around a solid."""
    size = _size(solid)
    if solid["shape"] == "box":
        return float(np.linalg.norm(size))
    is_capsule = solid["shape"] == "capsule"
    return float(size[0] + size[1]) if is_capsule else float(np.hypot(size[0], size[1]))


def _standing(files: Files):
    """Name, solid and pose (4, 4) of the bin's slabs, other bins whole, and of all fixtures."""
    bin_ = files.cell["bin"]
    for name, size, at in _slabs(bin_):
        box = {"shape": "box", "size_mm": size}
        yield f"bin {name}", box, pose_of(bin_) @ pose_of({"position_mm": at})
    for other in files.cell["other_bins"]:
        (x, y, z), wall = other["size_mm"], other.get("wall_mm", 3)
        beside = 2 * wall if other.get("walls", True) else 0
        box = {"shape": "box", "size_mm": (x + beside, y + beside, z + wall)}
        middle = pose_of({"position_mm": (0, 0, (z - wall) / 2)})
        yield f"other bin {other['name']}", box, pose_of(other) @ middle
    for fixture in files.cell.get("fixture", ()):
        for solid in fixture["solid"]:
            yield f"{fixture['name']} {solid['name']}", solid, pose_of(fixture) @ pose_of(solid)


def _slabs(bin_):
    """Floor and walls of a bin: name, size and middle [mm], from the middle of its floor."""
    (x, y, z), wall = bin_["size_mm"], bin_.get("wall_mm", 3)
    if not bin_.get("walls", True):
        yield "floor", (x, y, wall), (0, 0, -wall / 2)
        return
    yield "floor", (x + 2 * wall, y + 2 * wall, wall), (0, 0, -wall / 2)
    for sign in (1, -1):
        yield f"x{sign}", (wall, y + 2 * wall, z), (sign * (x + wall) / 2, 0, z / 2)
        yield f"y{sign}", (x, wall, z), (0, sign * (y + wall) / 2, z / 2)


def _at(p) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = p
    return T


def _quat(R: np.ndarray) -> np.ndarray:
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, np.ascontiguousarray(R).ravel())
    return quat
