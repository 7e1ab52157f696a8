"""`workbench study scans`: the parts found in each scan of a folder, and why others are not."""

from functools import partial

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyScans
from workbench.cli.exits import SUCCESS
from workbench.cli.picking.overlays import write_overlay
from workbench.cli.picking.sizes import sizes_of
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan
from workbench.model.errors import InputError
from workbench.perception.parts.sizing import with_sizes
from workbench.studies.scans import SearchedScan, searched_scans

SUFFIXES = (".ply", ".pcd")


def study_scans(typed: StudyScans) -> int:
    """Search each scan, draw what was found, and print a table."""
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    cell = read_cell(typed.cell)
    cell = with_sizes(cell, sizes_of(cell, typed.scale))
    if not typed.folder.is_dir():
        raise InputError(f"{typed.folder}: no such folder")
    files = sorted(file for file in typed.folder.iterdir() if file.suffix.lower() in SUFFIXES)
    if not files:
        raise InputError(f"{typed.folder}: there is no PLY or PCD file")
    with progress("scans") as report:
        make_ready(report, ("seeing",))
        named = [(file.stem, partial(read_scan, file, cell.scanner)) for file in files]
        found = searched_scans(cell, named, seed=typed.seed, step=report)
    if typed.overlays is not None:
        typed.overlays.mkdir(parents=True, exist_ok=True)
        for searched in found:
            path = typed.overlays / f"{searched.name}.png"
            write_overlay(path, searched.scan, cell, searched.result.detections)
    if typed.json:
        print_json({"scans": [_form(searched) for searched in found]})
        return SUCCESS
    print_table(
        f"{len(found)} scans",
        ("scan", "found", "sure", "chances", "not taken", "s of processor"),
        [_row(searched) for searched in found],
    )
    for searched in found:
        for size in searched.result.scales:
            if size.is_off:
                print(f"{searched.name}: {size.words} (± {size.deviation * 100:.1f} %)")
        for surface in searched.result.offsets:
            if surface.is_off:
                print(f"{searched.name}: {surface.words} (± {surface.deviation * 1000:.1f} mm)")
    return SUCCESS


def _row(searched: SearchedScan) -> tuple[str, ...]:
    chances = " ".join(f"{each.probability or 0.0:.2f}" for each in searched.result.detections)
    why = ", ".join(f"{count} {reason}" for reason, count in searched.why.items())
    found = str(len(searched.result.detections))
    return (
        searched.name,
        found,
        str(searched.sure),
        chances,
        why,
        f"{searched.processor_seconds:.2f}",
    )


def _form(searched: SearchedScan) -> dict[str, object]:
    return {
        "scan": searched.name,
        "found": len(searched.result.detections),
        "sure": searched.sure,
        "scores": [each.score for each in searched.result.detections],
        "chances": [each.probability for each in searched.result.detections],
        "not_taken": dict(searched.why),
        "scales": [[each.part, each.ratio, each.deviation] for each in searched.result.scales],
        "processor_seconds": searched.processor_seconds,
    }
