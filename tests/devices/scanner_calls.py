"""Scanners made for a mount, and scans taken by them."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from waiting import PATIENCE

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import ScannerMount
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Option, Scan
from workbench.plugins.options import options_of
from workbench.plugins.scanner import ScanRequest

T = pose_from_rpy((0.4, 0.0, 0.9), (np.pi, 0, 0))
SCAN = Scan(np.random.default_rng(0).uniform(0.1, 0.5, (500, 3)), T, "made")


YUMI = Path(__file__).resolve().parents[2] / "robots" / "yumi"


def cell_with(folder: Path, scanner: str) -> Path:
    """The file of a cell like the shipped YuMi, with another table [scanner]."""
    for name in ("meshes", "yumi.urdf", "yumi.srdf"):
        if not (folder / name).exists():
            (folder / name).symlink_to(YUMI / name)
    before, _, rest = (YUMI / "cell.toml").read_text().partition("[scanner]\n")
    after = rest.partition("\n[controller]")[2]
    path = folder / "cell.toml"
    path.write_text(f"{before}{scanner}\n[controller]{after}")
    return path


def made(kind, address, patience=PATIENCE, unit="m", options: Mapping[str, Option] | None = None):
    options = options or {}
    mount = ScannerMount(T, address=str(address), patience=patience, unit=unit, options=options)
    return kind(replace(read_cell("yumi"), scanner=mount), options_of(kind.Options, options))


def taken(scanner, *then: Callable[[], object], cancelled=lambda: False) -> Scan:
    """A scan, and what happens while it is awaited: one thing at each report."""
    left = list(then)

    def report(done: float, note: str) -> None:
        if left:
            left.pop(0)()

    return scanner.scan(ScanRequest(), report, cancelled)
