"""STEP files as meshes; one that is cut off is refused before its reader guesses."""

from pathlib import Path

import numpy as np

from workbench.formats.files.toml_keys import shown
from workbench.formats.files.whole_files import MB, read_whole
from workbench.formats.meshes.reading import LARGEST_MESH
from workbench.model.errors import FileError

FINENESS_MM, FINENESS_DEG = 0.05, 10.0
"""How far a facet may lie from a round face of a STEP file, and be turned against the next."""

STEP_ENDS = b"END-ISO-10303-21"


def converted_step(path: Path, target: Path) -> Path:
    """A STEP file as GLB, in metres.

    Raises:
        FileError: it is none, is cut off, or holds no solid.
    """
    content = read_whole(path, LARGEST_MESH)
    if b"ISO-10303-21" not in content[:2000]:
        raise FileError(path, "cannot be read as STEP: ISO-10303-21 is missing at its beginning")
    if STEP_ENDS not in content[-2000:]:
        raise FileError(path, "is cut off: END-ISO-10303-21 is missing at its end")
    import cascadio  # OpenCASCADE: large, and seldom needed

    try:
        cascadio.step_to_glb(
            str(path),
            str(target),
            tol_linear=FINENESS_MM,
            tol_angular=float(np.deg2rad(FINENESS_DEG)),
            use_parallel=False,
        )
    except RuntimeError as error:
        raise FileError(path, f"cannot be read as STEP: {shown(str(error))}") from None
    if not target.is_file() or target.stat().st_size == 0:
        raise FileError(path, "cannot be read as STEP, or holds no solid")
    if target.stat().st_size > 4 * LARGEST_MESH:
        raise FileError(path, f"gives a mesh of more than {4 * LARGEST_MESH / MB:g} MB")
    return target
