"""Keeping a case from the page: what was found, what is left there, and who may."""

import pytest

from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.people import Person, Role
from workbench.app.records.case_folder import case_files
from workbench.app.records.cases import read_case
from workbench.app.runtime.live import Live
from workbench.gui.parts.keeping import cases_html
from workbench.gui.parts.panel import PartsPanel
from workbench.gui.shared.look import View
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy


@pytest.fixture
def panel(visitor, bench, scan):
    """Before a scan that was taken, as drawn."""
    bench.do(UseScan(scan), "Ada")
    return PartsPanel(visitor)


@pytest.fixture
def draw(panel, visitor, bench):
    def draw() -> None:
        panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))

    return draw


def find(bench, *detections):
    number = bench.do(FindParts(), "Ada").number
    bench.do(JobEnded(number, detections), "worker")


def test_a_corrected_part_is_kept_with_what_was_found(panel, visitor, bench, detections, draw):
    find(bench, *detections)
    draw()
    keeping = panel._keeping
    assert not keeping._keep.disabled and keeping._kept.content == ""
    panel._choose(1)
    T = pose_from_rpy((0.4, 0.1, 0.1), (0.0, 0.0, 0.0))
    assert panel._correct(T)
    keeping._comment.value = "it lies the other way round"
    keeping._there.value = "These parts and no others"
    before = bench.state
    keeping._press()
    (file,) = case_files(bench.folder)
    assert visitor.client.told == [f"stored as {file}"]
    # Nothing of the cycle has changed by it.
    assert bench.state is before
    case = read_case(file)
    assert digest_of(case.search.detections) == digest_of(detections)
    assert digest_of(case.truth) == digest_of(bench.state.detections)
    assert digest_of(case.changed) == digest_of(detections[1:2])
    assert (case.by, case.comment) == ("Ada", "it lies the other way round")
    assert case.is_complete
    # An engineer finds it below, and the next one begins anew.
    assert f'<a href="/cases/{file.name}" download>' in keeping._kept.content
    assert keeping._comment.value == "" and keeping._there.value == "These parts and perhaps more"


def test_a_part_that_was_missed_in_a_scan_without_any_is_kept(panel, visitor, bench, draw):
    find(bench)
    panel._add_one()
    draw()
    panel._keeping._press()
    (file,) = case_files(bench.folder)
    case = read_case(file)
    assert case.search.detections == () and len(case.truth) == 1 and not case.is_complete


def test_before_a_search_and_without_control_the_button_says_why(panel, visitor, bench, draw):
    keeping = panel._keeping
    draw()
    assert keeping._keep.disabled and "Find the parts first" in keeping._keep.hint
    find(bench)
    visitor.person = Person("Bob", Role.OPERATOR)
    bench.do(TakeControl(), "Ada")
    draw()
    assert keeping._keep.disabled and "Ada is in control" in keeping._keep.hint
    # A browser may press it all the same.
    keeping._press()
    assert visitor.client.told == ["Ada is in control; ask for control first"]
    assert case_files(bench.folder) == ()


def test_what_is_typed_is_looked_at(panel, visitor, bench, detections, draw):
    find(bench, *detections)
    bench.do(UseDetections(detections[:1], "part-2 was vetoed"), "Ada")
    keeping = panel._keeping
    keeping._comment.value = "x" * 300
    keeping._press()
    assert "comment must be a text of up to 200" in visitor.client.told[-1]
    assert case_files(bench.folder) == () and keeping._comment.value == "x" * 300


def test_only_engineers_are_given_links(tmp_path):
    file = tmp_path / "20231114-221320-yumi-3.zip"
    assert "href" in cases_html([file], Role.ENGINEER)
    plain = cases_html([file], Role.OPERATOR)
    assert file.name in plain and "href" not in plain
    assert cases_html([], Role.ENGINEER) == ""
