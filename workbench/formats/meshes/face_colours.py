"""The colours of a mesh file's triangles, in the order in which its triangles are read."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import read_whole
from workbench.formats.meshes.mesh_cache import load_or_make, recipe
from workbench.formats.meshes.reading import LARGEST_MESH
from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.messages.files import FileProblem

COLOURED_ENDINGS = (".ply", ".obj", ".off", ".glb")
"""Of mesh files that may have colours; those of STL are no standard."""

FINENESS = 4
"""A triangle with a texture is checked in the squared number of places."""


def read_face_colours(path: Path, count: int) -> np.ndarray:
    """Colours (m, 3) of the triangles, red, green and blue, 0..255, as sRGB has them.

    Those of corners are averaged, and so is a texture over each triangle.  Materials and textures
    are read of GLB files alone: those of OBJ files lie in files of their own.

    Args:
        path: of a PLY, OBJ, OFF or GLB file.
        count: of its triangles, as `read_mesh` has them.

    Raises:
        FileError: it cannot be read, has no colours, or not for each triangle.
    """
    kind = path.suffix.lower()
    if kind not in COLOURED_ENDINGS:
        detail = f"one of {', '.join(COLOURED_ENDINGS)} is expected"
        raise FileError(path, FileProblem.COLOURS(detail=detail))
    content = read_whole(path, LARGEST_MESH)
    how = f"colours {recipe('trimesh', 'pillow')} {kind}"
    found = load_or_make(how, [content], lambda: {"colours": _load(path, kind, content)})
    colours = _load(path, kind, content) if found is None else found["colours"]
    if colours.shape != (count, 3):
        detail = f"{count} triangles and {len(colours)} colours"
        raise FileError(path, FileProblem.COLOURS(detail=detail))
    return np.asarray(colours, np.uint8)


def _load(path: Path, kind: str, content: bytes) -> np.ndarray:
    import trimesh  # takes a while, and is seldom needed

    try:
        loaded: Any = trimesh.load_scene(BytesIO(content), file_type=kind[1:], process=False)
        # As `read_mesh` has them one behind the other.
        meshes = [piece for piece in loaded.dump() if isinstance(piece, trimesh.Trimesh)]
        of = _of_glb if kind == ".glb" else _of_visual
        colours = [of(mesh) for mesh in meshes]
    except Exception as error:  # the loaders behind trimesh raise whatever they like
        raise FileError(path, FileProblem.COLOURS(detail=quote(str(error)))) from None
    if all(colour is None for colour in colours):
        raise FileError(path, FileProblem.NO_COLOURS())
    if any(colour is None for colour in colours):
        raise FileError(path, FileProblem.SOME_COLOURS())
    return np.concatenate([colour for colour in colours if colour is not None])


def _of_visual(mesh: Any) -> np.ndarray | None:
    """Colours (m, 3), 0..255, of faces or corners as the file has them; None where it has none."""
    visual = mesh.visual
    return np.asarray(visual.face_colors)[:, :3] if visual.kind in ("face", "vertex") else None


def _of_glb(mesh: Any) -> np.ndarray | None:
    """Colours (m, 3), 0..255, of corners, material and texture; None where there are none.

    Source: Khronos, glTF 2.0, 3.7.2.1 and 3.9.2: textures are in sRGB, all else is linear.
    """
    if mesh.visual.kind != "texture":
        colours = _of_visual(mesh)
        return None if colours is None else _encode(colours / 255.0)
    material, uv = mesh.visual.material, mesh.visual.uv
    texture = getattr(material, "baseColorTexture", None)
    factor = getattr(material, "baseColorFactor", None)
    if texture is None and factor is None:
        return None
    light = np.ones((len(mesh.faces), 3))
    if factor is not None:
        light *= np.asarray(factor, float)[:3] / 255.0
    if texture is not None and uv is not None:
        light *= _texture_light(material, np.asarray(uv, float)[mesh.faces])
    return _encode(light)


def _texture_light(material: Any, corners: Floats) -> Floats:
    """The mean light (m, 3), 0..1, of a texture over triangles with corners (m, 3, 2) in it."""
    # The middles of the small triangles into which parallels to its sides divide one.
    n = FINENESS
    upright = [(i + 1 / 3, j + 1 / 3) for i in range(n) for j in range(n - i)]
    inverted = [(i + 2 / 3, j + 2 / 3) for i in range(n - 1) for j in range(n - 1 - i)]
    places = np.array(upright + inverted) / n
    total = np.zeros((len(corners), 3))
    for a, b in places:
        uv = (
            corners[:, 0]
            + a * (corners[:, 1] - corners[:, 0])
            + b * (corners[:, 2] - corners[:, 0])
        )
        total += _linear(np.asarray(material.to_color(uv))[:, :3])
    return total / len(places)


def _linear(colours: np.ndarray) -> Floats:
    """Shares of light (n, 3), 0..1, from sRGB (n, 3), 0..255 (IEC 61966-2-1)."""
    shares = colours / 255.0
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def _encode(light: Floats) -> np.ndarray:
    """SRGB (n, 3), 0..255, from shares of light (n, 3), 0..1."""
    shares = np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    return np.round(255.0 * shares).astype(np.uint8)
