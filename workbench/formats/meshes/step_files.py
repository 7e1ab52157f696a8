"""STEP files as meshes; one that is cut off is refused before its reader guesses."""

import re
from pathlib import Path

import numpy as np

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import MB, read_whole
from workbench.formats.meshes.reading import LARGEST_MESH
from workbench.model.errors import FileError
from workbench.model.messages.files import FileProblem

FINENESS_MM, FINENESS_DEG = 0.05, 10.0
"""How far a facet may lie from a round face of a STEP file, and be turned against the next."""

MOST_NAMED = 5
"""Other files that a message names."""

STEP_ENDS = b"END-ISO-10303-21"

LENGTH = re.compile(rb"=\s*\(((?:[^;()]|\([^;()]*\))*LENGTH_UNIT(?:[^;()]|\([^;()]*\))*)\)\s*;")
"""An entity that is a unit of length."""
CONVERTED = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*'([A-Za-z]*)'")
PREFIXED = re.compile(rb"SI_UNIT\s*\(\s*(?:\.([A-Z]+)\.|\$)\s*,\s*\.METRE\.")

NAMED = {b"INCH": 0.0254, b"FOOT": 0.3048, b"MILLIMETRE": 0.001, b"MM": 0.001, b"METRE": 1.0}
PREFIXES = {b"MILLI": 0.001, b"CENTI": 0.01, b"DECI": 0.1, b"MICRO": 1e-6, b"": 1.0}

SHAPE = re.compile(rb"=\s*\(?\s*(?:[A-Z_]*SHELL|[A-Z_]*BREP|TESSELLATED_[A-Z_]*)\s*\(")
"""An entity that is a solid or a surface."""
DOCUMENT = re.compile(rb"DOCUMENT_FILE\s*\(\s*'([^']+)'")
"""The name of another file, of which a part of an assembly is."""

USUAL_UNIT = 0.001
"""[m] The unit of a STEP file in which none is found, or several."""


def stated_unit(path: Path) -> float:
    """How many metres the unit of length of a STEP file has."""
    found: set[float] = set()
    for entity in LENGTH.findall(read_whole(path, LARGEST_MESH)):
        named, prefixed = CONVERTED.search(entity), PREFIXED.search(entity)
        if named is not None:
            # The unit that it is converted from is an entity of its own, and used by nothing else.
            return NAMED.get(named[1].upper(), USUAL_UNIT)
        if prefixed is not None:
            found.add(PREFIXES.get(prefixed[1] or b"", USUAL_UNIT))
    return found.pop() if len(found) == 1 else USUAL_UNIT


def converted_step(path: Path, target: Path) -> Path:
    """A STEP file as GLB, in metres.

    Raises:
        FileError: it is none, is cut off, or holds no solid.
    """
    content = read_whole(path, LARGEST_MESH)
    if b"ISO-10303-21" not in content[:2000]:
        detail = "ISO-10303-21 is missing at its beginning"
        raise FileError(path, FileProblem.UNREADABLE(kind="STEP", detail=detail))
    if STEP_ENDS not in content[-2000:]:
        detail = "END-ISO-10303-21 is missing at its end"
        raise FileError(path, FileProblem.CUT_OFF(detail=detail))
    others = list(dict.fromkeys(DOCUMENT.findall(content)))
    if others and not SHAPE.search(content):
        names = ", ".join(quote(name.decode(errors="replace")) for name in others[:MOST_NAMED])
        raise FileError(path, FileProblem.NO_SHAPE(names=names))
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
        detail = quote(str(error))
        raise FileError(path, FileProblem.UNREADABLE(kind="STEP", detail=detail)) from None
    if not target.is_file() or target.stat().st_size == 0:
        raise FileError(path, FileProblem.NO_SOLIDS())
    if target.stat().st_size > 4 * LARGEST_MESH:
        raise FileError(path, FileProblem.UNPACKS(most=f"{4 * LARGEST_MESH / MB:g}"))
    return target
