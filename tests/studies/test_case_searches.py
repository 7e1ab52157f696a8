"""Kept cases searched again: what is right, wrong and missed, and what is worse than before."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.core.command import Entry
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.decide import decide
from workbench.app.core.people import Role
from workbench.app.core.state import State
from workbench.app.records.case_folder import FOLDER, keep_case
from workbench.app.records.cases import Case
from workbench.app.runtime.work import find_parts
from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import (
    ALL_KINDS,
    Detection,
    LocalizationResult,
    Scan,
    SearchOverrides,
    SearchRecord,
)
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent
from workbench.studies import case_searches
from workbench.studies.case_searches import Held, Tally, tally

HERE = pose_from_rpy((0.4, 0, 0.02), (1.3, 0.2, 0.5))
FAR = pose_from_rpy((0.4, 0.1, 0.02), (1.3, 0.2, 0.5))


def off(T: pin.SE3, mm: float = 0.0, degrees: float = 0.0) -> pin.SE3:
    turned = T * pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(degrees)))
    return pin.SE3(turned.rotation, turned.translation + [mm / 1000, 0, 0])


def bolt(T: pin.SE3 = HERE, *, roll_known: bool = True) -> Detection:
    return Detection("bolt", T, roll_known=roll_known)


@pytest.fixture(scope="module")
def cell():
    cell = read_cell("yumi")
    return replace(cell, parts=(read_part("bolt"), read_part("bracket")))


@pytest.fixture(scope="module")
def make(cell):
    """A case in which this was found and that lies there."""
    scan = Scan(np.zeros((1, 3)), pin.SE3.Identity(), "none")

    def make(found=(), truth=(), *, is_complete=False) -> Case:
        search = SearchRecord(2, 0, SearchOverrides(), tuple(found), 0.5)
        return Case(0.0, "Ada", "", is_complete, cell, scan, search, tuple(truth))

    return make


def counted(case: Case, *detections: Detection) -> tuple[int, int, int, int]:
    one = tally(case, detections)
    return one.right, one.wrong, one.missed, one.unjudged


def test_a_part_that_was_left_alone_is_right_within_the_limits_of_the_study(make):
    found = bolt()
    case = make([found], [found])
    assert counted(case, bolt(off(HERE, 1.9))) == (1, 0, 0, 0)
    assert counted(case, bolt(off(HERE, 2.1))) == (0, 0, 1, 1)
    # A hexagon turned by a sixth is the same; a roll that nobody knows claims nothing.
    assert counted(case, bolt(off(HERE, 0, 60))) == (1, 0, 0, 0)
    assert counted(case, bolt(off(HERE, 0, 30))) == (0, 0, 1, 1)
    assert counted(case, bolt(off(HERE, 0, 30), roll_known=False)) == (1, 0, 0, 0)


def test_what_was_corrected_is_wrong_where_it_was_and_right_near_where_a_person_has_put_it(make):
    found, put = bolt(), bolt(off(HERE, 4.5))
    case = make([found], [put])
    assert counted(case, found) == (0, 1, 1, 0)
    # People put a part less exactly than a search fits it.
    assert counted(case, bolt(off(HERE, 9.0))) == (1, 0, 0, 0)
    assert counted(case, bolt(off(HERE, 11.0))) == (0, 0, 1, 1)
    # Between the two, what is nearer counts.
    close = make([found], [bolt(off(HERE, 3.0))])
    assert counted(close, bolt(off(HERE, 1.4))) == (0, 1, 1, 0)
    assert counted(close, bolt(off(HERE, 1.6))) == (1, 0, 0, 0)


def test_what_was_moved_by_less_than_counts_was_not_called_wrong(make):
    found = bolt()
    assert counted(make([found], [bolt(off(HERE, 1.0))]), found) == (1, 0, 0, 0)
    assert counted(make([found], [bolt(off(HERE, 0, 60))]), found) == (1, 0, 0, 0)
    assert counted(make([found], [bolt(off(HERE, 0, 2))]), found) == (1, 0, 0, 0)
    assert counted(make([found], [bolt(off(HERE, 0, 4))]), found) == (0, 1, 1, 0)


def test_what_was_called_wrong_is_wrong_again_and_elsewhere_nobody_has_judged(make):
    case = make([bolt(), bolt(FAR)], [])
    assert counted(case, bolt(off(FAR, 0.5))) == (0, 1, 0, 0)
    assert counted(case, bolt(off(FAR, 50))) == (0, 0, 0, 1)
    assert counted(make([bolt()], [], is_complete=True), bolt(FAR)) == (0, 1, 0, 0)


def test_a_part_of_another_kind_or_found_twice_is_not_right(make):
    found = bolt()
    case = make([found], [found], is_complete=True)
    assert counted(case, Detection("bracket", HERE)) == (0, 1, 1, 0)
    assert counted(case, found, bolt(off(HERE, 0.1))) == (1, 1, 0, 0)


@pytest.mark.parametrize(
    ("before", "now", "change"),
    [
        (Tally((True, False)), Tally((True, True)), "better"),
        (Tally((True, False)), Tally((True, False)), ""),
        # As many are right, and one of them is lost.
        (Tally((True, False)), Tally((False, True)), "worse"),
        (Tally((True,), 1), Tally((True,), 0), "better"),
        (Tally((False,), 0), Tally((True,), 1), "worse"),
        (Tally((True,), 0, 0), Tally((True,), 0, 3), ""),
    ],
)
def test_worse_is_what_was_right_and_is_not_or_more_that_is_wrong(before, now, change):
    held = Held("one", before=before, now=now)
    assert (held.is_worse, held.is_better) == (change == "worse", change == "better")


@pytest.fixture(scope="module")
def seen(cell):
    """A scan of two brackets, and what the localizer finds in it."""
    lying = replace(cell, parts=(cell.part("bracket"),))
    scan = synthesize(lying, pile_of(lying, ALL_KINDS, 2, seed=5), seed=5)
    found = find_parts(lying, {"scan": scan, "seed": 0}, silent, never).detections
    assert len(found) == 2
    return lying, scan, found


@pytest.fixture
def session(seen, tmp_path):
    """Two cases: of a part that a search had turned over and a person turned back, and a miss."""
    cell, scan, (first, second) = seen
    at = 1_700_000_000.0

    def do(state: State, command) -> State:
        return decide(state, Entry(state.number + 1, at, "Ada", command))[0]

    def keep(found, there, comment: str) -> None:
        state = do(do(State(cell), UseScan(scan)), FindParts())
        state = do(do(state, JobEnded(state.number, found)), UseDetections(there))
        about = {"actor": "Ada", "role": Role.OPERATOR, "at": at + len(found)}
        keep_case(tmp_path, state, comment, "listed", **about)

    over = Detection("bracket", first.T_world_part * pose_from_rpy((0, 0, 0), (np.pi, 0, 0)))
    by_hand = Detection("bracket", off(first.T_world_part, 3.5, 2.0))
    keep((over, second), (by_hand, second), "turned over")
    keep((first,), (first, Detection("bracket", off(second.T_world_part, 2.0))), "one is missed")
    return tmp_path / FOLDER


def test_from_a_corrected_detection_to_the_study(session, capsys):
    assert main(["study", "localization", "--cases", str(session), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [one["comment"] for one in told["cases"]] == ["one is missed", "turned over"]
    missed, turned = ((one["before"], one["now"]) for one in told["cases"])
    assert [(one["right"], one["wrong"], one["missed"]) for one in missed] == [(1, 0, 1), (2, 0, 0)]
    assert [(one["right"], one["wrong"], one["missed"]) for one in turned] == [(1, 1, 1), (2, 0, 0)]
    assert (told["all"]["better"], told["all"]["worse"], told["all"]["parts"]) == (2, 0, 4)


def test_a_version_that_finds_less_ends_with_three_and_broken_cases_with_two(
    session, capsys, monkeypatch, tmp_path
):
    file = sorted(session.iterdir())[0]
    shutil.copy(file, tmp_path / "foreign.zip")
    (session / "broken.zip").write_bytes(file.read_bytes()[:5000])
    (session / "foreign.zip").write_bytes(b"not at all")
    # What is asked here is what is told of the cases, not what is found.
    found = LocalizationResult(())
    monkeypatch.setattr(case_searches, "find_parts", lambda *_: found)
    monkeypatch.setattr("workbench.cli.measuring.case_study.make_ready", lambda *_: None)
    assert main(["study", "localization", "--cases", str(session)]) == 3
    said = capsys.readouterr()
    assert "2 cases with 4 parts: 2 worse, 0 better; 2 could not be used" in said.out
    assert "worse" in said.out and "one is missed" in said.out and "2 / 0" in said.out
    errors = said.err.splitlines()
    assert len(errors) == 2 and all("is no zip file that can be read" in one for one in errors)
    for one in sorted(session.iterdir())[:2]:
        one.unlink()
    assert main(["study", "localization", "--cases", str(session)]) == 2


def test_a_localizer_that_breaks_on_one_case_holds_up_no_other(session, capsys, monkeypatch):
    calls = []

    def find(*_):
        calls.append(1)
        if len(calls) == 1:
            raise ZeroDivisionError("a scan without anything")
        return LocalizationResult(())

    monkeypatch.setattr(case_searches, "find_parts", find)
    monkeypatch.setattr("workbench.cli.measuring.case_study.make_ready", lambda *_: None)
    assert main(["study", "localization", "--cases", str(session), "--json"]) == 3
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert "cannot be searched: ZeroDivisionError" in told["cases"][0]["problem"]
    assert (told["all"]["cases"], told["all"]["unusable"]) == (1, 1)
    assert len(said.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--cases", "{}", "--scenes", "3"], "--cases goes with --json alone"),
        (["--cases", "{}/none"], "is no folder"),
        (["--cases", "{}"], "holds no kept case"),
    ],
)
def test_what_cannot_be_meant_is_said(tmp_path, capsys, arguments, says):
    assert main(["study", "localization", *(one.format(tmp_path) for one in arguments)]) == 2
    assert says in capsys.readouterr().err
