"""What a study leaves beside a cell comes back as it was; what is not such a file is refused."""

import json

import pytest

from workbench.formats.cells.predictions import (
    predictions_path,
    read_predictions,
    write_predictions,
)
from workbench.model.errors import FileError
from workbench.model.prediction import Forecast, Predictions

PREDICTIONS = Predictions(
    "abc",
    97,
    (
        Forecast(0.1, 0.8, 1.0, 0.2, 6.5, 1100.0),
        Forecast(0.3, 0.0, None, None, None, None),
    ),
)


def test_predictions_come_back_as_they_were(tmp_path):
    path = tmp_path / "threshold.json"
    write_predictions(path, PREDICTIONS)
    assert read_predictions(path) == PREDICTIONS


def test_no_study_is_no_error(tmp_path):
    assert read_predictions(tmp_path / "threshold.json") is None


def test_they_lie_beside_the_cell():
    assert predictions_path("yumi").parts[-2:] == ("yumi", "threshold.json")


def test_another_cell_of_the_same_folder_has_none_of_them():
    beside = predictions_path("robots/yumi/full_bin.toml")
    assert beside.parts[-2:] == ("yumi", "full_bin.threshold.json")
    assert read_predictions(beside) is None


def test_the_nearest_forecast_speaks_for_a_threshold():
    assert PREDICTIONS.near(0.15).threshold == 0.1
    assert PREDICTIONS.near(5.0).threshold == 0.3
    assert Predictions("abc", 0, ()).near(0.1) is None


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"piles": -1}, "piles"),
        ({"forecasts": [{"threshold": 0.1}]}, "coordinated: is missing"),
        ({"forecasts": 7}, "an array of tables is expected"),
        ({"more": 1}, "more"),
        ({"format": "workbench-threshold/9"}, "format"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_place(tmp_path, change, expected):
    path = tmp_path / "threshold.json"
    write_predictions(path, PREDICTIONS)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(FileError, match=expected):
        read_predictions(path)
