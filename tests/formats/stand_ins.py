"""Stand-ins for data of others, which is not shipped: small, in the flavour of the real files.

They are made anew for each run, by writers that are not ours: clouds by Open3D, meshes by trimesh,
descriptions by ElementTree from the shipped robots, with the names and the layout of the public
ones.  Where the real data lies beside the checkout, the same tests run on it as well.
"""

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import open3d as o3d
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Cylinder, Mesh, Solid, pose_from_rpy
from workbench.model.robot import Robot

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
CELLS = Path(__file__).resolve().parents[1] / "cells"


def sources(folder: str) -> list:
    """Parameters of tests on data: the stand-in, and the real folder where it is there."""
    is_missing = not (DATA / folder).is_dir()
    reason = f"the public data is not here: ../shared/data/{folder} beside the checkout"
    return ["stand-in", pytest.param("real", marks=pytest.mark.skipif(is_missing, reason=reason))]


def folder_of(source: str, folder: str, make: Callable[[Path], object], somewhere: Path) -> Path:
    """The folder with the real data, or one with the stand-in made `somewhere`."""
    if source == "real":
        return DATA / folder
    made = somewhere / "shared" / "data" / folder
    made.mkdir(parents=True)
    make(made)
    return made


@dataclass(frozen=True)
class Recording:
    """How many points a recording and the taught part in it have."""

    scene: int
    taught: int


RECORDED = Recording(241_407, 12_575)
COLUMNS, ROWS, FOCAL = 640, 480, 525.0
CARTON = (0.12, 0.14, 0.24)
FINGER = "meshes/gripper/coarse/finger.stl"
TURN = pose_from_rpy((0, 0, 0), (np.pi, 0, 0)).rotation
"""From a scanner's frame to that of the recording, which looks along -z."""


def make_recording(folder: Path) -> Recording:
    """A carton and two other things before a wall, as a Kinect would have them: `Recording`."""
    carton = trimesh.creation.box(extents=CARTON)
    # A gable, so that it is not turned for itself.
    ridge = np.array([[0.0, -CARTON[1] / 2, 0.17], [0.0, CARTON[1] / 2, 0.17]])
    carton = trimesh.Trimesh(np.vstack([carton.vertices, ridge])).convex_hull
    pose = pose_from_rpy((-0.12, 0.03, 0.92), (2.2, 0.35, 0.5))
    others = [
        (trimesh.creation.box(extents=(0.15, 0.22, 0.1)), (0.17, -0.05, 1.02), (0.3, 0.2, 0.9)),
        (trimesh.creation.cylinder(0.045, 0.2), (0.05, 0.2, 1.03), (1.3, 0.4, 0.0)),
        (trimesh.creation.box(extents=(3, 3, 0.02)), (0, 0, 1.11), (0, 0, 0)),
    ]
    things = [(carton, pose), *((mesh, pose_from_rpy(p, rpy)) for mesh, p, rpy in others)]
    scene = _seen(things, seed=0)
    # What lies nearer than a Kinect measures is not measured either.
    scene[:40, :90] = np.nan
    _write_pcd(folder / "scene_milk_carton_clorox.pcd", scene.reshape(-1, 3), COLUMNS, ROWS)
    taught = _seen([(carton, pose_from_rpy((0.02, 0.0, 0.75), (2.3, 0.3, 0.6)))], seed=1)
    taught = taught[np.isfinite(taught).all(axis=-1)]
    _write_pcd(folder / "milk.pcd", taught, len(taught), 1)
    return Recording(int(np.isfinite(scene).all(axis=-1).sum()), len(taught))


def _seen(things: list[tuple[trimesh.Trimesh, pin.SE3]], *, seed: int) -> np.ndarray:
    """Points (rows, columns, 3) [m], in the recording's frame, NaN where nothing is."""
    scene = o3d.t.geometry.RaycastingScene()
    for mesh, T in things:
        points = mesh.vertices @ T.rotation.T + T.translation
        scene.add_triangles(
            o3d.core.Tensor(points.astype(np.float32)),
            o3d.core.Tensor(mesh.faces.astype(np.uint32)),
        )
    u, v = np.meshgrid(np.arange(COLUMNS) - COLUMNS / 2, np.arange(ROWS) - ROWS / 2)
    rays = np.stack([u / FOCAL, v / FOCAL, np.ones_like(u)], axis=-1)
    origins = np.zeros_like(rays)
    cast = scene.cast_rays(
        o3d.core.Tensor(np.concatenate([origins, rays], axis=-1).astype(np.float32))
    )
    depth = cast["t_hit"].numpy().astype(np.float64)
    depth[~np.isfinite(depth)] = np.nan
    depth += np.random.default_rng(seed).normal(0.0, 0.0012, depth.shape) * depth**2
    return (rays * depth[..., None]) @ TURN.T


