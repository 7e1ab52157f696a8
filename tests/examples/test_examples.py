"""The examples run, and say what they are there to show."""

import runpy
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples"

SAYS = {
    "bent_plan": ["objections, the first: arm", "refused: "],
    "calibration": ["the cell file: 20.81 mm", "measured:      0.", "the cell remembers 8 poses"],
    "own_grasps": ["grasps suggested: suggested", "taken by: ", " arm, suggested"],
    "own_localizer": ["4 parts found coarsely, 4 finely, 4 by both", "proven: True"],
    "own_robot": ["an arm of 6 joints", "3 parts in the bin, 3 found", "proven: True", "reach, "],
    "reading_a_journal": [
        "the chain holds",
        "robot link Sent x ",
        "approved: plan ",
        "sent:     plan ",
    ],
    "scan_to_plan": ["2 parts in the bin, 2 found", "proven: True"],
    "threshold_study": [
        "piles are proven both ways",
        "      0 mm",
        "the cell's own distance: 200 mm",
    ],
    "why_not": [" tool collision", "nearest fix: "],
}


def test_every_example_is_tried():
    assert {path.stem for path in FOLDER.glob("*.py")} == set(SAYS)


@pytest.mark.parametrize("name", SAYS)
def test_an_example_runs(name, tmp_path, monkeypatch, capsys):
    # Here, since importing takes longer than most of them; `make docs` runs them elsewhere.
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    said = capsys.readouterr().out
    for words in SAYS[name]:
        assert words in said
