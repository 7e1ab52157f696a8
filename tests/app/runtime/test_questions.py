"""Questions between jobs: the newest counts, none holds up a job, none stays for ever."""

from pathlib import Path

from job_listener import worker_of, workers
from waiting import PATIENCE, wait_until

from workbench.app.runtime.jobs import Jobs
from workbench.app.runtime.worker import Question
from workbench.model.errors import JobCancelled, WorkbenchError


def ask(jobs, listener, asker, name="echo", **arguments) -> None:
    """A question whose answer is told as if it were the end of a job with the asker's number."""
    jobs.ask(Question(asker, name, arguments, lambda answer: listener.ended(asker, answer)))


def test_of_many_questions_while_a_job_runs_the_newest_of_each_asker_is_answered(jobs, listener):
    jobs.start(1, "wait_politely", {})
    listener.progress.get(timeout=PATIENCE)
    for given in range(3000):
        ask(jobs, listener, 71, given=given)
    ask(jobs, listener, 72, given="other")
    ask(jobs, listener, 71, given="newest")
    jobs.cancel(1)
    assert listener.result()[0] == 1
    answers = [listener.result() for _ in range(2)]
    assert [(asker, answer["given"]) for asker, answer in answers] == [
        (71, "newest"),
        (72, "other"),
    ]
    assert worker_of(jobs, listener) == answers[0][1]["process"], "all in the one process"
    assert listener.results.empty()


def test_a_flood_of_questions_is_answered_in_its_order_up_to_the_last(jobs, listener):
    worker_of(jobs, listener)
    for given in range(5000):
        ask(jobs, listener, 71, given=given)
    seen = [listener.result()[1]["given"]]
    while seen[-1] != 4999:
        seen.append(listener.result()[1]["given"])
    assert seen == sorted(set(seen)) and len(seen) < 1000
    assert not jobs._questions


def test_a_job_goes_before_a_question_that_has_waited_longer(jobs, listener):
    jobs.start(1, "wait_politely", {})
    listener.progress.get(timeout=PATIENCE)
    ask(jobs, listener, 71, given="asked")
    jobs.start(2, "echo", {})
    jobs.cancel(1)
    assert [listener.result()[0] for _ in range(3)] == [1, 2, 71]


def test_a_question_without_end_is_ended_and_holds_up_no_job(jobs, listener, monkeypatch):
    worker_of(jobs, listener)
    monkeypatch.setattr("workbench.app.runtime.jobs.LONGEST_QUESTION", 3.0)
    ask(jobs, listener, 71, "wait_stubbornly")
    assert listener.progress.get(timeout=PATIENCE)[0] < 0, "it is the question that runs"
    jobs.start(1, "echo", {})
    asker, error = listener.result()
    assert asker == 71 and isinstance(error, JobCancelled)
    assert listener.result()[0] == 1


def test_what_goes_wrong_in_a_question_is_its_answer(jobs, listener):
    ask(jobs, listener, 71, "stumble")
    asker, error = listener.result()
    assert asker == 71 and "KeyError: 'missing'" in str(error)
    ask(jobs, listener, 71, "die")
    assert isinstance(listener.result()[1], WorkbenchError)
    assert worker_of(jobs, listener) in workers()


def test_a_question_without_a_worker_is_answered_so_and_starts_none(cell, listener, monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1])
    jobs = Jobs(cell, listener.ended, listener.progressed, module="broken_work")
    jobs.start(1, "echo", {})
    assert listener.result()[0] == 1
    wait_until(lambda: not workers())
    ask(jobs, listener, 71)
    asker, error = listener.result()
    assert asker == 71 and isinstance(error, WorkbenchError)
    assert not workers()
    jobs.close()
