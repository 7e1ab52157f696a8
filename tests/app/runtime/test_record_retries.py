"""What has ended is on record at last, however long the disk was full."""

import logging
import threading

import pytest

from workbench.app.core.people import WORKER
from workbench.app.runtime import record_retries
from workbench.app.runtime.record_retries import insist
from workbench.model.errors import CommandRefused, NotRecorded


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(record_retries, "RETRY", 0.01)


def test_what_is_out_of_order_is_tried_once(caplog):
    tried = []

    def do(command, actor):
        tried.append(command)
        raise CommandRefused("nothing is being sent")

    insist(do, "x", WORKER, giving_up=threading.Event(), show_problem=tried.append)
    assert tried == ["x"]
    assert [one.levelno for one in caplog.records] == [logging.ERROR]


def test_it_is_told_while_it_is_not_on_record_and_when_it_is(caplog):
    answers, told = [NotRecorded("full"), NotRecorded("full"), None], []

    def do(command, actor):
        if (answer := answers.pop(0)) is not None:
            raise answer

    insist(do, "x", WORKER, giving_up=threading.Event(), show_problem=told.append)
    assert [str(text or "") for text in told] == ["full", "full", ""]
    assert len(caplog.records) == 1
