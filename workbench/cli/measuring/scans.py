"""`workbench study scans`: the parts found in each scan of a folder, and why others are not."""

from functools import partial

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyScans
from workbench.cli.exits import SUCCESS
from workbench.cli.picking.overlays import with_sizes, write_overlay
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan
from workbench.model.errors import InputError
from workbench.studies.scans import SearchedScan, searched_scans

SUFFIXES = (".ply", ".pcd")


def study_scans(typed: StudyScans) -> int:
    """Search, draw and tell."""
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    cell = with_sizes(read_cell(typed.cell), typed.scale)
    if not typed.folder.is_dir():
        raise InputError(f"{typed.folder}: no such folder")
    files = sorted(one for one in typed.folder.iterdir() if one.suffix.lower() in SUFFIXES)
    if not files:
        raise InputError(f"{typed.folder}: there is no PLY or PCD file")
    with progress("scans") as report:
        make_ready(report, ("seeing",))
        named = [(one.stem, partial(read_scan, one, cell.scanner)) for one in files]
        found = searched_scans(cell, named, seed=typed.seed, step=report)
    if typed.overlays is not None:
        typed.overlays.mkdir(parents=True, exist_ok=True)
        for one in found:
            path = typed.overlays / f"{one.name}.png"
            write_overlay(path, one.scan, cell, one.result.detections)
    if typed.json:
        print_json({"scans": [_form(one) for one in found]})
        return SUCCESS
    print_table(
        f"{len(found)} scans",
        ("scan", "found", "sure", "chances", "not taken", "s of processor"),
        [_row(one) for one in found],
    )
    for one in found:
        for size in one.result.scales:
            if size.is_off:
                print(f"{one.name}: {size.words} (± {size.deviation * 100:.1f} %)")
    return SUCCESS


def _row(one: SearchedScan) -> tuple[str, ...]:
    chances = " ".join(f"{each.probability or 0.0:.2f}" for each in one.result.detections)
    why = ", ".join(f"{count} {reason}" for reason, count in one.why.items())
    found = str(len(one.result.detections))
    return one.name, found, str(one.sure), chances, why, f"{one.processor_seconds:.2f}"


def _form(one: SearchedScan) -> dict[str, object]:
    return {
        "scan": one.name,
        "found": len(one.result.detections),
        "sure": one.sure,
        "scores": [each.score for each in one.result.detections],
        "chances": [each.probability for each in one.result.detections],
        "not_taken": dict(one.why),
        "scales": [[each.part, each.ratio, each.deviation] for each in one.result.scales],
        "processor_seconds": one.processor_seconds,
    }
