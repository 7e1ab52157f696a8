"""What people do to a grasp library: each a plain function from one value to the next."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.part import (
    Entry,
    Grasp,
    GraspLibrary,
    GraspPair,
    GraspPattern,
    Part,
    grasps_of,
)
from workbench.model.symmetry import Symmetry


def edit_library(library: GraspLibrary, was: Sequence[Entry], now: Sequence[Entry]) -> GraspLibrary:
    """The library with some entries instead of others, or added, or taken away.

    Args:
        library: as it is.
        was: the entries to replace, as the editor has seen them.
        now: the new entries; they are appended where nothing is replaced.

    Raises:
        InputError: an entry of `was` is gone or was changed meanwhile, or a name is used twice.
    """
    known = {entry.name: digest_of(entry) for entry in library.entries}
    for entry in was:
        if entry.name not in known:
            raise InputError(ChangeRefusal.GRASP_GONE(grasp=repr(entry.name)))
        if known[entry.name] != digest_of(entry):
            raise InputError(ChangeRefusal.GRASP_CHANGED(grasp=repr(entry.name)))
    gone = {entry.name for entry in was}
    entries = [entry for entry in library.entries if entry.name not in gone]
    names = [entry.name for entry in library.entries]
    place = names.index(was[0].name) if was else len(names)
    place -= sum(name in gone for name in names[:place])
    entries[place:place] = now
    pairs = library.pairs
    if len(was) == len(now) == 1:
        pairs = tuple(_rename(pair, was[0].name, now[0].name) for pair in pairs)
    result = replace(library, entries=tuple(entries), pairs=pairs)
    left = {entry.name for entry in entries}
    pairs = tuple(pair for pair in pairs if {pair.first, pair.second} <= left)
    _check_names(result)
    return replace(result, pairs=pairs)


def _rename(pair: GraspPair, old: str, new: str) -> GraspPair:
    return replace(
        pair,
        first=new if pair.first == old else pair.first,
        second=new if pair.second == old else pair.second,
    )


def _check_names(library: GraspLibrary) -> None:
    names: set[str] = set()
    for name in names_in(library.entries):
        if name in names:
            raise InputError(ChangeRefusal.GRASP_TWICE(grasp=repr(name)))
        names.add(name)


def names_in(entries: Sequence[Entry]) -> list[str]:
    """Names that are taken: those of the entries, and of what patterns stand for."""
    patterns = [entry.name for entry in entries if isinstance(entry, GraspPattern)]
    return patterns + [grasp.name for entry in entries for grasp in grasps_of(entry)]


def free_name(taken: Collection[str], name: str) -> str:
    """The name, or with a number behind it when it is taken."""
    stem, number, found = name.rstrip("0123456789").rstrip("-") or name, 2, name
    while found in taken:
        found, number = f"{stem}-{number}", number + 1
    return found


def grasp_of(entry: Entry) -> Grasp:
    """The grasp that is authored: itself, or the one that a pattern repeats."""
    return entry.grasp if isinstance(entry, GraspPattern) else entry


def with_grasp(entry: Entry, grasp: Grasp) -> Entry:
    """The entry about another grasp; a pattern goes on repeating it."""
    return replace(entry, grasp=grasp) if isinstance(entry, GraspPattern) else grasp


def mirror_entry(entry: Entry, normal: Floats) -> Entry:
    """The entry mirrored across the plane through the part's origin with a unit normal (3,).

    What is mirrored is where the tool points and where its fingers move; the tool itself is not.
    """
    n = np.asarray(normal)
    M = np.eye(3) - 2.0 * np.outer(n, n)
    grasp = grasp_of(entry)
    R = np.asarray(grasp.T_part_tcp.rotation)
    y, z = M @ R[:, 1], M @ R[:, 2]
    T = pin.SE3(np.column_stack([np.cross(y, z), y, z]), M @ grasp.T_part_tcp.translation)
    flipped = np.array([-1.0, 1.0, 1.0])
    grasp = replace(
        grasp,
        T_part_tcp=T,
        approach=grasp.approach * flipped,
        retreat=None if grasp.retreat is None else grasp.retreat * flipped,
    )
    if not isinstance(entry, GraspPattern):
        return grasp
    return replace(
        entry,
        grasp=grasp,
        axis=M @ entry.axis,
        angles=tuple(-angle for angle in entry.angles),
        through=M @ entry.through,
        across=M @ entry.across,
    )


def with_part(
    cell: Cell,
    name: str,
    *,
    library: GraspLibrary | None = None,
    symmetry: Symmetry | None = None,
) -> Cell:
    """The cell with other grasps or another symmetry of one of its parts; None: as it is."""

    def change(part: Part) -> Part:
        return replace(
            part,
            library=part.library if library is None else library,
            symmetry=part.symmetry if symmetry is None else symmetry,
        )

    return replace(
        cell, parts=tuple(change(part) if part.name == name else part for part in cell.parts)
    )


def differ_in_grasps_only(cell: Cell, other: Cell) -> bool:
    """Whether all else about two cells is the same, so that what was found in one holds."""
    bare = [
        replace(
            compared, parts=tuple(replace(part, library=GraspLibrary()) for part in compared.parts)
        )
        for compared in (cell, other)
    ]
    return bare[0].digest == bare[1].digest
