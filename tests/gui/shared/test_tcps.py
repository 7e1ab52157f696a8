"""What the page shows of a plan whose part is taken by another TCP than the first one."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.gui.shared.playback import in_hands, part_poses, tcp_path, timeline
from workbench.gui.shared.tables import COLUMNS, PAGE, CandidateOrder, candidates_html, on_page
from workbench.gui.shared.views import candidate_label
from workbench.model.derived.by_tcp import by_plan
from workbench.model.geometry import pose_from_rpy
from workbench.model.part_edits import with_part
from workbench.model.scan import Detection
from workbench.planning.kinematics.robot import Kinematics


@pytest.fixture(scope="module")
def shown():
    """A cell with two cups, and a plan that takes a puck by the angled one."""
    cell = read_cell("robots/tx2_90/two_cups.toml")
    library = cell.part("puck").library
    entries = (replace(library.entries[0], tcp="angled"),)
    cell = with_part(cell, "puck", library=replace(library, entries=entries))
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.05))
    return cell, plan_pick(cell, (Detection("puck", T),), "scan")


def test_the_part_moves_with_the_cup_that_holds_it(shown):
    cell, result = shown
    row, runs = [result.plan], timeline(result.plan)
    kinematics = Kinematics(cell)
    extract = next(run for run in runs if run.leg.name == "extract")
    (taken,) = part_poses(cell, kinematics, row, runs, extract.start + 1e-9)
    assert taken.isApprox(result.plan.detections[0].T_world_part, 1e-3)
    (lifted,) = part_poses(cell, kinematics, row, runs, extract.end)
    assert lifted.translation[2] > taken.translation[2] + 0.05


def test_what_a_hand_holds_is_seen_from_the_first_tcp(shown):
    cell, result = shown
    runs = timeline(result.plan)
    extract = next(run for run in runs if run.leg.name == "extract")
    kind, T = in_hands(cell, [result.plan], runs, extract.end)["right"]
    assert kind == "puck"
    T_world_tcp = Kinematics(cell).tcp_pose(cell.arms[0], extract.leg.q[-1])
    (shown_at,) = part_poses(cell, Kinematics(cell), [result.plan], runs, extract.end)
    assert (T_world_tcp * T).isApprox(shown_at, 1e-6)


def test_the_path_is_that_of_the_tcp_which_takes_the_part(shown):
    cell, result = shown
    approach = next(run for run in timeline(result.plan) if run.leg.name == "approach")
    way = tcp_path(Kinematics(cell), cell, approach, points=5)
    by = by_plan(cell, result.plan)
    T = Kinematics(by).tcp_pose(by.arms[0], np.asarray(approach.leg.q[-1]))
    np.testing.assert_allclose(way[-1], T.translation, atol=1e-9)


def test_tables_and_labels_name_the_tcp(shown):
    _, result = shown
    candidate = result.candidates[0]
    assert candidate.grasp_label == f"{candidate.grasp.name} (angled)"
    assert candidate.grasp_label in candidate_label(candidate)
    assert replace(candidate, tcp="").grasp_label == candidate.grasp.name
    shown_rows = on_page(range(len(result.candidates)), 0)
    rows = [f"row-{place}" for place in range(PAGE)]
    headings = dict.fromkeys(COLUMNS, "heading")
    html = candidates_html(
        result.candidates, shown_rows, CandidateOrder(), headings=headings, rows=rows
    )
    assert f">{candidate.grasp_label}</td>" in html
