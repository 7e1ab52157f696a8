"""What was found wrongly, kept from the page in a real browser."""

import numpy as np
import pytest
from hands import field
from idle import Idle

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.records.case_folder import case_files
from workbench.app.records.cases import read_case
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Scan


@pytest.fixture
def bench(tmp_path):
    """In which a search has brought two parts, one of which a person has vetoed; nothing works."""
    cell = read_cell("yumi")
    bench = Bench(cell, Journal(tmp_path / "session"), effects=Idle)
    p_bin = np.random.default_rng(0).uniform(-0.1, 0.1, (3000, 3)) * [1, 1, 0.2] + [0, 0, 0.03]
    T_scanner_bin = cell.scanner.T_world_scanner.actInv(cell.bin.T_world_bin)
    points = p_bin @ T_scanner_bin.rotation.T + T_scanner_bin.translation
    bench.do(UseScan(Scan(points, cell.scanner.T_world_scanner, "drawn")), "Ada")
    found = tuple(
        Detection("keyed_cylinder", cell.bin.T_world_bin * pose_from_rpy((0, y, 0.02)), 0.9)
        for y in (-0.05, 0.05)
    )
    number = bench.do(FindParts(), "Ada").number
    bench.do(JobEnded(number, found), "worker")
    bench.do(UseDetections(found[:1], "part-2 was vetoed"), "Ada")
    yield bench
    bench.close()


def test_a_case_is_kept_and_stands_below_the_button(screen, bench, wait):
    screen.tab("Parts")
    screen.page.get_by_text("Keep as a case", exact=True).first.click()
    field(screen, "Comment").fill("part-2 is a shadow")
    screen.page.get_by_role("button", name="Keep as a case").last.click()
    wait(lambda: len(case_files(bench.folder)) == 1, "the case")
    (file,) = case_files(bench.folder)
    link = screen.page.get_by_role("link", name=file.name)
    link.wait_for()
    link.scroll_into_view_if_needed()
    screen.shoot("parts-kept")
    assert link.get_attribute("href") == f"/cases/{file.name}"
    screen.page.get_by_text("stored as").first.wait_for()
    case = read_case(file)
    assert (len(case.search.detections), len(case.changed), len(case.truth)) == (2, 1, 1)
    assert case.comment == "part-2 is a shadow" and not case.is_complete
    assert screen.errors == []
