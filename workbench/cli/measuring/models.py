"""`workbench study models`: models from several scans beside the parts' CAD files."""

from typing import Any

import numpy as np
from trimesh.exchange.ply import export_ply

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.cli.arguments.studies import StudyModels
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.files.whole_files import make_folder, write_whole
from workbench.formats.meshes.triangles import triangles_of
from workbench.formats.parts.reading import read_part
from workbench.model.errors import InputError
from workbench.perception.reconstruction.reconstruct import FEWEST, MOST
from workbench.studies.models import ModelTask, made_model


def study_models(typed: StudyModels) -> int:
    """Make the models one after the other, and tell how far they are from the truth."""
    check_whole("--views", typed.views, FEWEST, MOST)
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
