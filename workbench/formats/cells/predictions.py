"""Results of a study of the threshold, stored next to the cell of the study."""

from dataclasses import asdict
from pathlib import Path

from workbench.formats.cells.reading import cell_path
from workbench.formats.files.json_keys import json_text, read_json
from workbench.formats.files.toml_keys import Table
from workbench.formats.files.whole_files import write_whole
from workbench.model.prediction import Forecast, Predictions

FORMAT = "workbench-threshold/1"
FILE_NAME = "threshold.json"


def predictions_path(cell: str) -> Path:
    """Where the predictions for a cell, given as to `read_cell`, are kept.

    Raises:
        FileError: there is no such cell.
    """
    path = cell_path(cell)
    # A folder may hold several cells: each has a study of its own.
    return path.with_name(FILE_NAME if path.name == "cell.toml" else f"{path.stem}.{FILE_NAME}")


def read_predictions(path: Path) -> Predictions | None:
    """What a study has left there; None when there was none.

    Raises:
        FileError: the file cannot be read, or is not such a file.
    """
    if not path.exists():
        return None
    table = read_json(path, FORMAT)
    predictions = Predictions(
        table.text("cell_digest"),
        table.whole("piles", low=0, high=10**9),
        tuple(_forecast(row) for row in table.tables("forecasts")),
    )
    table.finish()
    return predictions


def write_predictions(path: Path, predictions: Predictions) -> None:
    """Leave what a study found.

    Raises:
        FileError: it cannot be written.
    """
    write_whole(path, json_text(path, {"format": FORMAT, **asdict(predictions)}))


def _forecast(row: Table) -> Forecast:
    def read_number(key: str, high: float) -> float | None:
        return None if row.is_null(key) else row.number(key, low=0, high=high)

    forecast = Forecast(
        row.number("threshold", low=0, high=10),
        read_number("coordinated", 1),
        read_number("success", 1),
        read_number("planning", 1e6),
        read_number("cycle", 1e6),
        read_number("parts_per_hour", 1e9),
    )
    row.finish()
    return forecast
