"""`workbench scanner fit`: a cell's scanner by its first scan."""

import shlex
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.calibration.calibration import check_stands
from workbench.app.calibration.first_scan import FirstScan, first_scan, largest_of
from workbench.cli.arguments import scanner as arguments
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.clouds.scans import LARGEST_FILE
from workbench.formats.files.toml_documents import shorts
from workbench.formats.files.whole_files import read_whole


def fit(typed: arguments.ScannerFit) -> int:
    """Say what a scan shows of its scanner, and write it into the cell if asked to."""
    cell = read_cell(typed.cell)
    check_stands(cell)
    cloud = read_whole(typed.scan, LARGEST_FILE)
    largest = largest_of(cell.parts)
    seen = first_scan(typed.scan, cloud, cell.scanner, cell.bin, largest=largest)
    surface = seen.surface
    if typed.write:
        cell = replace(
            cell, scanner=seen.mount, bin=(surface or seen.bin) if typed.bin else cell.bin
        )
        save_cell(cell_path(typed.cell), cell)
        # What is said from here on is what the written keys do not mend.
        seen = first_scan(typed.scan, cloud, cell.scanner, cell.bin, largest=largest)
    form = _form(seen)
    if typed.json:
        print_json({**form, "written": typed.write})
    else:
        for key, value in form.items():
            if key != "says":
                print(f"{key} = {value}" if value is not None else f"{key}: not known")
        for line in seen.says:
            print(f"- {line}")
        if typed.write:
            print(f"written into {cell_path(typed.cell)}")
            scan = shlex.quote(str(typed.scan))
            if surface is not None and not typed.bin:
                print(f"next: `workbench scanner fit {scan} --cell {typed.cell} --write --bin`")
            else:
                print(f"next: `workbench localize {typed.cell} --scan {scan} --out poses.json`")
    return NO_PLAN if seen.says else SUCCESS


def _form(seen: FirstScan) -> dict[str, Any]:
    """By the keys of a cell file, where there are such."""
    T = seen.mount.T_world_scanner
    return {
        "unit": seen.mount.unit,
        "cloud_axes": seen.mount.cloud_axes,
        "position_mm": shorts(T.translation * 1000, 2),
        "rpy_deg": shorts(np.rad2deg(pin.rpy.matrixToRpy(T.rotation)), 3),
        "noise_mm": None if seen.noise is None else round(seen.noise * 1000, 3),
        "bin_mm": shorts(1000 * seen.bin.size, 1),
        "rim_mm": None if seen.found.rim is None else shorts(1000 * np.array(seen.found.rim), 1),
        "is_bin_found": seen.found.T_scanner_bin is not None,
        "share_in_range": round(seen.fitting, 3),
        "says": list(map(str, seen.says)),
    }