def _write_pcd(path: Path, points: np.ndarray, columns: int, rows: int) -> None:
    """Compressed, with colours; Open3D writes rows of one pixel only, so that is put right."""
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.colors = o3d.utility.Vector3dVector(np.full((len(points), 3), 0.6))
    assert o3d.io.write_point_cloud(str(path), cloud, write_ascii=False, compressed=True)
    head, data, body = path.read_bytes().partition(b"DATA binary_compressed\n")
    size = f"WIDTH {columns}\nHEIGHT {rows}\n".encode()
    lines = [line for line in head.splitlines(keepends=True) if not line.startswith(b"HEIGHT")]
    head = b"".join(size if line.startswith(b"WIDTH") else line for line in lines)
    assert data and size in head
    path.write_bytes(head + data + body)


def make_tx2_90(folder: Path) -> None:
    """The shipped robot, a little slimmer, in STL meshes for looks and for collisions."""
    robot = read_cell("tx2_90").robot
    for kind in ("visual", "collision"):
        for link in robot.links:
            if link.collision:
                mesh = _mesh_of(link.collision, 0.99)
                _write_stl(folder / "meshes" / kind / f"{link.name}.stl", mesh)
    described = _described(robot, {}, {}, lambda link, kind: f"meshes/{kind}/{link}.stl")
    described.write(folder / "tx2_90.urdf", xml_declaration=True)


def make_yumi(folder: Path) -> None:
    """The shipped robot under the public names, with a gripper whose fingers are links."""
    cell = read_cell("yumi")
    links, joints = {"body": "yumi_body"}, {}
    for arm in cell.arms:
        side = arm.name[0]
        chain = [cell.robot.joint(name) for name in arm.joints]
        for number, joint in enumerate(chain, start=1):
            links[joint.child] = f"yumi_link_{number}_{side}"
            joints[joint.name] = f"yumi_joint_{joint.name[-1]}_{side}"
        links[arm.flange] = f"gripper_{side}_base"
        joints[f"{arm.name}_flange_joint"] = f"yumi_link_7_{side}_joint"
    coarse = folder / "meshes" / "coarse"
    for link in cell.robot.links:
        if link.collision:
            name = links[link.name].removeprefix("yumi_").removesuffix("_r").removesuffix("_l")
            _write_stl(coarse / f"{name}.stl", _mesh_of(link.collision, 0.97))

    def file_of(link: str, kind: str) -> str:
        if link.startswith("gripper"):
            return "meshes/gripper/coarse/base.stl"
        name = link.removeprefix("yumi_").removesuffix("_r").removesuffix("_l")
        return f"meshes/coarse/{name}.stl"

    gripper = folder / "meshes" / "gripper" / "coarse"
    _write_stl(gripper / "base.stl", _mesh_of(cell.arms[0].tool.body, 1.0))
    finger = trimesh.creation.box(bounds=[[-0.006, 0.0015, 0.0], [0.0, 0.0115, 0.0522]])
    _write_stl(folder / FINGER, finger)
    described = _described(cell.robot, links, joints, file_of)
    root = described.getroot()
    root.insert(0, ET.Element("link", name="yumi_base_link"))
    root.append(_fixed("yumi_base_link_to_body", "yumi_base_link", "yumi_body"))
    for side in "rl":
        _add_fingers(root, side)
    described.write(folder / "yumi.urdf", xml_declaration=True)


def public_yumi(source: str, somewhere: Path) -> Path:
    """The folder of the cell around the public YuMi, or around its stand-in."""
    if source == "real":
        return CELLS / "public_yumi"
    folder_of(source, "yumi", make_yumi, somewhere)
    return Path(shutil.copytree(CELLS / "public_yumi", somewhere / "here/tests/cells/public_yumi"))


