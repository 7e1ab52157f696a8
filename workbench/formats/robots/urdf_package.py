"""A robot as a folder of its own: a URDF with convex pieces to check and meshes to look at."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pinocchio as pin

from workbench.formats.files.whole_files import file_name, make_folder, write_whole
from workbench.formats.meshes.pieces.convex_pieces import OVER, pieces_of
from workbench.formats.meshes.triangles import stl_of, surface_of
from workbench.formats.robots.urdf_writer import joint_element, numbers, write_xml
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Solid, Sphere
from workbench.model.robot import Link, Robot
from workbench.plugins.progress import Report, silent

MOST_SPLIT = 1_024
"""Pieces into which all meshes of a robot are split, before those that can be one are joined.

It bounds the work for a robot of many meshes.  The work is counted, not timed: every machine makes
the same pieces.
"""


def simplify_robot(
    robot: Robot,
    *,
    tolerance: float,
    most: int,
    report: Report = silent,
) -> tuple[Robot, dict[str, float]]:
    """The robot with convex pieces instead of the meshes that are checked.

    Args:
        robot: as it was read.
        tolerance: [m] by which a piece may be too large before it is divided.
        most: pieces for one mesh; fewer where there are very many meshes (`MOST_SPLIT`).
        report: called with the share done, and which link is next.

    Returns:
        The robot, and for each link that had a mesh by how much its pieces are too large [m].
        A link without collision geometry gets that of its visual; a flat mesh is left out.
    """
    links: list[Link] = []
    excess: dict[str, float] = {}
    meshes = {mesh for link in robot.links for _, mesh in _with_meshes(link) if mesh is not None}
    share = max(1, MOST_SPLIT // max(1, len(meshes)))
    most = min(most, share)
    over = min(OVER, share / most)
    for number, link in enumerate(robot.links):
        report(number / len(robot.links), link.name)
        solids: list[Solid] = []
        for solid, mesh in _with_meshes(link):
            if mesh is None:
                solids.append(solid)
                continue
            found = pieces_of(mesh, tolerance=tolerance, most=most, over=over)
            if found is None:
                continue
            excess[link.name] = max(excess.get(link.name, 0.0), found.excess)
            solids += [
                Solid(f"{solid.name}_{k}", piece, solid.T_owner_shape, solid.colour)
                for k, piece in enumerate(found.pieces)
            ]
        links.append(Link(link.name, tuple(solids), link.visual))
    return Robot(robot.name, tuple(links), robot.joints, robot.disabled_pairs), excess


def _with_meshes(link: Link) -> Iterator[tuple[Solid, Mesh | None]]:
    """The solids that are checked of a link, each with its mesh where that has to be split."""
    for solid in link.collision or link.visual:
        shape = solid.shape
        yield solid, shape if isinstance(shape, Mesh) and not shape.is_convex else None


def write_package(path: Path, robot: Robot) -> None:
    """Write a URDF with all that it names in a folder `meshes` next to it.

    Raises:
        FileError: a file cannot be written.
    """
    meshes = path.parent / "meshes"
    make_folder(meshes)
    root = ElementTree.Element("robot", name=robot.name)
    for link in robot.links:
        element = ElementTree.SubElement(root, "link", name=link.name)
        for tag, solids in (("visual", link.visual), ("collision", link.collision)):
            for number, solid in enumerate(solids):
                element.append(_solid(meshes, tag, f"{link.name}_{tag}_{number}", solid))
    for joint in robot.joints:
        root.append(joint_element(joint))
    write_xml(path, root)


def write_srdf(path: Path, name: str, reasons: Mapping[tuple[str, str], str]) -> None:
    """Write the pairs of links that need no check, each with its reason.

    Raises:
        FileError: it cannot be written.
    """
    root = ElementTree.Element("robot", name=name)
    for (first, second), reason in sorted(reasons.items()):
        ElementTree.SubElement(root, "disable_collisions", link1=first, link2=second, reason=reason)
    write_xml(path, root)


def _solid(meshes: Path, tag: str, name: str, solid: Solid) -> ElementTree.Element:
    element = ElementTree.Element(tag)
    ElementTree.SubElement(element, "origin", _origin(solid.T_owner_shape))
    geometry = ElementTree.SubElement(element, "geometry")
    match solid.shape:
        case Box(size=size):
            ElementTree.SubElement(geometry, "box", size=numbers(size))
        case Sphere(radius=radius):
            ElementTree.SubElement(geometry, "sphere", radius=repr(float(radius)))
        case Cylinder(radius=radius, length=length):
            measures = {"radius": repr(float(radius)), "length": repr(float(length))}
            ElementTree.SubElement(geometry, "cylinder", measures)
        case Capsule(radius=radius, length=length):
            measures = {"radius": repr(float(radius)), "length": repr(float(length))}
            ElementTree.SubElement(geometry, "capsule", measures)
        case Mesh() as mesh:
            file = meshes / f"{file_name(name)}.{'convex.obj' if mesh.is_convex else 'stl'}"
            as_drawn = Solid(solid.name, mesh, pin.SE3.Identity())
            write_whole(file, _obj(mesh) if mesh.is_convex else stl_of(surface_of([as_drawn])))
            ElementTree.SubElement(geometry, "mesh", filename=f"meshes/{file.name}")
    if tag == "visual":
        material = ElementTree.SubElement(element, "material", name="")
        rgba = " ".join(f"{value:.3f}" for value in (*solid.colour, 1.0))
        ElementTree.SubElement(material, "color", rgba=rgba)
    return element


def _origin(T: pin.SE3) -> dict[str, str]:
    return {
        "xyz": numbers(T.translation),
        "rpy": numbers(pin.rpy.matrixToRpy(T.rotation)),
    }


def _obj(mesh: Mesh) -> bytes:
    lines: Iterable[str] = (
        *(f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in mesh.points.tolist()),
        *(f"f {i + 1} {j + 1} {k + 1}" for i, j, k in mesh.triangles.tolist()),
    )
    return ("\n".join(lines) + "\n").encode()
