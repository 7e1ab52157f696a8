"""abb-socket/2 as conversations, without sockets: our side and the controller's, word by word."""

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from abb_talk import Talk

from workbench.app.picking.pipeline import plan_pick
from workbench.devices.abb_simulated.serving import Serving
from workbench.devices.abb_socket.frames import (
    FIRST_CRC,
    LAST_NUMBER,
    TEXT,
    Frames,
    crc_of,
    make_frame,
)
from workbench.devices.abb_socket.messages import REQUEST
from workbench.devices.abb_socket.program import lines_of
from workbench.devices.abb_socket.sending import PING
from workbench.devices.abb_socket.states import NEXT
from workbench.model.errors import CommandRefused, LinkError, ProtocolError
from workbench.model.plan import Guarantee
from workbench.plugins.robot_link import USUAL


@pytest.fixture(scope="module")
def both(cell, plan):
    """The same parts, both arms at once."""
    return plan_pick(cell, plan.detections, "scan", strategy="coordinated", seed=0).plan


def finish(talk):
    for letter in "RL":
        talk.tell(f"part {letter} picked")
    talk.theirs.note("done")
    talk.tell(f"done {len(talk.program.steps):02d}")


@pytest.mark.parametrize("kind", ["plan", "both", "sync"])
def test_what_is_loaded_is_what_was_planned(cell, plan, both, approval, kind):
    chosen = plan if kind == "plan" else both
    if kind == "sync":
        # As `in_step` makes them: the same times on both legs of a step.
        pairs = [step.runs for step in both.sequence if len(step.runs) == 2]
        legs = {run: both.arm(run[0]).leg(run[1]) for runs in pairs for run in runs}
        same = {run: replace(legs[run], t=np.arange(len(legs[run].q)) * 1.0) for run in legs}
        arms = tuple(
            replace(one, legs=tuple(same.get((one.arm, leg.name), leg) for leg in one.legs))
            for one in both.arms
        )
        chosen = replace(both, arms=arms, guarantee=Guarantee.SYNCHRONISED)
    talk = Talk(cell, chosen, approval)
    talk.go_on()
    loaded = talk.theirs.program
    assert (loaded.digest, loaded.ticket) == (chosen.digest, approval.digest[:16])
    assert [tuple((leg.arm, leg.name) for leg in step.legs) for step in loaded.steps] == [
        step.runs for step in chosen.sequence
    ]
    modes = {step.mode for step in loaded.steps}
    expected = {"plan": {"alone"}, "both": {"alone", "free"}, "sync": {"alone", "sync", "free"}}
    assert modes <= expected[kind] and (kind == "plan" or len(modes) > 1)
    for leg in loaded.legs:
        wanted = chosen.arm(leg.arm).leg(leg.name)
        np.testing.assert_allclose(leg.q, wanted.q, atol=1e-9)
        np.testing.assert_allclose(np.cumsum(leg.seconds), wanted.t[1:], atol=0.01)
        assert leg.zone == cell.policy.zone
    hands = [leg.hand for leg in loaded.legs if leg.arm == "right"]
    assert hands == ["open", "keep", "grip", "keep", "keep", "open"]


def test_every_message_is_acknowledged_before_the_next(talk):
    talk.hear(REQUEST)
    first = talk.ours.say(0.0)
    assert first and not talk.ours.say(0.0)
    for _, answer in talk.theirs.hear(first):
        talk.tell(answer)
    assert talk.ours.say(0.0)
    (receipt,) = talk.receipts
    assert (receipt.kind, receipt.sent) == ("hello", "0001 hello abb-socket/2")
    assert receipt.heard == "0001 hello abb-socket/2 R7 L7"


def test_a_whole_cycle(cell, plan, talk):
    talk.go_on()
    talk.report(1, first=2)
    talk.report(7, second=2)
    finish(talk)
    assert talk.ours.is_over and talk.theirs.phase == "ready"
    parts = [receipt.part for receipt in talk.receipts if receipt.part]
    assert [(part.arm, part.is_picked) for part in parts] == [("right", True), ("left", True)]
    assert {part.detection for part in parts} == {one.detection for one in plan.arms}
    sent = [receipt.sent for receipt in talk.receipts if receipt.sent]
    assert len(sent) == len(set(sent)) == talk.receipts[-1].total
    assert all(receipt.heard for receipt in talk.receipts)


def test_what_comes_in_one_piece_with_the_end_does_not_count(talk):
    talk.go_on()
    talk.tell("part R picked")
    talk.tell("part L picked")
    end = talk.theirs.say("done 12") + talk.theirs.say("state ready 00 R00 L00")
    talk.hear(end)
    assert talk.ours.is_over and talk.receipts[-1].heard.endswith("done 12")


