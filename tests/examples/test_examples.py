"""The examples run, and say what they are there to show."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples"

SAYS = {
    "bent_plan": ["objections, the first: arm", "refused: "],
    "own_grasps": ["grasps suggested: suggested", "taken by: ", " arm, suggested"],
    "scan_to_plan": ["2 parts in the bin, 2 found", "proven: True"],
    "why_not": [" tool collision", "nearest fix: "],
}


def test_every_example_is_tried():
    assert {path.stem for path in FOLDER.glob("*.py")} == set(SAYS)


@pytest.mark.parametrize("name", SAYS)
def test_an_example_runs(name, tmp_path):
    said = subprocess.run(
        [sys.executable, FOLDER / f"{name}.py"], capture_output=True, text=True, cwd=tmp_path
    )
    assert said.returncode == 0, said.stderr
    for words in SAYS[name]:
        assert words in said.stdout
