"""Files read by a process of its own, which may do what it likes."""

import os
import stat
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from waiting import PATIENCE, wait_until

from workbench.formats.files import reader_process as module
from workbench.formats.files.reader_process import Answer, apart
from workbench.formats.files.whole_files import MB
from workbench.model.errors import FileError, InputError, JobCancelled

# What the processes do.


def measures(path, factor):
    values = np.arange(3) * factor
    return Answer({"pid": os.getpid(), "size": path.stat().st_size}, {"values": values})


def refuses(path, kind):
    if kind == "file":
        raise FileError(path, "is no drawing")
    if kind == "other":
        raise FileError("part.toml", "is missing")
    if kind == "bug":
        raise ZeroDivisionError("ours")
    raise InputError("nobody wants it")


def eats(path):
    return Answer(len(bytearray(4096 * MB)))


def spins(path):
    while True:
        pass


def sleeps(path):
    path.with_name("began.partial").write_text(str(os.getpid()))
    path.with_name("began.partial").rename(path.with_name("began"))
    time.sleep(600)


@pytest.fixture
def file(tmp_path):
    file = tmp_path / "a.stl"
    file.write_bytes(b"12345")
    return file


def is_gone(pid):
    status = Path(f"/proc/{pid}/status")
    return not status.exists() or "State:\tZ" in status.read_text()


def test_another_process_answers_with_what_json_holds_and_arrays(file):
    answer = apart(file, measures, 2)
    assert answer.value["size"] == 5
    assert answer.value["pid"] != os.getpid()
    np.testing.assert_array_equal(answer.arrays["values"], [0, 2, 4])


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("file", r"a\.stl: is no drawing$"),
        ("other", r"^part\.toml: is missing$"),
        ("input", "^nobody wants it$"),
    ],
)
def test_what_is_wrong_is_told_as_if_it_were_read_here(file, kind, said):
    with pytest.raises(InputError, match=said):
        apart(file, refuses, kind)


def test_a_slip_of_ours_is_in_the_log_and_not_before_people(file, caplog):
    with pytest.raises(FileError, match="internal error, see the log") as refused:
        apart(file, refuses, "bug")
    assert "Traceback" not in str(refused.value)
    assert "ZeroDivisionError: ours" in caplog.text


def test_who_wants_too_much_memory_is_told_how_much_there_is(file):
    with pytest.raises(FileError, match="cannot be read with 2048 MB of memory"):
        apart(file, eats, most_memory=2048 * MB)


def test_who_computes_for_too_long_is_ended(file, monkeypatch):
    monkeypatch.setattr(module, "WAITS", PATIENCE)
    with pytest.raises(FileError, match=r"within 1\.0 s"):
        apart(file, spins, longest=1)


@pytest.mark.parametrize(
    ("does", "said"),
    [
        ("kill -SEGV $$", r"made its reader end \(code -11\)"),
        ("exec sleep 600", r"could not be read within 1\.0 s"),
        ("exit 0", r"made its reader end \(code 0\)"),
        ("echo '[]' > told.json", r"made its reader end \(code 0\)"),
    ],
)
def test_a_reader_that_crashes_or_hangs_takes_nothing_along(
    does, said, file, tmp_path, monkeypatch
):
    script = tmp_path / "reader"
    script.write_text(f"#!/bin/sh\n{does}\n")
    script.chmod(script.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(module.sys, "executable", str(script))
    with pytest.raises(FileError, match=said):
        apart(file, measures, 1, longest=1 / module.WAITS)


def test_who_wants_it_no_more_ends_the_process(file):
    began = file.with_name("began")
    with pytest.raises(JobCancelled):
        apart(file, sleeps, cancelled=began.is_file)
    assert is_gone(began.read_text())


def test_few_run_at_a_time_and_who_waits_can_give_up(file, monkeypatch):
    monkeypatch.setattr(module, "_places", threading.BoundedSemaphore(1))
    is_over = threading.Event()

    def first():
        with pytest.raises(JobCancelled):
            apart(file, sleeps, cancelled=is_over.is_set)

    thread = threading.Thread(target=first)
    thread.start()
    try:
        wait_until(file.with_name("began").is_file)
        asked = iter([False, False, True])
        with pytest.raises(JobCancelled):
            apart(file, measures, 1, cancelled=lambda: next(asked))
    finally:
        is_over.set()
        thread.join()
    assert apart(file, measures, 1).value["size"] == 5