def _add_fingers(root: ET.Element, side: str) -> None:
    for name, (y, yaw) in {"r": (-0.0065, 0.0), "l": (0.0065, np.pi)}.items():
        child = f"gripper_{side}_finger_{name}"
        root.append(
            _link(child, "meshes/gripper/coarse/finger.stl", "meshes/gripper/coarse/finger.stl")
        )
        suffix = "" if name == "r" else "_m"
        joint = ET.SubElement(root, "joint", name=f"gripper_{side}_joint{suffix}", type="prismatic")
        ET.SubElement(joint, "parent", link=f"gripper_{side}_base")
        ET.SubElement(joint, "child", link=child)
        ET.SubElement(joint, "origin", xyz=f"0 {y} 0.0837", rpy=f"0 0 {yaw}")
        ET.SubElement(joint, "axis", xyz="-1 0 0")
        ET.SubElement(joint, "limit", effort="20", lower="0", upper="0.025", velocity="2")
        if suffix:
            ET.SubElement(joint, "mimic", joint=f"gripper_{side}_joint")


def _described(
    robot: Robot,
    links: Mapping[str, str],
    joints: Mapping[str, str],
    file_of: Callable[[str, str], str],
) -> ET.ElementTree:
    """A URDF of a robot, its links and joints under other names, one mesh a link."""
    root = ET.Element("robot", name=robot.name)
    for link in robot.links:
        name = links.get(link.name, link.name)
        if link.collision or name.startswith("gripper"):
            root.append(_link(name, file_of(name, "visual"), file_of(name, "collision")))
        else:
            ET.SubElement(root, "link", name=name)
    for joint in robot.joints:
        name = joints.get(joint.name, joint.name)
        element = ET.SubElement(root, "joint", name=name, type=joint.kind)
        ET.SubElement(element, "parent", link=links.get(joint.parent, joint.parent))
        ET.SubElement(element, "child", link=links.get(joint.child, joint.child))
        T = joint.T_parent_joint
        rpy = pin.rpy.matrixToRpy(T.rotation)
        ET.SubElement(element, "origin", xyz=_numbers(T.translation), rpy=_numbers(rpy))
        if joint.kind != "fixed":
            ET.SubElement(element, "axis", xyz=_numbers(joint.axis))
            limits = {"lower": joint.lower, "upper": joint.upper, "velocity": joint.velocity}
            told = {key: repr(float(value)) for key, value in limits.items()}
            ET.SubElement(element, "limit", {**told, "effort": "300"})
            ET.SubElement(element, "dynamics", damping="0.5")
    return ET.ElementTree(root)


def _link(name: str, visual: str, collision: str) -> ET.Element:
    link = ET.Element("link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "mass", value="2")
    for kind, file in (("visual", visual), ("collision", collision)):
        element = ET.SubElement(link, kind)
        ET.SubElement(element, "origin", rpy="0 0 0", xyz="0 0 0")
        ET.SubElement(ET.SubElement(element, "geometry"), "mesh", filename=file)
    return link


def _fixed(name: str, parent: str, child: str) -> ET.Element:
    joint = ET.Element("joint", name=name, type="fixed")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    return joint


def _mesh_of(solids: tuple[Solid, ...], scale: float) -> trimesh.Trimesh:
    """All solids in one mesh, each shrunk about its middle."""
    meshes: list[trimesh.Trimesh] = []
    for solid in solids:
        shape, T = solid.shape, solid.T_owner_shape
        if isinstance(shape, Mesh):
            mesh = trimesh.Trimesh(shape.points, shape.triangles)
        else:
            assert isinstance(shape, Cylinder)
            mesh = trimesh.creation.cylinder(shape.radius, shape.length)
        points = mesh.vertices @ T.rotation.T + T.translation
        middle = points.mean(axis=0)
        meshes.append(trimesh.Trimesh(middle + scale * (points - middle), mesh.faces))
    return trimesh.util.concatenate(meshes)


def _write_stl(path: Path, mesh: trimesh.Trimesh) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    mesh.export(path)


def _numbers(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)
