"""`workbench part from-scans`: a closed model of a part from several scans of it."""

from typing import Any

import numpy as np
from trimesh.exchange.ply import export_ply

from workbench.cli.arguments.part import PartFromScans
from workbench.cli.authoring.part_check import millimetres
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, print_json, progress
from workbench.formats.clouds.part_views import read_views
from workbench.formats.files.whole_files import write_whole
from workbench.formats.meshes.repair import SurfaceReport, examine_surface
from workbench.formats.meshes.triangles import stl_of, triangles_of
from workbench.model.errors import FileError
from workbench.perception.reconstruction.depth_views import Bounds
from workbench.perception.reconstruction.reconstruct import Reconstruction, reconstruct

KINDS = (".ply", ".stl")


def from_scans(typed: PartFromScans) -> int:
    """Read the scans, merge them, write the model, and tell how far it can be believed."""
    kind = typed.out.suffix.lower()
    if kind not in KINDS:
        raise FileError(typed.out, f"is to be written as one of {', '.join(KINDS)}")
    if typed.out.exists():
        raise FileError(typed.out, "is there already; choose another name")
    if not typed.out.parent.is_dir():
        raise FileError(typed.out, f"there is no folder {typed.out.parent}")
    check_number("--tolerance-mm", typed.tolerance_mm, 0.01, 5)
    if typed.voxel_mm is not None:
        check_number("--voxel-mm", typed.voxel_mm, 0.05, 20)
    with progress("from scans") as report:
        report(0.0, "reading")
        views = read_views(typed.folder)
        report(0.2, "merging")
        made = reconstruct(
            views.scans,
            Bounds(views.low, views.high),
            voxel=None if typed.voxel_mm is None else typed.voxel_mm / 1000,
            tolerance=typed.tolerance_mm / 1000,
            refine=not typed.as_given,
        )
    surface = triangles_of(made.mesh)
    surface.apply_scale(1000)
    write_whole(typed.out, export_ply(surface) if kind == ".ply" else stl_of(surface))
    look = examine_surface(made.mesh)
    if typed.json:
        print_json(_form(typed, made, look))
    else:
        _print(typed, made, look, len(views.scans))
    return SUCCESS


def _form(typed: PartFromScans, made: Reconstruction, look: SurfaceReport) -> dict[str, Any]:
    given, used = made.apart
    return {
        "ok": True,
        "file": str(typed.out),
        "size_mm": np.round(look.size * 1000, 3).tolist(),
        "volume_cm3": round(look.volume * 1e6, 4),
        "triangles": look.triangles,
        "unseen": round(made.unseen, 4),
        "voxel_mm": round(made.voxel * 1000, 4),
        "shared": round(made.shared, 4),
        "apart_mm": {"given": round(given * 1000, 4), "used": round(used * 1000, 4)},
    }


def _print(typed: PartFromScans, made: Reconstruction, look: SurfaceReport, count: int) -> None:
    given, used = made.apart
    print(f"{count} scans, voxels of {made.voxel * 1000:.2f} mm")
    said = f"{given * 1000:.2f} mm apart in the median with the poses as given"
    print(f"scans {said}" if used == given else f"scans {said}, {used * 1000:.2f} mm as used")
    print(f"each has {made.shared:.0%} or more of what it shows of the part in common with others")
    print(
        f"size {millimetres(look.size)} mm, {look.volume * 1e6:.4g} cm3, "
        f"{look.triangles} triangles, closed"
    )
    print(f"{made.unseen:.1%} of the surface no scan shows: it was closed there")
    print(f"written to {typed.out}, in mm: workbench part import {typed.out} --unit mm --name NAME")
