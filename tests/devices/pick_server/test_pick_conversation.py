"""The conversation without sockets: whatever fails on our side, each request has an answer."""

import pytest

from workbench.devices.pick_server.axes import axis_words
from workbench.devices.pick_server.conversation import VERSION, PickConversation
from workbench.devices.pick_server.lines import Form, line_bytes, words_of


class FailingDesk:
    def answer(self, request):
        raise RuntimeError("the disk is full")

    def phase(self):
        return "idle"

    def begin_anew(self):
        pass


@pytest.fixture
def hear(planned):
    talk = PickConversation(axis_words(planned[0], Form()), session=7)
    talk.desk = FailingDesk()

    def hear(*words):
        line = line_bytes(Form(), *words)
        return words_of(Form(), talk.hear("connection", line[:-1])[:-1])

    return hear


def test_a_job_that_fails_here_is_answered_once_and_the_next_one_too(hear):
    assert hear("0", "hello", VERSION, "1")[1] == "OK"
    assert hear("1", "scan") == ("1", "NO", "error")
    assert hear("1", "scan") == ("1", "NO", "error")
    assert hear("2", "state") == ("2", "OK", "idle")
