"""`workbench study bop`: the localizer on a data set in BOP's layout, measured as BOP does it."""

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyBop
from workbench.cli.exits import SUCCESS
from workbench.cli.measuring.precision_columns import BOP_COLUMNS, bop_words
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.extras.bop.models import INFO
from workbench.extras.bop.results import read_results, write_results
from workbench.extras.bop.searching import DataSet, figures_of
from workbench.formats.cells.reading import read_cell

HIGHEST_COUNT = 1_000_000


def study_bop(typed: StudyBop) -> int:
    """Search or read, and measure."""
    check_whole("--images", typed.images, 0, HIGHEST_COUNT)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    cell = read_cell(typed.cell)
    data = DataSet.read(typed.folder, typed.split, typed.models, typed.sensor, typed.images)
    if typed.results is None:
        with progress("bop") as report:
            make_ready(report, ("seeing",))
            found = data.search(cell, typed.seed, report, is_own_bin=typed.own_bin)
    else:
        found = read_results(typed.results)
    if typed.out is not None:
        write_results(typed.out, found)
    figures = figures_of(data, found)
    if typed.json:
        print_json({"images": len(data.images), "found": len(found), **figures})
        return SUCCESS
    if not (typed.folder / typed.models / INFO).exists():
        print(f"{INFO} is missing: diameters are those of the meshes, no object has a symmetry")
    rows = [
        (name, str(figures_of_object["targets"]), *bop_words(figures_of_object))
        for name, figures_of_object in figures["objects"].items()
    ]
    total = sum(figures_of_object["targets"] for figures_of_object in figures["objects"].values())
    rows.append(("all", str(total), *bop_words(figures)))
    print_table(
        f"{len(data.images)} images, {len(found)} found; average precision as BOP 2024 has it",
        ("object", "to be found", *BOP_COLUMNS),
        rows,
    )
    seconds = figures["seconds"]
    if seconds is not None:
        print(f"{seconds:.2f} s an image")
    return SUCCESS
