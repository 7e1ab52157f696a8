"""Jobs run in a process of their own, can be cancelled, and survive the death of that process."""

import logging
import multiprocessing
import os
import queue
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest
from job_listener import worker_of, workers
from waiting import PATIENCE, wait_until

from workbench.app.runtime.jobs import Jobs
from workbench.app.runtime.worker import Request, in_parts, pack_cell
from workbench.model.errors import FileError, JobCancelled, WorkbenchError

HERE = Path(__file__).parents[1]


def test_jobs_bring_their_results_in_order_from_one_warm_process(jobs, listener):
    for number in (1, 2, 3):
        jobs.start(number, "echo", {"given": number})
    results = [listener.result() for _ in range(3)]
    assert [(number, result["given"]) for number, result in results] == [(1, 1), (2, 2), (3, 3)]
    assert {result["cell"] for _, result in results} == {"sample"}
    (process,) = {result["process"] for _, result in results}
    assert process in workers()
    assert process != os.getpid()


def test_a_scan_goes_there_and_back_with_its_digest_and_stays_read_only(jobs, listener, samples):
    scan = samples.scan(points=5000)
    jobs.start(1, "give_back", {"scan": scan})
    _, back = listener.result()
    assert back.digest == scan.digest
    assert not back.points.flags.writeable
    assert not back.pixels.flags.writeable


def test_a_large_scan_is_not_copied_before_it_goes(samples):
    scan = samples.scan(points=50_000)
    head, *_ = parts = in_parts(Request(1, "give_back", {"scan": scan, "few": np.arange(3)}, b""))
    assert any(np.shares_memory(np.frombuffer(part, np.uint8), scan.points) for part in parts)
    assert sum(len(part) for part in parts) - scan.points.nbytes - scan.pixels.nbytes < 10_000
    assert len(head) == 4


def test_a_large_array_that_may_be_written_to_comes_back_so(jobs, listener):
    jobs.start(1, "give_back", {"scan": np.zeros(100_000)})
    _, back = listener.result()
    back[0] = 1.0


def test_progress_is_told_step_by_step(jobs, listener):
    jobs.start(1, "count", {})
    assert listener.result() == (1, 5)
    told = [listener.progress.get_nowait() for _ in range(5)]
    assert told == [(1, step / 4, f"step {step}") for step in range(5)]


def test_a_flood_of_reports_is_thinned(jobs, listener):
    jobs.start(1, "flood", {})
    assert listener.result() == (1, "done")
    assert 1 <= listener.progress.qsize() < 2000


def test_an_error_made_on_purpose_comes_back_as_it_is(jobs, listener):
    jobs.start(1, "refuse", {})
    _, error = listener.result()
    assert isinstance(error, FileError)
    assert str(error) == "scan.ply: is truncated"


@pytest.mark.parametrize(
    ("name", "said"), [("stumble", "KeyError: 'missing'"), ("bring_nonsense", "local object")]
)
def test_an_accident_becomes_one_sentence_and_a_traceback_in_the_log(
    jobs, listener, caplog, name, said
):
    with caplog.at_level(logging.ERROR):
        jobs.start(1, name, {})
        _, error = listener.result()
    assert type(error) is WorkbenchError
    assert str(error).startswith("internal error, see the log: ")
    assert said in str(error)
    assert "Traceback" in caplog.text


def test_a_result_that_cannot_be_unpacked_ends_its_job_and_the_next_one_runs(
    jobs, listener, caplog
):
    jobs.start(1, "bring_a_trap", {})
    number, error = listener.result()
    assert (number, type(error)) == (1, WorkbenchError)
    assert "the answer of the worker process cannot be read: ValueError" in str(error)
    assert worker_of(jobs, listener) in workers()


def test_a_worker_that_cannot_be_started_refuses_the_job(jobs, listener, monkeypatch):
    before = worker_of(jobs, listener)

    def refuse(process):
        raise BlockingIOError("no more processes")

    monkeypatch.setattr(multiprocessing.context.SpawnProcess, "start", refuse)
    jobs.start(1, "die", {})
    assert "exit code 7" in str(listener.result()[1])
    jobs.start(2, "echo", {})
    number, error = listener.result()
    assert (number, type(error)) == (2, WorkbenchError)
    assert "cannot be started: no more processes" in str(error)
    monkeypatch.undo()
    monkeypatch.syspath_prepend(HERE)
    assert worker_of(jobs, listener) != before