@pytest.mark.parametrize("result", ["failed", "missed"])
def test_a_part_that_was_lost_or_missed_is_reported_with_the_reason(talk, result):
    talk.go_on()
    talk.tell(f"part R {result} closed to 0.0 mm where 30.0 mm were expected")
    part = talk.receipts[-1].part
    assert (part.is_picked, part.why) == (False, "closed to 0.0 mm where 30.0 mm were expected")
    assert part.is_missed == (result == "missed")


def test_we_say_something_while_the_robot_moves_and_notice_silence(talk):
    talk.go_on()
    assert talk.ours.say(PING / 2) == b""
    assert b"ping" in talk.ours.say(PING * 1.1)
    talk.ours.check(PING + USUAL.silence / 2)
    with pytest.raises(LinkError, match=r"did not acknowledge '\d{4} ping' within 2\.0 s"):
        talk.ours.check(PING * 1.1 + USUAL.silence + 0.1)


def test_a_controller_that_repeats_itself_fills_no_journal(plan, talk):
    talk.go_on(until="plan")
    for number in range(2000):
        talk.tell(f"state {('ready', 'loading')[number % 2]} 00 R00 L00")
    talk.go_on()
    for number in range(2000):
        talk.report(1, first=number % 2)
    said = [one.heard for one in talk.receipts if " state " in one.heard]
    assert len(said) == 4


def test_silence_counts_from_the_last_word(talk):
    talk.at = 5.0
    talk.go_on()
    talk.at = 5.0 + USUAL.silence * 0.9
    talk.report(1, first=1)
    talk.ours.check(5.0 + USUAL.silence * 1.5)
    with pytest.raises(LinkError, match=r"was silent for 2\.0 s at step 1 of 12"):
        talk.ours.check(5.0 + USUAL.silence * 2)


def test_the_approval_is_asked_again_before_the_robot_moves(cell, plan, approval):
    def late():
        raise CommandRefused("the approval ran out 3 s ago")

    talk = Talk(cell, plan, approval, released=late)
    with pytest.raises(CommandRefused, match="ran out"):
        talk.go_on()
    assert talk.theirs.phase == "loaded"


def test_abort_is_answered_and_timed(talk):
    talk.go_on()
    ((_, answer),) = talk.theirs.hear(talk.ours.abort(1.0))
    assert (answer, talk.theirs.phase) == ("stopped", "stopped")
    talk.at = 1.25
    talk.report(1, first=1)
    talk.tell(answer)
    assert talk.ours.has_stopped
    assert str(talk.ours.status.stop) == "the controller acknowledged the stop after 250 ms"
    assert talk.receipts[-1].heard.endswith("stopped")


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        ("hello abb-socket/3 R7 L7", "speaks 'hello abb-socket/3 R7 L7', here it is abb-socket/2"),
        ("hello abb-socket/2 R6", "has the arms R6, cell yumi R7 L7"),
        ("ok 0001 FFFF", "speaks 'ok 0001 FFFF'"),
    ],
)
def test_the_handshake_is_about_version_and_arms(talk, answer, says):
    talk.hear(REQUEST)
    talk.ours.say(0.0)
    with pytest.raises(ProtocolError, match=says):
        talk.tell(answer)


def test_a_wrong_check_sum_in_an_acknowledgement_is_no_acknowledgement(talk):
    talk.go_on("hello")
    talk.ours.say(0.0)
    with pytest.raises(ProtocolError, match="answered '0002 plan"):
        talk.tell("ok 0002 0000")


def lines(talk):
    """All that loads the program, as texts; `end` with its check sum."""
    texts = [f"hello {'abb-socket/2'}"]
    texts += [f"{line.word} {line.rest}" for line in lines_of(talk.ours._cell, talk.program)]
    return texts


def load(serving, texts, *, is_ended=True):
    number, crc, points = 0, FIRST_CRC, 0
    for text in texts:
        number += 1
        data = make_frame(number, text)
        if not text.startswith("hello"):
            crc = crc_of(data[:TEXT].decode(), crc)
        points += text.startswith("to ")
        list(serving.hear(data))
    if is_ended:
        list(serving.hear(make_frame(number + 1, f"end {points:03d} {crc:04X}")))
    return number + 1


def without(texts, word):
    index = next(k for k, text in enumerate(texts) if text.startswith(word))
    return texts[:index] + texts[index + 1 :]


def changed(texts, old, new):
    index = next(k for k, text in enumerate(texts) if old in text)
    return [*texts[:index], texts[index].replace(old, new, 1), *texts[index + 1 :]]


def unloaded(texts):
    return [text for text in texts if not text.startswith(("load ", "axes "))]


