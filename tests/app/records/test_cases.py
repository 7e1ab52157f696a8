"""Cases that are kept: whole, self-contained, bounded, and read with nothing taken on trust."""

import json
import random
import zipfile
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
from workbench.app.core.state import Phase, State
from workbench.app.records import case_folder, cases
from workbench.app.records.case_folder import case_files, keep_case
from workbench.app.records.cases import Case, read_case
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, FileError, WorkbenchError
from workbench.model.scan import Detection, SearchOverrides

AT = 1_700_000_000.0


def after(state: State, *commands) -> State:
    for command in commands:
        number = state.number + 1
        state = decide(state, Entry(number, AT + number, "Ada", command))[0]
    return state


def searched(samples, *detections: Detection, is_compared: bool = False, state=None) -> State:
    """A scan in which a search has found this."""
    state = state or after(State(samples.cell), UseScan(samples.scan(points=2000)))
    state = after(state, FindParts(7, SearchOverrides(1.5), is_compared))
    return after(state, JobEnded(state.number, detections))


@pytest.fixture
def keep(tmp_path):
    """Keeps a case in the folder of a session, as an operator."""

    def keep(state: State, comment="the left one is turned", there="listed", **who) -> Case:
        about = {"actor": "Ada", "role": Role.OPERATOR, "at": AT, **who}
        return read_case(keep_case(tmp_path, state, comment, there, **about))

    return keep


def moved(one: Detection, x: float) -> Detection:
    return Detection(one.part, pin.SE3(np.eye(3), one.T_world_part.translation + [x, 0, 0]))


def test_a_case_holds_all_that_it_takes_to_search_again(samples, keep, tmp_path):
    found = (*samples.detections(0), *samples.detections(1), *samples.detections(2))
    state = searched(samples, *found)
    there = (found[0], moved(found[1], 0.01))
    case = keep(after(state, UseDetections(there, "one is corrected, one vetoed")))
    assert case.cell.digest == samples.cell.digest and case.scan.digest == state.scan.digest
    np.testing.assert_array_equal(case.scan.points, state.scan.points)
    assert (case.scan.resolution, case.scan.source) == ((64, 48), "sample")
    assert (case.search.seed, case.search.overrides.detail) == (7, 1.5)
    assert digest_of(case.search.detections) == digest_of(found)
    assert digest_of(case.truth) == digest_of(there)
    assert [digest_of(one) for one in case.changed] == [digest_of(one) for one in found[1:]]
    assert (case.by, case.comment, case.is_complete) == ("Ada", "the left one is turned", False)
    (file,) = case_files(tmp_path)
    assert file == tmp_path / "cases" / f"20231114-221320-sample-{state.number + 1}.zip"
    # People read it with what they have.
    with zipfile.ZipFile(file) as archive:
        told = json.loads(archive.read("case.json"))
    assert told["scan_digest"] == state.scan.digest
    assert told["part_digests"] == {"peg": samples.cell.part("peg").digest}


def test_what_was_missed_in_a_scan_without_a_part_is_kept(samples, keep):
    state = searched(samples)
    assert not state.detections
    missed = samples.detections(3)
    case = keep(
        after(state, UseDetections(missed, "a peg was added by hand")), there="listed alone"
    )
    assert case.search.detections == () and case.is_complete
    assert digest_of(case.truth) == digest_of(missed)


def test_that_nothing_lies_there_is_said_of_a_list_that_cannot_be_empty(samples, keep):
    case = keep(searched(samples, *samples.detections()), there="nothing")
    assert case.truth == () and case.is_complete and len(case.changed) == 1


def test_a_search_that_was_only_compared_is_not_what_was_found(samples, keep):
    first = searched(samples, *samples.detections(0), *samples.detections(1))
    both = searched(samples, *samples.detections(4), is_compared=True, state=first)
    case = keep(after(both, UseDetections(samples.detections(1), "part-1 was vetoed")))
    assert digest_of(case.search.detections) == digest_of(first.detections)


@pytest.mark.parametrize(
    ("who", "says"),
    [
        ({"role": Role.VIEWER}, "storing a case is for operators; you are a viewer"),
        ({"comment": "two\nlines"}, "comment must be a text of up to 200"),
        ({"comment": "x" * 201}, "comment must be a text of up to 200"),
        ({"there": "much"}, "there 'much' is not known"),
    ],
)
def test_who_may_not_correct_keeps_nothing_nor_what_is_no_line(samples, keep, tmp_path, who, says):
    with pytest.raises(CommandRefused, match=says):
        keep(searched(samples, *samples.detections()), **who)
    assert case_files(tmp_path) == ()


