"""A table instead of a bin: the shipped cell without walls, from a scan to a plan that holds."""

import re
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from judge import Judge
from judge_files import read

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.scan import Detection
from workbench.perception.localization.kinds import localize_parts
from workbench.perception.scene.unexplained import unexplained
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent
from workbench.proof.claims.prove import prove
from workbench.studies.localization import compare

SHIPPED = find("robots", "yumi")


def written(folder: Path, kind: str) -> Path:
    """The folder of the shipped cell, its bin a table, with parts of a kind."""
    folder.mkdir()
    for one in SHIPPED.iterdir():
        if one.suffix != ".toml":
            (folder / one.name).symlink_to(one)
    text = (SHIPPED / "cell.toml").read_text(encoding="utf-8")
    text = re.sub(r"^parts = .*$", f'parts = ["{kind}"]', text, flags=re.MULTILINE)
    text = text.replace("wall_mm = 3\n", "wall_mm = 3\nwalls = false\n")
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.parametrize("kind", ["keyed_cylinder", "bracket", "bolt", "puck"])
def test_parts_on_a_table_are_found_and_the_plan_holds_before_the_judge(kind, tmp_path):
    folder = written(tmp_path / "table", kind)
    cell, files = read_cell(folder), read(folder, SHIPPED.parents[1] / "parts", "cell.toml")
    pile = pile_of(cell, "", 5, seed=7)
    scan = synthesize(cell, pile, seed=7)
    found = localize_parts(
        scan, cell, seed=7, detail=1.0, report=silent, cancelled=never
    ).result.detections
    told, _ = compare(cell.parts, pile, found)
    assert all(one.is_right for one in told) and len(found) >= 4
    obstacles = unexplained(cell, scan, found)
    plan = plan_pick(cell, found, scan.digest, obstacles=obstacles, seed=7).plan
    assert plan is not None
    assert prove(cell, plan.scene, plan).holds
    assert Judge().refusal(files, plan.scene, plan) is None


def test_a_part_that_reaches_over_the_side_is_found(tmp_path):
    cell = read_cell(written(tmp_path / "table", "keyed_cylinder"))
    (one,) = pile_of(cell, "", 1, seed=3)
    T = one.T_world_part
    side = cell.bin.T_world_bin.translation[1] + cell.bin.size[1] / 2
    moved = Detection(
        one.part, pin.SE3(T.rotation, np.array([T.translation[0], side - 0.008, T.translation[2]]))
    )
    scan = synthesize(cell, (moved,), seed=3)
    (found,) = localize_parts(
        scan, cell, seed=3, detail=1.0, report=silent, cancelled=never
    ).result.detections
    off = found.T_world_part.translation - moved.T_world_part.translation
    assert np.linalg.norm(off) < 0.001
