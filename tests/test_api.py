"""What `import workbench` offers to programs."""

import inspect
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import workbench
from workbench import api

EXAMPLE = Path(__file__).resolve().parents[1] / "sessions" / "example"


def test_the_package_offers_what_its_interface_names_and_nothing_else():
    assert workbench.__all__ == sorted(api.__all__, key=lambda name: (name[0].islower(), name))
    for name in workbench.__all__:
        assert getattr(workbench, name) is getattr(api, name)
        assert name in dir(workbench)
    with pytest.raises(AttributeError, match="has no attribute 'plane'"):
        workbench.plane  # noqa: B018


@pytest.mark.parametrize("name", api.__all__)
def test_everything_says_what_it_is(name):
    assert inspect.getdoc(getattr(api, name))


def test_nothing_heavy_is_loaded_before_it_is_used():
    code = "import sys, workbench; print([n for n in ('numpy', 'pinocchio') if n in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"


def test_a_changed_plan_is_not_read(tmp_path, monkeypatch):
    cell = workbench.read_cell("yumi")
    pile = workbench.drop_parts([cell.parts[0]] * 2, cell.bin, seed=3)
    plan = workbench.plan(cell, pile).plan
    file = tmp_path / "plan.json"
    workbench.write_plan(file, plan)
    assert workbench.read_plan(file).digest == plan.digest
    file.write_text(file.read_text().replace('"seed": 0', '"seed": 1'))
    with pytest.raises(workbench.FileError, match="was changed after it was made"):
        workbench.read_plan(file)


def test_a_recorded_session_is_opened_checked_and_computed_again():
    session = workbench.open_session(str(EXAMPLE))
    try:
        assert session.verify() == ()
        history = list(workbench.replay(session))
        # The first record tells of the cell and is no entry.
        assert len(history) == session.count - 1
    finally:
        session.close()
    entry, state = history[-1]
    assert isinstance(entry, workbench.Entry) and isinstance(state, workbench.State)
    assert state.approval is not None and state.plan is not None
    assert state.approval.plan_digest == state.plan.digest


def test_a_changed_session_says_which_entry(tmp_path):
    shutil.copytree(EXAMPLE, tmp_path / "changed")
    with closing(sqlite3.connect(tmp_path / "changed" / "journal.sqlite")) as database:
        for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'"):
            database.execute(f"DROP TRIGGER {name}")
        database.execute(
            "UPDATE entries SET body = CAST(replace(body, 'demo', 'Eve') AS BLOB) WHERE number = 9"
        )
        database.commit()
    session = workbench.open_session(tmp_path / "changed")
    assert session.verify() == ("entry 9 was changed after it was written",)
    session.close()


def test_a_folder_without_a_session_is_refused(tmp_path):
    with pytest.raises(workbench.InputError, match="is not the folder of a session"):
        workbench.open_session(tmp_path)


def test_a_held_plate_is_simulated_and_sighted():
    cell, plate = workbench.read_cell("yumi"), workbench.BallPlate()
    (q,) = workbench.plate_poses(cell, plate, arm="left", count=1)
    assert q.shape == (len(cell.arm("left").joints),)
    scan = workbench.simulate_plate(cell, q, plate, arm="left", seed=1)
    seen = workbench.sight_plate(scan, plate, "one", "left", q)
    sides = np.linalg.norm(seen.balls - np.roll(seen.balls, -1, axis=0), axis=1)
    assert np.allclose(sides, plate.sides, atol=0.0005)


def test_a_calibration_without_observations_is_refused():
    with pytest.raises(workbench.InputError, match="no pose was scanned yet"):
        workbench.calibrate(workbench.read_cell("yumi"), [])
