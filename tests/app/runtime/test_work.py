"""The real jobs, as the worker runs them: from a seed to a proven plan."""

import dataclasses
import shutil

import pinocchio as pin
import pytest

from workbench.app.picking.part_import import excess_of
from workbench.app.runtime import work
from workbench.app.runtime.work import JOBS
from workbench.formats.cells.reading import part_folders, read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.formats.parts.saves import save_part
from workbench.formats.parts.scales import write_shape
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import PlanOverrides
from workbench.model.errors import InputError, JobCancelled
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.plan import PlanResult
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="module")
def yumi():
    return read_cell("yumi")


def run(name, cell, arguments, cancelled=lambda: False):
    """A job's result and what it reported."""
    told = []
    result = JOBS[name](cell, arguments, lambda *what: told.append(what), cancelled)
    return result, told


def test_the_jobs_lead_from_a_seed_to_a_proven_plan(yumi):
    scan, told = run("scan", yumi, {"seed": 0, "parts": 2})
    assert [str(note) for _, note in told] == [
        "parts fall into the bin",
        "the scanner takes the picture",
    ]
    again, _ = run("scan", yumi, {"seed": 0, "parts": 2})
    assert again.digest == scan.digest
    findings, _ = run("localize", yumi, {"scan": scan, "seed": 0})
    detections = findings.detections
    assert len(detections) == 2
    assert [one.score for one in detections] == sorted(
        (one.score for one in detections), reverse=True
    )
    arguments = {
        "detections": detections,
        "scan_digest": scan.digest,
        "scan": scan,
        "strategy": "auto",
        "threshold": 0.2,
        "overrides": PlanOverrides(planner="sbl"),
        "placed": (),
        "avoided": (),
        "wanted": None,
        "seed": 0,
    }
    result, told = run("plan", yumi, arguments)
    assert result.plan.scan_digest == scan.digest
    assert result.proof.holds
    assert result.proof.plan_digest == result.plan.digest
    shares = [done for done, _ in told]
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] <= 1


def test_a_refusal_within_the_accuracy_of_the_bodies_says_so(yumi, monkeypatch):
    cell = dataclasses.replace(yumi, parts=(read_part("bracket"),))
    part = cell.parts[0]
    grasp = part.library.grasps[0]
    verdict = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, ("left finger_a", "part-1"), 0.0)
    one = Candidate(0, grasp, "left", grasp.T_part_tcp, 0.0, verdict)
    result = PlanResult((one,), None, None, verdict, {})
    monkeypatch.setattr(work, "plan_row", lambda *_, **__: result)
    arguments = {
        "detections": (Detection(part.name, pin.SE3.Identity()),),
        "scan_digest": "",
        "scan": None,
        "strategy": "auto",
        "threshold": 0.2,
        "overrides": PlanOverrides(),
        "placed": (),
        "avoided": (),
        "wanted": None,
        "seed": 0,
    }
    found, _ = run("plan", cell, arguments)
    assert found.candidates[0].verdict.note == VerdictNote.INEXACT(excess=excess_of(part))


def test_a_cancelled_job_ends_as_cancelled(yumi):
    with pytest.raises(JobCancelled):
        run("scan", yumi, {"seed": 0, "parts": 2}, cancelled=lambda: True)


def test_a_cell_without_parts_cannot_be_scanned(cell):
    with pytest.raises(InputError, match="has no part"):
        run("scan", dataclasses.replace(cell, parts=()), {"seed": 0, "parts": 2})


@pytest.fixture
def larger(tmp_path, monkeypatch, yumi):
    """A cell whose part is 8 % larger in its file than in a scan, its file and the scan."""
    monkeypatch.chdir(tmp_path)
    for kind, name in (("robots", "yumi"), ("parts", "keyed_cylinder")):
        shutil.copytree(find(kind, name), tmp_path / kind / name)
    scan = synthesize(yumi, pile_of(yumi, "", 4, seed=3), seed=3)
    write_shape(tmp_path / "parts/keyed_cylinder", 1.08, 0.0)
    file = tmp_path / "robots/yumi/cell.toml"
    return read_cell(file), file, scan


@pytest.mark.extensive
def test_a_part_is_read_in_the_size_that_the_scan_shows_and_its_file_stays(larger):
    cell, file, scan = larger
    name = cell.parts[0].name
    arguments = {"scan": scan, "seed": 0, "part": name, "cell_file": file}
    part, told = run("correct", cell, arguments)
    assert part.scale == pytest.approx(1.0, abs=0.003) and part.offset == 0.0
    assert read_cell(file).digest == cell.digest
    shares = [done for done, _ in told]
    assert shares == sorted(shares) and 0 <= shares[0] <= shares[-1] <= 1
    # Saved, it is read as it is now: nothing that was found with it becomes void.
    save_part(part_folders(file)[name], cell.parts[0], part, actor="ada", at=0.0, remark="")
    assert read_cell(file).parts[0].digest == part.digest
    sized = dataclasses.replace(cell, parts=(part,))
    with pytest.raises(InputError, match="in the size that it has"):
        run("correct", sized, arguments)


def test_a_part_of_a_session_without_a_file_is_not_corrected(yumi):
    arguments = {"scan": None, "seed": 0, "part": "keyed_cylinder", "cell_file": None}
    with pytest.raises(InputError, match="no cell file"):
        run("correct", yumi, arguments)