def test_an_unknown_job_is_refused_with_those_there_are(jobs, listener):
    jobs.start(1, "dance", {})
    assert "there is no task 'dance'; there are bring_a_trap, bring_nonsense" in str(
        listener.result()[1]
    )


def test_a_polite_job_ends_when_cancelled_and_its_process_lives_on(jobs, listener, monkeypatch):
    monkeypatch.setattr("workbench.app.runtime.jobs.GRACE", PATIENCE)
    before = worker_of(jobs, listener)
    jobs.start(1, "wait_politely", {})
    listener.progress.get(timeout=PATIENCE)
    jobs.cancel(1)
    number, error = listener.result()
    assert (number, str(error)) == (1, "noticed")
    assert isinstance(error, JobCancelled)
    assert worker_of(jobs, listener) == before


def test_a_stubborn_job_is_killed_when_cancelled_and_a_new_process_takes_over(jobs, listener):
    before = worker_of(jobs, listener)
    jobs.start(1, "wait_stubbornly", {})
    listener.progress.get(timeout=PATIENCE)
    jobs.start(2, "echo", {})
    jobs.cancel(1)
    number, error = listener.result()
    assert number == 1
    assert isinstance(error, JobCancelled)
    number, result = listener.result()
    assert number == 2
    assert result["process"] != before


def test_a_job_that_still_waits_is_cancelled_without_disturbing_the_running_one(jobs, listener):
    jobs.start(1, "wait_politely", {})
    jobs.start(2, "echo", {})
    listener.progress.get(timeout=PATIENCE)
    jobs.cancel(2)
    number, error = listener.result()
    assert number == 2
    assert isinstance(error, JobCancelled)
    assert listener.results.empty()
    jobs.cancel(1)
    assert listener.result()[0] == 1


def test_cancelling_what_has_ended_does_nothing(jobs, listener):
    before = worker_of(jobs, listener, 1)
    jobs.cancel(1)
    jobs.cancel(99)
    assert worker_of(jobs, listener, 2) == before


def test_a_worker_killed_in_a_job_is_reborn_and_the_job_ends_as_an_error(jobs, listener):
    before = worker_of(jobs, listener)
    jobs.start(1, "wait_stubbornly", {})
    listener.progress.get(timeout=PATIENCE)
    os.kill(before, signal.SIGKILL)
    number, error = listener.result()
    assert (number, type(error)) == (1, WorkbenchError)
    assert str(error) == "the worker process ended (SIGKILL) during the task wait_stubbornly"
    assert worker_of(jobs, listener) != before


def test_a_worker_killed_while_idle_is_reborn(jobs, listener):
    before = worker_of(jobs, listener)
    os.kill(before, signal.SIGKILL)
    deadline = time.monotonic() + PATIENCE
    while not set(workers()) - {before} and time.monotonic() < deadline:
        time.sleep(0.01)
    assert worker_of(jobs, listener) != before


def test_a_job_that_ends_its_process_is_told_with_the_exit_code(jobs, listener):
    jobs.start(1, "die", {})
    assert "ended (exit code 7) during the task die" in str(listener.result()[1])


def test_a_worker_that_cannot_start_refuses_jobs_with_the_reason(cell, listener, monkeypatch):
    monkeypatch.syspath_prepend(HERE)
    jobs = Jobs(cell, listener.ended, listener.progressed, module="broken_work")
    for number in (1, 2):
        jobs.start(number, "echo", {})
        ended, error = listener.result()
        assert ended == number
        assert str(error) == "the worker process cannot start: RuntimeError: a library is missing"
    jobs.close()


def test_a_first_worker_that_cannot_be_made_leaves_jobs_to_the_next(cell, listener, monkeypatch):
    monkeypatch.syspath_prepend(HERE)
    start, tries = multiprocessing.context.SpawnProcess.start, []

    def fail_once(process):
        tries.append(process)
        if len(tries) == 1:
            raise RuntimeError("can't start new thread")
        start(process)

    monkeypatch.setattr(multiprocessing.context.SpawnProcess, "start", fail_once)
    jobs = Jobs(cell, listener.ended, listener.progressed, module="tiny_work")
    wait_until(lambda: tries)
    # The first job ends with the error, if it waits already; the next one has a worker.
    jobs.start(1, "echo", {})
    listener.result()
    worker_of(jobs, listener)
    jobs.close()


