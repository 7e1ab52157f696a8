"""The promises of scanners."""

import numpy as np

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.messages.message import Message
from workbench.model.scan import Scan
from workbench.plugins.progress import never
from workbench.plugins.scanner import Scanner, ScanRequest
from workbench.testing.options import check_options


def check_scanner(kind: type[Scanner], cell: Cell, *, parts: int = 1) -> Scan:
    """A scanner delivers a scan that can be used, states how far it is, and can be cancelled.

    The scanner, or what stands for it, has to answer twice.

    Args:
        kind: the class that is declared.
        cell: with address and options as the scanner needs them.
        parts: what a simulated one shall see.

    Returns:
        The scan, for what only its maker can check.
    """
    options = check_options(kind.Options, cell.scanner.options)
    shares: list[float] = []

    def report(done: float, note: Message | str) -> None:
        assert 0.0 <= done <= 1.0, f"a share done is 0..1, not {done}"
        assert isinstance(note, str | Message), "a note is a text or a message"
        shares.append(done)

    request = ScanRequest(seed=1, parts=parts)
    scan = kind(cell, options).scan(request, report, never)
    points = np.asarray(scan.points)
    assert points.ndim == 2 and points.shape[1] == 3, f"points are (n, 3), not {points.shape}"
    assert len(points) > 0, "a scan without points is a LinkError"
    assert np.isfinite(points).all(), "points are finite; what was not measured is left out"
    depth = np.median(np.linalg.norm(points, axis=1))
    assert depth < 10.0, f"points are in metres; in the middle these are {depth:.0f} m away"
    T = cell.scanner.T_world_scanner.actInv(scan.T_world_scanner)
    assert np.allclose(T.homogeneous, np.eye(4), atol=1e-9), "the pose is that of the mount"
    assert shares, "nobody was told how far it is"
    try:
        kind(cell, options).scan(request, report, lambda: True)
    except JobCancelled:
        return scan
    raise AssertionError("a scan that was cancelled came all the same")
