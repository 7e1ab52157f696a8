"""The colours of a mesh file's triangles, in the order in which its triangles are read."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from workbench.formats.files.toml_keys import shown
from workbench.formats.files.whole_files import read_whole
from workbench.formats.meshes.kept import kept, recipe
from workbench.formats.meshes.reading import LARGEST_MESH
from workbench.model.errors import FileError

KINDS = (".ply", ".obj", ".off")
"""Of mesh files that may have colours of faces or corners; those of STL are no standard."""


def read_face_colours(path: Path, count: int) -> np.ndarray:
    """Colours (m, 3) of the triangles, red, green and blue, 0..255, as sRGB has them.

    Those of corners are averaged.  Materials and textures are not read.

    Args:
        path: of a PLY, OBJ or OFF file.
        count: of its triangles, as `read_mesh` has them.

    Raises:
        FileError: it cannot be read, has no colours, or not for each triangle.
    """
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise FileError(path, f"cannot have colours: one of {', '.join(KINDS)} is expected")
    content = read_whole(path, LARGEST_MESH)
    how = f"colours {recipe('trimesh')} {kind}"
    found = kept(how, [content], lambda: {"colours": _loaded(path, kind, content)})
    colours = _loaded(path, kind, content) if found is None else found["colours"]
    if colours.shape != (count, 3):
        raise FileError(path, f"has {count} triangles and {len(colours)} colours")
    return np.asarray(colours, np.uint8)


def _loaded(path: Path, kind: str, content: bytes) -> np.ndarray:
    import trimesh  # takes a while, and is seldom needed

    try:
        loaded: Any = trimesh.load_mesh(BytesIO(content), file_type=kind[1:], process=False)
        visual = loaded.visual
        has_colours = visual.kind in ("face", "vertex")
        colours = np.asarray(visual.face_colors)[:, :3] if has_colours else None
    except Exception as error:  # the loaders behind trimesh raise whatever they like
        raise FileError(path, f"its colours cannot be read: {shown(str(error))}") from None
    if colours is None:
        raise FileError(path, "has no colours of faces or corners, which use_colours asks for")
    return colours
