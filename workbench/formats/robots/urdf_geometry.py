"""The shapes of a URDF file's links, and where their meshes are."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.whole_files import PointerError
from workbench.formats.files.xml_elements import Element
from workbench.formats.meshes.pieces.convex_pieces import hull_of
from workbench.formats.meshes.reading import EmptyMesh, WrongUnit, collada_unit, read_mesh
from workbench.formats.robots.mesh_places import MissingMesh, mesh_file
from workbench.formats.robots.packages import Packages
from workbench.formats.robots.remarks import Remarks
from workbench.model.errors import FileError
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
from workbench.model.robot import Link

Colour = tuple[float, float, float]

GREY: Colour = (0.78, 0.78, 0.8)
FURTHEST = 20.0
"""[m] Anything further away or larger is taken for millimetres read as metres."""
THIN = 0.001
"""[m] The thickness of what has none."""
OTHER_UNIT = 200.0
"""Of two meshes of one link the larger, divided by the smaller, where they have different units."""
WITH_UNIT = (".dae", ".glb")
"""Endings of mesh files that say in which unit they are."""


def read_pose(element: Element) -> pin.SE3:
    """The pose in the <origin> of an element; identity when there is none."""
    origin = element.one("origin")
    if origin is None:
        return pin.SE3.Identity()
    xyz = _lengths(origin, "xyz", 3, (0, 0, 0))
    rpy = origin.numbers("rpy", 3, (0, 0, 0))
    if np.abs(rpy).max() > 4 * np.pi:
        raise origin.error(f"rpy={_format(rpy)}: radians are expected, these look like degrees")
    return pose_from_rpy(xyz, rpy)


def read_colours(root: Element) -> dict[str, Colour]:
    """The colours of the materials that stand directly under <robot>, by name."""
    named = ((material.text("name", ""), _colour(material)) for material in root.all("material"))
    return {name: colour for name, colour in named if colour is not None}


class Shapes:
    """Reads the solids of links; a mesh file that many name is read once."""

    def __init__(
        self,
        colours: dict[str, Colour],
        packages: Packages,
        remarks: Remarks,
        mesh_scale: float = 1.0,
    ):
        """`mesh_scale` is for meshes of which neither the robot's file nor their own says it."""
        self._colours = colours
        self._packages = packages
        self._remarks = remarks
        self._mesh_scale = mesh_scale
        self._meshes: dict[tuple[Path, tuple[float, ...]], Mesh] = {}
        self._hulls: dict[Mesh, Mesh] = {}

    def link(self, element: Element, name: str, *, hull: bool) -> Link:
        """A link with what is checked and what is drawn; `hull` makes the former convex.

        Raises:
            FileError: a number or a mesh is wrong, or both are of different units.
        """
        visual = self._read_visuals(element, name)
        try:
            collision = self._solids(element, "collision", name, hull=hull)
        except (MissingMesh, EmptyMesh) as error:
            if not visual and isinstance(error, MissingMesh):
                raise
            instead = "what is drawn is checked in its place" if visual else "nothing is checked"
            self._remarks.pass_over(error, instead)
            collision = ()
        if not self._remarks.is_strict:
            self._compare(element, visual, collision)
            visual = visual or collision
        return Link(name, collision, visual)

    def _read_visuals(self, link: Element, name: str) -> tuple[Solid, ...]:
        """The solids under <visual>.  Nobody is hurt by one that is not drawn."""
        solids: list[Solid] = []
        for number, element in enumerate(link.all("visual")):
            try:
                solids += self._solid(element, f"{name}_{number}", hull=False)
            except (PointerError, WrongUnit):
                raise
            except FileError as error:
                self._remarks.pass_over(error, "is not drawn as it is")
        return tuple(solids)

    def _solids(self, link: Element, tag: str, name: str, *, hull: bool) -> tuple[Solid, ...]:
        solids: list[Solid] = []
        for number, element in enumerate(link.all(tag)):
            solids += self._solid(element, f"{name}_{number}", hull=hull)
        return tuple(solids)

    def _solid(self, element: Element, name: str, *, hull: bool) -> Iterator[Solid]:
        """One solid, or none where it has no size and that is passed over."""
        geometry = element.one("geometry")
        if geometry is None:
            raise element.error("has no <geometry>")
        shape = self._shape(geometry.only())
        if hull and isinstance(shape, Mesh) and not shape.is_convex:
            shape = self._hull(shape, element)
        if shape is not None:
            material = element.one("material")
            colour = GREY if material is None else self._material(material)
            yield Solid(name, shape, read_pose(element), colour)

    def _shape(self, element: Element) -> Shape | None:
        match element.tag:
            case "box":
                return Box(self._thick(element))
            case "mesh":
                return self._mesh(element)
            case "sphere" | "cylinder" | "capsule":
                return self._round(element)
            case _:
                raise element.error(
                    "is no known geometry (known: box, cylinder, capsule, sphere, mesh)"
                )

    def _thick(self, element: Element) -> Floats:
        """The sizes (3,) [m] of a box; one of 0, as a ground plane has it, becomes `THIN`."""
        size = _lengths(element, "size", 3, None)
        if size.min() == 0 < size.max():
            error = element.error(f"size={_format(size)}: must be positive")
            self._remarks.pass_over(error, f"is taken to be {THIN * 1000:g} mm thick")
            return np.where(size == 0, THIN, size)
        return _lengths(element, "size", 3, None, positive=True)

    def _round(self, element: Element) -> Shape | None:
        keys = ("radius",) if element.tag == "sphere" else ("radius", "length")
        for key in keys:
            if not _lengths(element, key, 1, None).any():
                self._remarks.pass_over(element.error(f"{key}=0: must be positive"), "is left out")
                return None
        sizes = [float(_lengths(element, key, 1, None, positive=True)[0]) for key in keys]
        return {"sphere": Sphere, "cylinder": Cylinder, "capsule": Capsule}[element.tag](*sizes)

    def _mesh(self, element: Element) -> Mesh:
        file = mesh_file(element, element.text("filename"), self._packages)
        scale = element.numbers("scale", 3, (1, 1, 1))
        if np.any(scale == 0):
            raise element.error(f"scale={_format(scale)}: would make it flat")
        if not element.text("scale", "") and file.suffix.lower() not in WITH_UNIT:
            scale = scale * self._mesh_scale
        if file.suffix.lower() == ".dae" and file.is_file():
            scale = scale * collada_unit(file)
        key = (file, tuple(scale.tolist()))
        if key not in self._meshes:
            is_piece = file.name.endswith(".convex.obj")
            self._meshes[key] = read_mesh(file, scale, is_piece=is_piece)
        return self._meshes[key]

    def _compare(
        self, link: Element, visual: tuple[Solid, ...], collision: tuple[Solid, ...]
    ) -> None:
        """Look whether what is drawn and what is checked have one unit."""
        sizes = [_largest_mesh(solids) for solids in (visual, collision)]
        if min(sizes) > 0 and max(sizes) > OTHER_UNIT * min(sizes):
            drawn, checked = (f"{size * 1000:.3g} mm" for size in sizes)
            raise link.error(
                f"its visual and collision differ a thousandfold ({drawn} and {checked}): correct "
                "the scale of one of them, or --mesh-unit"
            )
        scaled = [_are_scaled(link, tag) for tag in ("visual", "collision")]
        if scaled in ([True, False], [False, True]):
            alone = "visual" if scaled[0] else "collision"
            self._remarks.add(f"scale is given for its {alone} alone; look at both", link.place)

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
        raise element.error(f"{key}={_format(values)}: must be positive")
    if np.abs(values).max() > FURTHEST:
        raise element.error(
            f"{key}={_format(values)}: metres up to {FURTHEST:g} are expected, "
            "these look like millimetres"
        )
    return values


def _format(values: Floats) -> str:
    return " ".join(f"{value:g}" for value in values)


def _largest_mesh(solids: tuple[Solid, ...]) -> float:
    """The largest side of the meshes among solids [m]; 0 when there is none."""
    meshes = [solid.shape for solid in solids if isinstance(solid.shape, Mesh)]
    return max((float(np.ptp(mesh.points, axis=0).max()) for mesh in meshes), default=0.0)


def _are_scaled(link: Element, tag: str) -> bool | None:
    """Whether the meshes under a tag are scaled; None where there are none, or not all alike.

    Files that say their unit do not count: they may well need another scale.
    """
    found: set[bool] = set()
    for element in link.all(tag):
        geometry = element.one("geometry")
        mesh = None if geometry is None else geometry.one("mesh")
        if mesh is not None and not mesh.text("filename").lower().endswith(WITH_UNIT):
            sizes = np.abs(mesh.numbers("scale", 3, (1, 1, 1)))
            found.add(bool(np.abs(sizes - 1).max() > 1e-6))
    return found.pop() if len(found) == 1 else None
