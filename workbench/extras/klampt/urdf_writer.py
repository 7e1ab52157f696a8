"""A robot as a URDF file with one STL mesh a link, as Klamp't and other tools read it."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from workbench.formats.files.whole_files import file_name, write_whole
from workbench.formats.meshes.triangles import stl_of, surface_of
from workbench.formats.robots.urdf_writer import joint_element, write_xml
from workbench.model.robot import Joint, Robot


def write_urdf(path: Path, robot: Robot) -> None:
    """Write the collision geometry, joints and disabled pairs of a robot.

    Meshes go to the folder `meshes` beside the file, named by link.  Disabled pairs are
    written as Klamp't reads them.

    Raises:
        FileError: a file cannot be written.
    """
    root = ElementTree.Element("robot", name=robot.name)
    for link in robot.links:
        element = ElementTree.SubElement(root, "link", name=link.name)
        if not link.collision:
            continue
        mesh = f"meshes/{file_name(link.name)}.stl"
        write_whole(path.parent / mesh, stl_of(surface_of(link.collision)))
        for tag in ("visual", "collision"):
            geometry = ElementTree.SubElement(ElementTree.SubElement(element, tag), "geometry")
            ElementTree.SubElement(geometry, "mesh", filename=mesh)
    for joint in depth_first(robot):
        root.append(joint_element(joint))
    klampt = ElementTree.SubElement(root, "klampt", package_root=".", default_acc_max="4")
    names = {link.name for link in robot.links if link.collision}
    pairs = sorted(pair for pair in robot.disabled_pairs if names.issuperset(pair))
    ElementTree.SubElement(klampt, "noselfcollision", pairs=" ".join(" ".join(p) for p in pairs))
    write_xml(path, root)


def depth_first(robot: Robot) -> list[Joint]:
    """The joints, every branch to its end before the next, branches by the names of joints.

    That is the order of links that programs built on urdfdom come to, Klamp't among them.
    """
    ordered: list[Joint] = []
    joints = sorted(robot.joints, key=lambda joint: joint.name, reverse=True)
    waiting = [joint for joint in joints if joint.parent == robot.root]
    while waiting:
        joint = waiting.pop()
        ordered.append(joint)
        waiting += [other for other in joints if other.parent == joint.child]
    return ordered
