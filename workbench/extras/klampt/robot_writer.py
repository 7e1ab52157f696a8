"""A robot as a Klamp't robot file (`.rob`); see `klampt_robot` for the format."""

from pathlib import Path

import pinocchio as pin

from workbench.extras.klampt.urdf_writer import depth_first
from workbench.formats.files.whole_files import file_name, make_folder, write_whole
from workbench.formats.meshes.triangles import stl_of, surface_of
from workbench.formats.robots.urdf_writer import numbers
from workbench.model.robot import Robot


def write_rob(path: Path, robot: Robot) -> None:
    """Write a robot with the meshes of its collision geometry in a folder beside the file.

    Raises:
        FileError: a file cannot be written.
    """
    joints = depth_first(robot)
    names = [robot.root, *(joint.child for joint in joints)]
    meshes = path.parent / f"{path.stem}_meshes"
    make_folder(meshes)
    files: list[str] = []
    for link in (robot.link(name) for name in names):
        file = f"{meshes.name}/{file_name(link.name)}.stl"
        if link.collision:
            write_whole(path.parent / file, stl_of(surface_of(link.collision)))
        files.append(file if link.collision else "")
    rows = [pin.SE3.Identity(), *(joint.T_parent_joint for joint in joints)]
    fixed = [True, *(joint.kind == "fixed" for joint in joints)]
    lower = [0.0, *(joint.lower for joint in joints)]
    upper = [0.0, *(joint.upper for joint in joints)]
    pairs = (
        f"{names.index(a)} {names.index(b)}"
        for a, b in sorted(robot.disabled_pairs)
        if a in names and b in names
    )
    lines = [
        f"links {' '.join(map(_quote, names))}",
        f"parents -1 {' '.join(str(names.index(joint.parent)) for joint in joints)}",
        "jointtype r " + " ".join("p" if j.kind == "prismatic" else "r" for j in joints),
        "tparent "
        + " \\\n".join(numbers([*T.rotation.ravel().tolist(), *T.translation]) for T in rows),
        "axis 0 0 1 " + " ".join(numbers(joint.axis.tolist()) for joint in joints),
        f"qmin {numbers([0.0 if f else v for f, v in zip(fixed, lower, strict=True)])}",
        f"qmax {numbers([0.0 if f else v for f, v in zip(fixed, upper, strict=True)])}",
        f"velmax {numbers([0.0, *(joint.velocity for joint in joints)])}",
        f"geometry {' '.join(map(_quote, files))}",
        *(f"joint weld {k}" for k, is_fixed in enumerate(fixed) if is_fixed),
        f"noselfcollision {' '.join(pairs)}",
        f"mass {numbers([1.0] * len(names))}",
        "automass",
    ]
    write_whole(path, ("\n".join(lines) + "\n").encode())


def _quote(text: str) -> str:
    return '"' + text.replace('"', "") + '"'