def first_point(texts, spoil):
    """The first waypoint spoilt."""
    index = next(k for k, text in enumerate(texts) if text.startswith("to 001"))
    return [*texts[:index], spoil(texts[index]), *texts[index + 1 :]]


def points_in(texts):
    return sum(text.startswith("to ") for text in texts)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda t: without(t, "to 003"), "waypoint 4 came where 3"),
        (lambda t: without(t, "leg 02"), "waypoint 1 came where|is not a number"),
        (lambda t: without(unloaded(t), "start R"), "before the starts of all arms"),
        (lambda t: without(t, "start R"), "a load comes at the wrong place"),
        (lambda t: without(t, "load L"), "axes came without their load"),
        (lambda t: without(t, "axes L"), "a load comes at the wrong place"),
        (lambda t: without(t, "ticket"), "at the wrong place"),
        (lambda t: t[:-1], "has 8 waypoints of 9"),
        (lambda t: changed(t, "leg 02 ", "leg 03 "), "step 3 came after step 1"),
        (lambda t: [re.sub("leg 02 [RL]", "leg 02 X", one) for one in t], "no arm 'X'"),
        (lambda t: changed(t, " alone", " free"), "is free and has 1 legs"),
        (lambda t: changed(t, " open 40.0", " wave 40.0"), "'wave' is not one of"),
        (lambda t: changed(t, " open 40.0", " open 90.0"), "cannot be at 90.0 mm"),
        (lambda t: changed(t, "0.200", "0.700"), "0.700"),
        (
            lambda t: changed(t, f" {points_in(t):03d}", " 099"),
            r"\d\d waypoints on 12 legs came, 99 on 12 were told",
        ),
        (lambda t: changed(t, "plan ", "plan g"), "no digest"),
        (lambda t: first_point(t, lambda p: f"{p[:7]}199.00{p[p.index(' ', 8) :]}"), "outside"),
        (lambda t: first_point(t, lambda p: p[:-5] + "00001"), "cannot go to waypoint"),
        (lambda t: [*t[:3], "start R 0.00", *t[3:]], "1 numbers came"),
        (lambda t: ["hello abb-socket/9", *t[1:]], "is not abb-socket/2"),
    ],
)
def test_a_controller_loads_nothing_that_is_not_whole(talk, spoil, says):
    with pytest.raises(LinkError, match=says):
        load(talk.theirs, spoil(lines(talk)))
    assert talk.theirs.program is None


def test_a_controller_compares_the_sum_over_all(talk):
    texts = lines(talk)
    number = load(talk.theirs, texts, is_ended=False)
    with pytest.raises(ProtocolError, match="check sum of all"):
        list(talk.theirs.hear(make_frame(number, f"end {points_in(texts):03d} 0000")))


def test_a_ticket_is_run_once(cell, plan, approval):
    tickets = []
    first = Talk(cell, plan, approval, tickets=tickets)
    first.go_on()
    again = Talk(cell, plan, approval, tickets=tickets)
    with pytest.raises(LinkError, match="was run before"):
        again.go_on()
    assert again.theirs.phase == "loaded"


def test_an_arm_that_stands_elsewhere_is_not_moved(cell, plan, approval):
    talk = Talk(cell, plan, approval, away=np.deg2rad(0.6))
    with pytest.raises(LinkError, match=r"arm right is 0\.6 degrees from its start"):
        talk.go_on()


def test_what_is_not_in_the_table_is_refused(cell, talk):
    """Every state with every word, compared with the table."""
    words = {word for _, word in NEXT}
    phases = {phase for phase, _ in NEXT} | {"stopped"}
    for phase, word in itertools.product(sorted(phases), sorted(words)):
        one = Serving(cell, lambda: {}, [])
        one.phase = phase
        may = (phase, word) in NEXT and word not in ("done", "fault", "wait")
        try:
            list(one.hear(make_frame(1, word)))
        except LinkError as error:
            assert ("is not in order when" in str(error)) is not may, (phase, word)
        else:
            assert may, (phase, word)


def test_both_sides_go_on_after_the_last_number(talk):
    talk.go_on()
    talk.report(1, first=1)
    for _ in range(LAST_NUMBER):
        talk.tell("at R 0.00 -130.00 30.00 0.00 40.00 0.00 -135.00")
        talk.at += PING
        if data := talk.ours.say(talk.at):
            ((_, answer),) = talk.theirs.hear(data)
            talk.tell(answer)
    finish(talk)
    assert talk.ours.is_over


def test_garbage_ends_in_an_error_or_in_waiting(cell, plan, approval):
    rng = np.random.default_rng(0)
    for _ in range(200):
        frames = Frames()
        try:
            list(frames.hear(rng.bytes(int(rng.integers(1, 200)))))
        except ProtocolError:
            continue