def test_who_is_not_in_control_keeps_nothing(samples, keep):
    state = replace(searched(samples, *samples.detections()), control="Bob")
    with pytest.raises(CommandRefused, match="Bob is in control"):
        keep(state)


def test_while_a_plan_is_sent_nothing_is_packed(samples, keep):
    state = searched(samples, *samples.detections())
    with pytest.raises(CommandRefused, match="wait until the sending has ended"):
        keep(replace(state, phase=Phase.SENDING))
    assert keep(replace(state, phase=Phase.FAULT)).truth


def test_without_a_search_there_is_nothing_to_keep(samples, keep):
    with pytest.raises(CommandRefused, match="find the parts first"):
        keep(after(State(samples.cell), UseScan(samples.scan())))


def test_so_many_cases_are_kept_and_the_same_one_once(samples, keep, tmp_path, monkeypatch):
    monkeypatch.setattr(case_folder, "MOST_CASES", 2)
    state = searched(samples, *samples.detections())
    keep(state)
    with pytest.raises(CommandRefused, match="stored a moment ago"):
        keep(state)
    keep(state, at=AT + 1)
    with pytest.raises(CommandRefused, match="this session has 2 cases"):
        keep(state, at=AT + 2)
    assert len(case_files(tmp_path)) == 2


def test_what_is_too_large_to_be_read_is_not_written(samples, keep, tmp_path, monkeypatch):
    monkeypatch.setattr(cases, "LARGEST_CASE", 20_000)
    with pytest.raises(FileError, match="would have 0 MB; up to 0 are stored"):
        keep(searched(samples, *samples.detections()))
    assert list((tmp_path / "cases").iterdir()) == []


@pytest.fixture
def bent(samples, keep, tmp_path):
    """Writes a case anew with one of its files changed."""
    keep(searched(samples, *samples.detections()))
    (file,) = case_files(tmp_path)
    with zipfile.ZipFile(file) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}

    def bend(name: str, change):
        path = tmp_path / "bent.zip"
        with zipfile.ZipFile(path, "w") as archive:
            for one, data in content.items():
                if (data := change(data) if one.startswith(name) else data) is not None:
                    archive.writestr(one, data)
        return path

    return bend


@pytest.mark.parametrize(
    ("name", "change", "says"),
    [
        ("case.json", lambda _: None, "there is no case.json in it"),
        ("case.json", lambda _: b"[]", "can be read"),
        ("case.json", lambda data: data.replace(b"case/1", b"case/9"), "its format is"),
        ("case.json", lambda data: data.replace(b'"peg",', b'"pig",'), "pig"),
        ("case.json", lambda data: data.replace(b'"seed": 7', b'"seed": -7'), "seed must be"),
        ("cell.json", lambda data: data.replace(b"sample", b"simple"), "its cell was changed"),
        ("scan.json", lambda data: data.replace(b"64", b"65", 1), "its scan was changed"),
        ("files/", lambda data: data[:-8] + bytes(8), "its scan was changed"),
        ("files/", lambda data: data[8:], "can be read"),
        ("files/", lambda _: None, "is no case that can be read"),
        ("scan.json", lambda _: b"{" * 100_000, "can be read"),
    ],
)
def test_what_was_changed_or_is_foreign_is_refused_in_a_sentence(bent, name, change, says):
    path = bent(name, change)
    with pytest.raises(FileError, match=says) as refused:
        read_case(path)
    assert str(refused.value).startswith(str(path)) and "\n" not in str(refused.value)


def test_whatever_comes_instead_of_a_case_is_a_case_or_refused(bent):
    drawn = random.Random(0)
    for _ in range(60):
        name = drawn.choice(["case.json", "cell.json", "scan.json"])

        def mutated(data: bytes) -> bytes:
            place = drawn.randrange(len(data))
            return (
                data[:place]
                + drawn.choice([b"", b"-", b"null", b"[", b"1e999"])
                + data[place + 1 :]
            )

        try:
            assert isinstance(read_case(bent(name, mutated)), Case)
        except WorkbenchError as error:
            assert isinstance(error, FileError)


def test_what_is_no_zip_file_is_no_case(tmp_path):
    file = tmp_path / "20231114-221320-sample-3.zip"
    file.write_bytes(b"PK\3\4 but no more")
    with pytest.raises(FileError, match="no zip file"):
        read_case(file)
