"""Frames of abb-socket/2: what they look like, and what is not one."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.devices.abb_socket.frames import LAST_NUMBER, SIZE, TEXT, Frames, crc_of, make_frame
from workbench.model.errors import InputError, ProtocolError

words = st.from_regex(r"[a-z]{1,9}( [!-~]{1,20}){0,2}", fullmatch=True)


def test_a_frame_is_eighty_characters_with_a_known_check_sum():
    assert crc_of("123456789") == 0x29B1  # the value that CRC-16/CCITT-FALSE is known by
    frame = make_frame(1, "hello abb-socket/2")
    assert len(frame) == SIZE and frame.endswith(b"\n")
    assert frame[:TEXT] == b"0001 hello abb-socket/2".ljust(TEXT)


@settings(max_examples=60, deadline=None)
@given(
    texts=st.lists(words, min_size=1, max_size=5), cuts=st.lists(st.integers(0, 400), max_size=9)
)
def test_frames_survive_however_they_are_split(texts, cuts):
    data = b"".join(make_frame(k, text) for k, text in enumerate(texts, start=1))
    ends = sorted({0, len(data), *(cut % (len(data) + 1) for cut in cuts)})
    frames = Frames()
    heard = [one for a, b in itertools.pairwise(ends) for one in frames.hear(data[a:b])]
    assert [f"{one.word} {one.rest}".strip() for one in heard] == texts
    assert [one.number for one in heard] == list(range(1, len(texts) + 1))


@settings(max_examples=100, deadline=None)
@given(at=st.integers(0, SIZE - 1), value=st.integers(0, 255))
def test_no_byte_can_be_another(at, value):
    data = bytearray(make_frame(1, "to 001 1.00 -2.00 3.00"))
    was, data[at] = data[at], value
    if value == was:
        return
    with pytest.raises(ProtocolError):
        list(Frames().hear(bytes(data)))


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (make_frame(2, "ping"), "frame 0002 came where 0001"),
        (make_frame(1, "ping") * 2, "frame 0001 came where 0002"),
        (b"send", "does not begin like a frame"),
        (b"0001\n", "does not begin like a frame"),
        (b"\xff\xfe", "does not begin like a frame"),
        (b"0001 ping" + b" " * 71, "is no frame"),
        (b"0001 PING".ljust(TEXT) + b"0000\n", "is no frame"),
        (b"0001 p\xffng".ljust(TEXT) + b"0000\n", "is not text"),
    ],
)
def test_what_is_no_frame_is_refused(data, says):
    with pytest.raises(ProtocolError, match=says):
        list(Frames().hear(data))


@pytest.mark.parametrize("text", ["x" * 71, "caf\u00e9", "a\nb"])
def test_what_does_not_fit_is_not_sent(text):
    with pytest.raises(InputError):
        make_frame(1, text)
    with pytest.raises(InputError):
        make_frame(10_000, "ping")
    with pytest.raises(InputError):
        make_frame(0, "ping")


def test_after_the_last_number_comes_the_first():
    """A robot that takes more than eleven minutes goes on reporting."""
    frames = Frames()
    for number in range(1, LAST_NUMBER + 1):
        (one,) = frames.hear(make_frame(number, "ping"))
    assert one.number == LAST_NUMBER
    (one,) = frames.hear(make_frame(1, "ping"))
    assert one.number == 1