def test_a_listener_that_fails_is_logged_and_the_next_job_runs(cell, monkeypatch, caplog):
    monkeypatch.syspath_prepend(HERE)
    results = queue.Queue()

    def ended(number, result):
        results.put(number)
        raise ValueError("a broken page")

    jobs = Jobs(cell, ended, lambda *what: None, module="tiny_work")
    for number in (1, 2):
        jobs.start(number, "echo", {})
        assert results.get(timeout=PATIENCE) == number
    jobs.close()
    assert "a broken page" in caplog.text


def test_nothing_is_told_after_close_even_from_a_running_job(cell, listener, monkeypatch):
    monkeypatch.syspath_prepend(HERE)
    jobs = Jobs(cell, listener.ended, listener.progressed, module="tiny_work")
    jobs.start(1, "wait_stubbornly", {})
    listener.progress.get(timeout=PATIENCE)
    jobs.close()
    assert listener.results.empty()
    assert not workers()


def test_the_worker_ends_when_its_parent_is_killed(cell, tmp_path):
    # A parent of its own, killed without a chance to clean up, while the worker is busy.
    (tmp_path / "cell").write_bytes(pack_cell(cell))
    program = textwrap.dedent(
        f"""
        import pickle, sys, threading
        from pathlib import Path
        from workbench.app.runtime.jobs import Jobs

        if __name__ == "__main__":
            sys.path.insert(0, {str(HERE)!r})
            cell = pickle.loads(Path({str(tmp_path / "cell")!r}).read_bytes())
            told = lambda number, result: print("warm", flush=True)
            jobs = Jobs(cell, told, lambda *what: None, module="tiny_work")
            jobs.start(1, "echo", {{}})
            jobs.start(2, "wait_stubbornly", {{}})
            threading.Event().wait()
        """
    )
    (tmp_path / "parent.py").write_text(program)
    environment = os.environ | {"PYTHONPATH": str(HERE.parents[1])}
    parent = subprocess.Popen(
        [sys.executable, str(tmp_path / "parent.py")],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    )
    assert parent.stdout is not None
    assert parent.stdout.readline() == "warm\n"
    parent.kill()
    # The worker holds the pipe too: its end is the end of whatever can still write to it.
    rest, _ = parent.communicate(timeout=PATIENCE)
    assert (rest, parent.returncode) == ("", -signal.SIGKILL)


def test_a_task_that_cannot_be_handed_over_ends_and_the_next_one_runs(jobs, listener):
    jobs.start(1, "echo", {"given": lambda: "functions made here cannot leave the process"})
    number, error = listener.result()
    assert number == 1 and isinstance(error, WorkbenchError)
    assert str(error).startswith("internal error, see the log")
    jobs.start(2, "echo", {"given": 2})
    number, result = listener.result()
    assert (number, result["given"]) == (2, 2)


def test_a_worker_that_is_ended_by_a_signal_without_a_name_is_replaced(jobs, listener):
    process = worker_of(jobs, listener)
    jobs.start(1, "wait_politely", {})
    listener.progress.get(timeout=PATIENCE)
    os.kill(process, signal.SIGRTMIN + 5)
    number, error = listener.result()
    assert number == 1 and f"(signal {signal.SIGRTMIN + 5})" in str(error)
    assert worker_of(jobs, listener) != process


def test_a_worker_that_cannot_be_made_for_whatever_reason_refuses_what_waits(
    jobs, listener, monkeypatch
):
    process = worker_of(jobs, listener)

    def fail():
        raise RuntimeError("can't start new thread")

    make = jobs._make_worker
    monkeypatch.setattr(jobs, "_make_worker", fail)
    os.kill(process, signal.SIGKILL)
    wait_until(lambda: not workers())
    jobs.start(1, "echo", {})
    number, error = listener.result()
    assert number == 1 and "can't start new thread" in str(error)
    monkeypatch.setattr(jobs, "_make_worker", make)
    worker_of(jobs, listener, 2)
