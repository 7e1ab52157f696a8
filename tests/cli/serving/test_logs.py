"""The log of a server as objects in files that are turned before they grow large."""

import json
import logging

import pytest

from workbench.cli.serving import logs
from workbench.cli.serving.logs import OLD_FILES, begin_log
from workbench.model.errors import FileError


@pytest.fixture(autouse=True)
def as_before():
    root = logging.getLogger()
    before = list(root.handlers)
    yield
    for handler in [one for one in root.handlers if one not in before]:
        root.removeHandler(handler)
        handler.close()


def test_each_record_is_one_object_whatever_is_in_it(tmp_path):
    begin_log(tmp_path / "log.jsonl")
    logging.getLogger("workbench.tested").warning("two\nlines, %s", 'a "quote" and ж')
    try:
        raise ValueError("broken")
    except ValueError:
        logging.getLogger("workbench.tested").exception("it failed")
    first, second = map(json.loads, (tmp_path / "log.jsonl").read_text().splitlines())
    assert first["message"] == 'two\nlines, a "quote" and ж'
    assert (first["level"], first["logger"]) == ("WARNING", "workbench.tested")
    assert first["at"] > 1e9
    assert "ValueError: broken" in second["traceback"]


def test_the_files_stay_small_and_few(tmp_path, monkeypatch):
    monkeypatch.setattr(logs, "LARGEST_LOG", 1000)
    begin_log(tmp_path / "log.jsonl")
    for number in range(200):
        logging.getLogger("workbench.tested").warning("line %d", number)
    files = list(tmp_path.iterdir())
    assert len(files) == OLD_FILES + 1
    assert all(file.stat().st_size <= 1000 for file in files)
    assert "line 199" in (tmp_path / "log.jsonl").read_text()


def test_a_file_that_cannot_be_written_is_told(tmp_path):
    with pytest.raises(FileError):
        begin_log(tmp_path / "nowhere" / "log.jsonl")
