"""Lines of the pick server: the page's examples, every form, and what was damaged."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import workbench
from workbench.devices.pick_server.axes import axis_words
from workbench.devices.pick_server.lines import (
    ANSWERS,
    ENDS,
    JOBS,
    SEPARATORS,
    BadLine,
    Form,
    LineBuffer,
    answer_bytes,
    line_bytes,
    read_request,
    words_of,
)
from workbench.model.derived.controller_axes import from_controller
from workbench.model.errors import InputError
from workbench.model.robot import AxisMapping
from workbench.plugins.robot_link import controller_by, link_named

PAGE = Path(__file__).parents[3] / "docs" / "pick_server.md"

WORDS = st.lists(st.from_regex(r"[A-Za-z0-9_.-]{1,6}", fullmatch=True), max_size=8)


def talk():
    text = PAGE.read_text(encoding="utf-8")
    block = re.search(r"```text\npick-server\n(.*?)```", text, re.DOTALL)[1]
    return [line.split(": ", 1) for line in block.splitlines()]


def test_every_line_of_the_page_is_one_that_is_read_and_written():
    assert len(talk()) > 20
    for who, text in talk():
        words = words_of(Form(), text.encode())
        assert line_bytes(Form(), *words) == f"{text}\n".encode()
        if who == "R":
            assert read_request(Form(), text.encode()).job in JOBS
        else:
            assert words[1] in ANSWERS
            assert answer_bytes(Form(), int(words[0]), *words[1:]) == f"{text}\n".encode()


def test_the_page_lists_every_job_by_its_number():
    text = PAGE.read_text(encoding="utf-8")
    for number, job in enumerate(JOBS):
        assert re.search(rf"\| {number} \| `{job}[ `]", text), job
        if number:
            line = line_bytes(Form(), "7", str(number))
            assert read_request(Form(), line[:-1]).job == job


@given(words=WORDS, separator=st.sampled_from(tuple(SEPARATORS)), end=st.sampled_from(tuple(ENDS)))
def test_what_is_written_is_read_in_every_form(words, separator, end):
    form = Form(separator, end, 255)
    line = line_bytes(form, "12", "state", *words)
    taken = LineBuffer(form)
    pieces = [piece for k in range(len(line)) for piece in taken.split(line[k : k + 1])]
    request = read_request(form, pieces[0])
    assert (len(pieces), request.number, request.job) == (1, 12, "state")
    assert request.words == tuple(words)


@given(data=st.data())
def test_a_byte_that_is_lost_or_comes_twice_is_found(data):
    line = line_bytes(Form(), "12", "done", "3", "-12.50", "95.58", "0.00")[:-1]
    at = data.draw(st.integers(0, len(line) - 1))
    for spoiled in (line[:at] + line[at + 1 :], line[: at + 1] + line[at:]):
        with pytest.raises(BadLine):
            words_of(Form(), spoiled)


@pytest.mark.parametrize(
    ("line", "word"),
    [
        (b"1 scan", "check"),
        (b"\xff 1", "text"),
        (b"x" * 200, "long"),
        (line_bytes(Form(), "x", "scan")[:-1], "number"),
        (line_bytes(Form(), "12345", "scan")[:-1], "number"),
        (line_bytes(Form(), "1", "dance")[:-1], "job"),
        (line_bytes(Form(), "1", "19")[:-1], "job"),
        (line_bytes(Form(), "0", "scan")[:-1], "job"),
        (line_bytes(Form(), "1", "hello")[:-1], "job"),
        (line_bytes(Form(), "1")[:-1], "number"),
    ],
)
def test_a_line_that_means_nothing_is_refused_by_its_word(line, word):
    with pytest.raises(BadLine) as refused:
        read_request(Form(), line)
    assert refused.value.word == word


def test_answers_begin_with_numbers_where_a_controller_reads_no_words():
    assert answer_bytes(Form(is_coded=True), 5, "WAIT", "scan") == line_bytes(
        Form(), "5", "1", "scan"
    )


def mapped(coupling, offsets_deg):
    cell = workbench.read_cell("tx2_90")
    mapping = AxisMapping(np.array(coupling), np.deg2rad(offsets_deg))
    arm = replace(cell.arms[0], mapping=mapping)
    return replace(cell, arms=(arm,), controller=controller_by("pick-server"))


FANUC = np.eye(6) + np.outer(np.arange(6) == 2, -1.0 * (np.arange(6) == 1))


@pytest.fixture(scope="module")
def fanuc():
    return mapped(FANUC, [0, 90, -90, 0, 0, 180])


@given(steps=st.lists(st.integers(-9000, 9000), min_size=6, max_size=6))
def test_whole_steps_of_the_proof_stay_whole_in_the_controllers_numbers(fanuc, steps):
    cell = fanuc
    q = np.deg2rad(np.array(steps) / 100)
    axes = axis_words(cell, Form())
    words = axes.words(q)
    shown = np.array([float(word) for word in words])
    assert shown[2] == pytest.approx((steps[2] - steps[1]) / 100 - 90, abs=1e-9)
    assert shown[1] == pytest.approx(steps[1] / 100 + 90, abs=1e-9)
    assert np.abs(from_controller(cell.arms[0], np.deg2rad(shown)) - q).max() < 1e-9


@pytest.mark.parametrize(
    ("form", "fits"),
    [
        (Form(), True),
        (Form(unit="rad", digits=5, longest=128), True),
        (Form(unit="rad", digits=4, longest=128), False),
        (Form(longest=60), False),
        (Form(digits=6), False),
        (Form(digits=6, longest=128), True),
    ],
)
def test_a_form_that_does_not_hold_every_waypoint_is_refused(form, fits):
    options = {"unit": form.unit, "digits": form.digits, "longest": form.longest}
    cell = workbench.read_cell("tx2_90")
    # A home that shows what digits leave out.
    arm = replace(cell.arms[0], home=np.deg2rad([1.23, 0, 90, 0, 90, 0]))
    controller = controller_by("pick-server", options=options)
    cell = replace(cell, arms=(arm,), controller=controller)
    if fits:
        link_named("pick-server").check(cell)
        return
    with pytest.raises(InputError):
        link_named("pick-server").check(cell)


def test_offsets_between_the_steps_of_a_line_are_refused():
    with pytest.raises(InputError, match="digits"):
        link_named("pick-server").check(mapped(np.eye(6), [0, 0.005, 0, 0, 0, 0]))
