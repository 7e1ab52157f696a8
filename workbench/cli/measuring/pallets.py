"""`workbench study pallets`: pallets in layers, filled and left to physics."""

import numpy as np

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyPallets
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.studies.cases import run_cases
from workbench.studies.picking.pallets import SEEDS, Case, fill_pallets, summary

MOST_PALLETS = 10_000


def pallets(typed: StudyPallets) -> int:
    """Carry it out and print what was found."""
    check_whole("--pallets", typed.pallets, 1, MOST_PALLETS)
    check_whole("--parts", typed.parts, 1, 200)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT // SEEDS - 1 - MOST_PALLETS)
    check_whole("--workers", typed.workers, 1, 1024)
    check_number("--off-mm", typed.off_mm, 0.0, 50.0)
    cases = [
        Case(typed.cell, typed.part, typed.parts, typed.seed + number, typed.off_mm / 1000)
        for number in range(typed.pallets)
    ]
    with progress("pallets") as report:
        make_ready(report, ("planning",))
        results = run_cases(fill_pallets, cases, workers=typed.workers, report=report)
    found = summary(results)
    if typed.json:
        print_json(found)
        return SUCCESS
    print_table(
        f"{typed.cell}: pallets in layers, hands off by {typed.off_mm:g} mm",
        ("seed", "parts", "piles", "no plan", "off", "shift mm", "lean deg", "why no more"),
        [
            (
                str(result.seed),
                f"{result.parts} of {result.places}",
                str(result.piles),
                str(result.unplanned),
                str(result.off),
                f"{result.shift * 1000:.2f}",
                f"{np.rad2deg(result.lean):.2f}",
                result.ends,
            )
            for result in results
        ],
    )
    print(
        f"{found['full']} of {found['pallets']} pallets are full, {found['stand']} stand; "
        f"{found['parts']} of {found['places']} places have a part, {found['off']} parts lie "
        f"otherwise than they were put; {found['unplanned']} of {found['piles']} piles brought no "
        "plan"
    )
    return SUCCESS
