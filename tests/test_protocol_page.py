"""What `docs/protocol.md` shows is what the code does: bytes, states, words, faults."""

import re
from pathlib import Path

import numpy as np
from shipped import shipped

from workbench.devices.abb_simulated.faults import FAULT_NAMES
from workbench.devices.abb_socket.frames import Frames, make_frame
from workbench.devices.abb_socket.messages import REQUEST, Commands, encode
from workbench.devices.abb_socket.sending import VERSION, arms_of
from workbench.devices.abb_socket.states import NEXT

PAGE = (Path(__file__).parents[1] / "docs" / "protocol.md").read_text(encoding="utf-8")
CELL = shipped("yumi")


def block(name: str) -> list[str]:
    found = re.search(rf"```text\n{re.escape(name)}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1].splitlines()


def test_the_older_protocol_is_as_shown():
    commands, asked = Commands(CELL), 0
    for line in block("abb-socket"):
        side, text = line.split(": ", 1)
        if side == "C":
            assert text.encode() == REQUEST
            asked += 1
            continue
        heard = commands.hear(text.encode())
        assert heard is not None and encode(CELL.arm(heard.arm), heard.kind, heard.q).text == text
    assert asked == 5 and commands.is_between


def test_the_first_bytes_of_the_older_protocol_are_as_shown():
    shown = [bytes.fromhex(line.split(": ", 1)[1]) for line in block("abb-socket bytes")]
    assert shown == [REQUEST, *(text[3:].encode() for text in block("abb-socket")[1:2])]


def test_frames_are_as_shown():
    shown = 0
    for line in block("abb-socket/2"):
        side, text = line.split(": ", 1)
        if text == "send":
            continue
        text, crc = text.split(" → ")
        data = make_frame(int(text[:4]), text[5:])
        assert data[75:].decode() == f"{crc}\n", f"{side}: {text} has {data[75:79].decode()}"
        shown += 1
    assert shown > 15
    (first,) = (line for line in block("abb-socket/2") if "hello" in line and line.startswith("W"))
    whole = "\n".join(block("bytes")) + "\n"
    assert whole.encode() == make_frame(1, f"hello {VERSION}")
    assert whole[75:79] == first.split(" → ")[1]
    list(Frames().hear(whole.encode()))


def test_the_conversation_has_every_word_of_the_table():
    words = set(re.findall(r"^- [CW]: `([a-z]+)", PAGE, re.MULTILINE))
    assert {word for _, word in NEXT} - {"wait"} <= words
    said = " ".join(block("abb-socket/2"))
    assert {word for word in words if word not in said} == {"no", "ping", "fault", "next"}
    assert f"{VERSION} {arms_of(CELL)}" in said


def test_the_states_are_as_shown():
    table = PAGE.partition("### States of the controller")[2].partition("\n### ")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line[:3] == "| `"]
    shown = [
        ((state, word), state if after == "the same" else after.strip("`"))
        for states, words, after in rows
        for state in re.findall(r"\w+", states)
        for word in re.findall(r"\w+", words)
    ]
    assert len(shown) == len(NEXT) and dict(shown) == dict(NEXT)


def test_every_fault_stands_there():
    shown = re.findall(r"`([a-z-]+)(?::n)?`", PAGE[PAGE.index("## Trying faults") :])
    assert set(FAULT_NAMES) <= set(shown)


def test_angles_have_two_decimals_and_the_order_of_the_controller():
    arm = CELL.arm("right")
    q = np.deg2rad([1.0, -20.0, 77.77, 30.5, 0.0, 5.0, -135.0])
    assert encode(arm, "in", q).text == "inR#*1.00*-20.00*30.50*0.00*5.00*-135.00*77.77*"
