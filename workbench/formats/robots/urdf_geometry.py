"""The shapes of a URDF file's links, and where their meshes are."""

from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import shown
from workbench.formats.files.whole_files import is_file
from workbench.formats.files.xml_elements import Element
from workbench.formats.meshes.convex_pieces import hull_of
from workbench.formats.meshes.reading import read_mesh
from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Solid,
    Sphere,
    pose_from_rpy,
)

Colour = tuple[float, float, float]

GREY: Colour = (0.78, 0.78, 0.8)
FURTHEST = 20.0
"""[m] Anything further away or larger is taken for millimetres read as metres."""


def read_pose(element: Element) -> pin.SE3:
    """The pose in the <origin> of an element; identity when there is none."""
    origin = element.one("origin")
    if origin is None:
        return pin.SE3.Identity()
    xyz = _lengths(origin, "xyz", 3, (0, 0, 0))
    rpy = origin.numbers("rpy", 3, (0, 0, 0))
    if np.abs(rpy).max() > 4 * np.pi:
        raise origin.error(f"rpy={_listed(rpy)}: radians are expected, these look like degrees")
    return pose_from_rpy(xyz, rpy)


def read_colours(root: Element) -> dict[str, Colour]:
    """The colours of the materials that stand directly under <robot>, by name."""
    named = ((material.text("name", ""), _colour(material)) for material in root.all("material"))
    return {name: colour for name, colour in named if colour is not None}


class Shapes:
    """Reads the solids of links; a mesh file that many name is read once."""

    def __init__(self, colours: dict[str, Colour], mesh_scale: float = 1.0):
        self._colours = colours
        self._mesh_scale = mesh_scale
        self._meshes: dict[tuple[Path, tuple[float, ...]], Mesh] = {}
        self._hulls: dict[Mesh, Mesh] = {}

    def solids(self, link: Element, tag: str, name: str, *, hull: bool) -> tuple[Solid, ...]:
        """The solids under <collision> or <visual>; `hull` makes their meshes convex."""
        solids: list[Solid] = []
        for number, element in enumerate(link.all(tag)):
            geometry = element.one("geometry")
            if geometry is None:
                raise element.error("has no <geometry>")
            shape = self._shape(geometry.only())
            if hull and isinstance(shape, Mesh) and not shape.is_convex:
                shape = self._hull(shape, element)
            material = element.one("material")
            colour = GREY if material is None else self._material(material)
            solids.append(Solid(f"{name}_{number}", shape, read_pose(element), colour))
        return tuple(solids)

    def _shape(self, element: Element) -> Shape:
        match element.tag:
            case "box":
                return Box(_lengths(element, "size", 3, None, positive=True))
            case "sphere":
                return Sphere(_length(element, "radius"))
            case "cylinder":
                return Cylinder(_length(element, "radius"), _length(element, "length"))
            case "capsule":
                return Capsule(_length(element, "radius"), _length(element, "length"))
            case "mesh":
                return self._mesh(element)
            case _:
                raise element.error(
                    "is no known geometry (known: box, cylinder, capsule, sphere, mesh)"
                )

    def _mesh(self, element: Element) -> Mesh:
        file = _mesh_file(element, element.text("filename"))
        scale = element.numbers("scale", 3, (1, 1, 1))
        if np.any(scale == 0):
            raise element.error(f"scale={_listed(scale)}: would make it flat")
        key = (file, tuple(scale.tolist()))
        if key not in self._meshes:
            is_piece = file.name.endswith(".convex.obj")
            scale = scale * self._mesh_scale
            self._meshes[key] = read_mesh(file, scale, is_piece=is_piece)
        return self._meshes[key]

    def _hull(self, mesh: Mesh, element: Element) -> Mesh:
        if mesh not in self._hulls:
            hull = hull_of(mesh)
            if hull is None:
                raise element.error("its mesh is flat and has no convex hull")
            self._hulls[mesh] = hull
        return self._hulls[mesh]

    def _material(self, material: Element) -> Colour:
        return _colour(material) or self._colours.get(material.text("name", ""), GREY)


def _colour(material: Element) -> Colour | None:
    colour = material.one("color")
    if colour is None:
        return None
    red, green, blue, _ = np.clip(colour.numbers("rgba", 4), 0, 1).tolist()
    return (red, green, blue)


def _lengths(
    element: Element,
    key: str,
    count: int,
    default: tuple[float, ...] | None,
    *,
    positive: bool = False,
) -> Floats:
    values = element.numbers(key, count, default)
    if positive and np.any(values <= 0):
        raise element.error(f"{key}={_listed(values)}: must be positive")
    if np.abs(values).max() > FURTHEST:
        raise element.error(
            f"{key}={_listed(values)}: metres up to {FURTHEST:g} are expected, "
            "these look like millimetres"
        )
    return values


def _length(element: Element, key: str) -> float:
    return float(_lengths(element, key, 1, None, positive=True)[0])


def _listed(values: Floats) -> str:
    return " ".join(f"{value:g}" for value in values)


def _mesh_file(element: Element, name: str) -> Path:
    """Beside the URDF; `package://` also means a folder of that name here or above."""
    beside = element.path.parent
    if not name.startswith("package://"):
        file = beside / name.removeprefix("file://")
        if is_file(file):
            return file.resolve()
        raise element.error(f"filename={shown(name)}: there is no such file beside the URDF")
    package, _, rest = name.removeprefix("package://").partition("/")
    folder = beside.resolve()
    places = [place / package for place in (folder, *folder.parents)]
    places += [place for place in (folder, *folder.parents) if place.name == package]
    for place in (*places, folder):
        if is_file(place / rest):
            return place / rest
    raise element.error(
        f"filename={shown(name)}: no such file in a folder {shown(package)} "
        "beside the URDF or above it"
    )
