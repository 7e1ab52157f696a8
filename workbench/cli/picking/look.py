"""`workbench scan` and `workbench localize`: from a bin to a cloud, from a cloud to poses."""

from collections.abc import Mapping

import numpy as np

from workbench.app.core.value_checks import DETAIL, MOST_PARTS, SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.picking.sizes import sizes_of, store_sizes
from workbench.cli.terminal import check_number, check_whole, print_table, progress
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.formats.plans.pose_files import write_poses
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import as_chosen
from workbench.model.scan import (
    Detection,
    LocalizationResult,
    RejectedHypothesis,
)
from workbench.perception.bins.bin_check import check_bin
from workbench.perception.bins.fill_level import parts_in_words
from workbench.perception.parts.sizing import learn_sizes, with_sizes
from workbench.perception.scene.sensor import sensor_model
from workbench.plugins.localizer import find_parts


def scan(typed: arguments.ScanArguments) -> int:
    """Write a simulated scan and, when asked for, where the parts truly are."""
    # Bring MuJoCo and Open3D along, which `localize` does not wait for before it reads its scan.
    from workbench.perception.simulation.piles import pile_of
    from workbench.perception.simulation.synthesize import synthesize

    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    check_whole("--parts", typed.parts, 1, MOST_PARTS)
    cell = as_chosen(read_cell(typed.cell), typed.recipe, typed.bin, typed.view)
    with progress("scan") as report:
        report(0.1, "parts fall into the bin")
        truth = pile_of(cell, typed.part, typed.parts, seed=typed.seed)
        report(0.6, "the scanner looks")
        found = synthesize(cell, truth, seed=typed.seed)
        write_cloud(typed.out, found, unit=cell.scanner.unit, axes=cell.scanner.cloud_axes)
    if typed.truth is not None:
        write_poses(typed.truth, truth)
    print(f"{typed.out}: {len(found.points):,} points")
    return 0


def localize(typed: arguments.Localize) -> int:
    """Find all parts that the cell knows in a scan, and write their poses."""
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    check_number("--detail", typed.detail, *DETAIL)
    check_number("--least-score", typed.least_score, 0.0, 1.0)
    filed = as_chosen(read_cell(typed.cell), typed.recipe, typed.bin, typed.view)
    sizes = {part.name: 1.0 for part in filed.parts} | sizes_of(filed, typed.scale)
    cell = with_sizes(filed, sizes)
    with progress("localize") as report:
        make_ready(report, ("seeing",))
        cloud = read_scan(typed.scan, cell.scanner)

        def search(sized: Cell) -> LocalizationResult:
            return find_parts(
                cloud,
                sized,
                seed=typed.seed,
                detail=typed.detail,
                least_score=typed.least_score,
                report=report,
            )

        if typed.learn:
            findings, cell, learnt = learn_sizes(cell, search, tuple(sizes))
            sizes = {name: size * learnt.get(name, 1.0) for name, size in sizes.items()}
        else:
            findings = search(cell)
    found = findings.detections
    write_poses(typed.out, found)
    if typed.overlay is not None:
        from workbench.cli.picking.overlays import write_overlay

        write_overlay(typed.overlay, cloud, cell, found)
    rows = (
        (
            str(number),
            detection.part,
            *(f"{p * 1000:.1f}" for p in detection.T_world_part.translation),
            f"{detection.score:.2f}",
            f"{detection.visible:.2f}",
            *_sureness(detection),
        )
        for number, detection in enumerate(found, start=1)
    )
    columns = ("#", "part", "x mm", "y mm", "z mm", "score", "visible", "sure", "± mm", "± degrees")
    print_table(f"{typed.out}: {len(found)} found", columns, rows)
    if typed.rejected:
        columns = ("part", "x mm", "y mm", "z mm", "score", "why it is none")
        print_table(
            "Rejected", columns, [_rejected_words(rejection) for rejection in findings.rejected]
        )
    _report_sizes(typed, filed, findings, sizes)
    noise = sensor_model(cloud.points).noise
    if noise is not None:
        print(f"scanner: noise of {noise * 1000:.2f} mm at 1 m in this scan")
    check = check_bin(cloud, cell.bin)
    print(f"bin, {check.light}: {check.says}; {parts_in_words(cell, check, found)} found")
    return 0


def _report_sizes(
    typed: arguments.Localize,
    filed: Cell,
    findings: LocalizationResult,
    sizes: Mapping[str, float],
) -> None:
    """Print what differs from the CAD files, or write it into the parts of the cell's file."""
    if typed.learn:
        for line in store_sizes(cell_path(typed.cell), filed, sizes, findings):
            print(line)
        return
    for check in findings.scales:
        if check.is_off:
            size = sizes.get(check.part, 1.0) * check.ratio
            print(
                f"size: {check.words} (± {check.deviation * 100:.1f} %, by {check.count} parts); "
                f"with that size: --scale {check.part}={size:.2f}; "
                "--learn writes it into the part"
            )
    for check in findings.offsets:
        if check.is_off:
            print(
                f"surface: {check.words} (± {check.deviation * 1000:.1f} mm, by {check.count} "
                "parts); the poses allow for it; --learn writes it into the part"
            )


def _sureness(detection: Detection) -> tuple[str, str, str]:
    """How likely it is right, and the standard deviations of its place and turn."""
    if detection.probability is None or detection.deviations is None:
        return "", "", ""
    place, turn = detection.deviations
    return f"{detection.probability:.0%}", f"{place * 1000:.2f}", f"{np.rad2deg(turn):.2f}"


def _rejected_words(hypothesis: RejectedHypothesis) -> tuple[str, ...]:
    place = (f"{p * 1000:.1f}" for p in hypothesis.T_world_part.translation)
    return (hypothesis.part, *place, f"{hypothesis.score:.2f}", str(hypothesis.words))
