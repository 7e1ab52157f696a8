"""`workbench part from-scans`: a model of a part; `study models`: how true such models are."""

from typing import Any

import numpy as np
from trimesh.exchange.ply import export_ply

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.cli.arguments.part import PartFromScans
from workbench.cli.arguments.studies import StudyModels
from workbench.cli.authoring.part_check import millimetres
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.extras.reconstruction.accuracy import ModelTask, made_model
from workbench.extras.reconstruction.depth_views import Bounds
from workbench.extras.reconstruction.part_views import read_views
from workbench.extras.reconstruction.reconstruct import (
    FEWEST_SCANS,
    MOST_SCANS,
    Reconstruction,
    reconstruct,
)
from workbench.formats.files.whole_files import make_folder, write_whole
from workbench.formats.meshes.repair import SurfaceReport, examine_surface
from workbench.formats.meshes.triangles import stl_of, triangles_of
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError, InputError

FILE_ENDINGS = (".ply", ".stl")


def from_scans(typed: PartFromScans) -> int:
    """Read the scans, merge them, write the model, and tell how far it can be believed."""
    kind = typed.out.suffix.lower()
    if kind not in FILE_ENDINGS:
        raise FileError(typed.out, f"is to be written as one of {', '.join(FILE_ENDINGS)}")
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


def study_models(typed: StudyModels) -> int:
    """Make the models one after the other, and tell how far they are from the truth."""
    check_whole("--views", typed.views, FEWEST_SCANS, MOST_SCANS)
    check_number("--shift-mm", typed.shift_mm, 0, 10)
    check_number("--turn-deg", typed.turn_deg, 0, 5)
    check_number("--off-mm", typed.off_mm, -100, 100)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    if typed.keep is not None and len(typed.ways) * len(typed.noise) != 1:
        raise InputError("--keep goes with one of --ways and one of --noise")
    parts = [read_part(name) for name in typed.parts]
    if typed.keep is not None:
        make_folder(typed.keep)
    cases = [(part, way, build) for part in parts for way in typed.ways for build in typed.noise]
    rows: list[dict[str, Any]] = []
    with progress("models") as report:
        for number, (part, way, build) in enumerate(cases):
            report(number / len(cases), f"{part.name}, {way}, {build}")
            shift, turn = typed.shift_mm / 1000, float(np.deg2rad(typed.turn_deg))
            task = ModelTask(way, build, typed.views, shift, turn, typed.seed, typed.off_mm / 1000)
            try:
                made = made_model(part, task)
            except InputError as error:
                if typed.keep is not None:
                    raise
                rows.append({"part": part.name, "way": way, "build": build, "refused": str(error)})
                continue
            rows.append(made.row)
            if typed.keep is not None:
                surface = triangles_of(made.reconstruction.mesh).apply_scale(1000)
                write_whole(typed.keep / f"{part.name}.ply", export_ply(surface))
    if typed.json:
        print_json({"models": rows})
        return SUCCESS
    for row in rows:
        if "refused" in row:
            print(f"{row['part']}, {row['way']}, {row['build']}, refused: {row['refused']}")
    print_table(
        f"Models from {typed.views} scans, and hulls of one: distances from the CAD files "
        "(median / 95 % / largest), and volumes over theirs",
        ("part", "way", "noise", "unseen", "model mm", "volume", "hull mm", "volume"),
        [_words(row) for row in rows if "refused" not in row],
    )
    return SUCCESS


def _words(row: dict[str, Any]) -> tuple[str, ...]:
    def distances(of: dict[str, float]) -> tuple[str, str]:
        lengths = (f"{of[key] * 1000:.2f}" for key in ("median", "p95", "hausdorff"))
        return " / ".join(lengths), f"{of['volume']:.3f}"

    return (
        row["part"],
        row["way"],
        row["build"],
        f"{row['unseen']:.1%}",
        *distances(row["model"]),
        *distances(row["hull"]),
    )
