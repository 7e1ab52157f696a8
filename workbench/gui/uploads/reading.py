"""Files that people send from their machines, read by processes of their own (`apart`)."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.app.records.forms import Content, large_arrays, restore_value
from workbench.formats.clouds.scans import LARGEST_FILE, read_scan
from workbench.formats.files.reader_process import Answer, Work, apart
from workbench.formats.files.whole_files import read_whole, write_upload
from workbench.formats.meshes.cad_look import CadLook, look_at
from workbench.formats.plans.pose_files import read_poses
from workbench.model.cell import Cell, ScannerMount
from workbench.model.digest import canonical
from workbench.model.messages.message import Message
from workbench.model.part import Bin
from workbench.model.scan import Detection, Scan
from workbench.plugins.progress import Cancelled, never


@dataclass(frozen=True, slots=True, eq=False)
class FittedScanner:
    """Scanner and bin as a first scan shows them, and what `left` that does not fit, in sentences.

    The bin has another size where another one than the cell's is seen.
    """

    mount: ScannerMount
    bin: Bin
    left: tuple[Message, ...]


def cad_look(
    name: str, content: Content, unit: str = "", solid: str = "", *, cancelled: Cancelled = never
) -> CadLook:
    """What a CAD file holds.

    Args:
        name: of the file.
        content: its bytes.
        unit: mm, m or inch; empty when the file says it or it is not known.
        solid: name of the solid to look at; empty: all of them.
        cancelled: True once nobody wants to know any more.

    Raises:
        FileError: it cannot be read.
        JobCancelled: it was cancelled.
    """
    return _read(CadLook, name, content, look_at_file, unit, solid, cancelled=cancelled)


def sent_scan(
    name: str, content: Content, mount: ScannerMount, *, cancelled: Cancelled = never
) -> Scan:
    """The scan in a PLY or PCD file, by a scanner that hangs there.

    Args:
        name: of the file.
        content: its bytes.
        mount: where the scanner hangs, and what its files are like.
        cancelled: True once nobody wants it any more.

    Raises:
        FileError: it cannot be read (`read_scan`).
        JobCancelled: it was cancelled.
    """
    return _read(Scan, name, content, scan_in_file, canonical(mount), cancelled=cancelled)


def sent_poses(
    name: str, content: Content, part: str, *, cancelled: Cancelled = never
) -> tuple[Detection, ...]:
    """The poses in a file.

    Args:
        name: of the file.
        content: its bytes.
        part: name of the part that poses from HALCON are of.
        cancelled: True once nobody wants them any more.

    Raises:
        FileError: it cannot be read (`read_poses`).
        JobCancelled: it was cancelled.
    """
    kind = tuple[Detection, ...]
    return _read(kind, name, content, poses_in_file, part, cancelled=cancelled)


def fitted_scanner(
    name: str, content: Content, cell: Cell, *, cancelled: Cancelled = never
) -> FittedScanner:
    """The scanner of a cell, and the bin, as the scan in a file shows them.

    Args:
        name: of the file.
        content: its bytes.
        cell: whose scanner, which stands, and bin.
        cancelled: True once nobody wants to know any more.

    Raises:
        FileError: it cannot be read.
        InputError: it lies where no scanner measures.
        JobCancelled: it was cancelled.
    """
    from workbench.app.calibration.first_scan import largest_of  # heavy, and seldom needed

    about = canonical(cell.scanner), canonical(cell.bin), largest_of(cell.parts)
    return _read(FittedScanner, name, content, fit_to_file, *about, cancelled=cancelled)


# What the processes of their own do.


def look_at_file(file: Path, unit: str, solid: str) -> Answer:
    """As `cad_look`."""
    return _make_answer(look_at(file, unit, solid))


def scan_in_file(file: Path, mount: Any) -> Answer:
    """As `sent_scan`; the mount is in canonical form."""
    return _make_answer(read_scan(file, restore_value(ScannerMount, mount, _nothing)))


def poses_in_file(file: Path, part: str) -> Answer:
    """As `sent_poses`."""
    return _make_answer(read_poses(file, part))


def fit_to_file(file: Path, mount: Any, bin: Any, largest: float) -> Answer:
    """As `fitted_scanner`; mount and bin are in canonical form, the largest part in metres."""
    from workbench.app.calibration.first_scan import first_scan  # heavy, and seldom needed

    seen = restore_value(ScannerMount, mount, _nothing), restore_value(Bin, bin, _nothing)
    content = read_whole(file, LARGEST_FILE)
    fitted = first_scan(file, content, *seen, largest=largest)
    # What is said from here on is what that does not mend.
    left = first_scan(file, content, fitted.mount, fitted.bin, largest=largest).says
    return _make_answer(FittedScanner(fitted.mount, fitted.bin, left))


def _read(
    kind: Any, name: str, content: Content, work: Work, *arguments: Any, cancelled: Cancelled
) -> Any:
    with write_upload(name, content) as file:
        answer = apart(file, work, *arguments, cancelled=cancelled)
    return restore_value(kind, answer.value, lambda digest: answer.arrays[digest].data)


def _make_answer(value: Any) -> Answer:
    """A value as what comes back: its canonical form, and its large arrays by their digests."""
    arrays = large_arrays(value)
    return Answer(
        canonical(value), {array: np.frombuffer(arrays[array], np.uint8) for array in arrays}
    )


def _nothing(digest: str) -> bytes:
    raise KeyError(digest)
