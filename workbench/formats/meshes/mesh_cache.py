"""Meshes that take a while to read or to make, kept between runs by what they are made from.

Half a second of each start would go into the libraries that read meshes and wrap them; what they
made before is there at once, and they need not be imported.
"""

import contextlib
import hashlib
import os
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping
from functools import cache, lru_cache
from importlib.metadata import version
from io import BytesIO
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from workbench.formats.files.whole_files import MB, make_folder, read_whole, write_whole
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh

Arrays = Mapping[str, NDArray[np.generic]]

LARGEST_KEPT = 64 * MB


@cache
def recipe(*libraries: str) -> str:
    """What a kept result depends on beside its content: the code of this folder, which makes it.

    Args:
        libraries: distributions that it asks; those of another version may make something else.
    """
    code = hashlib.sha256()
    for source in sorted(Path(__file__).parent.rglob("*.py")):
        code.update(source.read_bytes())
    return " ".join([code.hexdigest(), *(f"{name} {version(name)}" for name in libraries)])


def load_or_make(
    recipe: str, content: Iterable[bytes], make: Callable[[], Arrays | None]
) -> Arrays | None:
    """What `make` gives, from the disk when it was made before.

    Args:
        recipe: how it is made; with other words it is made anew.
        content: what it is made from.
        make: makes it; None is not kept, and neither is an error.
    """
    key = hashlib.sha256(recipe.encode())
    for piece in content:
        key.update(f" {len(piece)} ".encode())
        key.update(piece)
    path = cache_folder() / f"{key.hexdigest()}.npz"
    found = _find(path)
    if found is not None:
        return found
    made = make()
    if made is not None and sum(array.nbytes for array in made.values()) < LARGEST_KEPT:
        buffer = BytesIO()
        np.savez(buffer, **made)  # type: ignore[arg-type]
        # Where nothing can be kept the next start takes longer, and that is all.
        with contextlib.suppress(FileError):
            make_folder(path.parent)
            write_whole(path, buffer.getvalue())
    return made


def _find(path: Path) -> Arrays | None:
    """What is kept; None when there is nothing, or what is there is none of ours."""
    try:
        with np.load(BytesIO(read_whole(path, 2 * LARGEST_KEPT))) as found:
            return {name: found[name] for name in found.files} or None
    except (FileError, ValueError, KeyError, OSError, EOFError, zipfile.BadZipFile, zlib.error):
        return None


def pack_meshes(meshes: Iterable[Mesh]) -> dict[str, NDArray[np.generic]]:
    """Meshes as arrays to keep: points (n, 3) [m], triangles (m, 3), is convex."""
    arrays: dict[str, NDArray[np.generic]] = {}
    for number, mesh in enumerate(meshes):
        arrays[f"p{number}"] = np.asarray(mesh.points)
        arrays[f"t{number}"] = np.asarray(mesh.triangles)
        arrays[f"c{number}"] = np.array(mesh.is_convex)
    return arrays


def unpack_meshes(arrays: Arrays) -> tuple[Mesh, ...]:
    """The meshes among arrays that were kept."""
    count = sum(name.startswith("p") for name in arrays)
    return tuple(
        Mesh(arrays[f"p{k}"], arrays[f"t{k}"], bool(arrays[f"c{k}"]))  # type: ignore[arg-type]
        for k in range(count)
    )


def content_of(mesh: Mesh) -> list[bytes]:
    """What a result that is made from a mesh is kept by."""
    return [np.asarray(mesh.points).tobytes(), np.asarray(mesh.triangles).tobytes()]


@lru_cache(maxsize=1)
def cache_folder() -> Path:
    """Where what took long to make is kept between runs."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "workbench" / "pieces"
