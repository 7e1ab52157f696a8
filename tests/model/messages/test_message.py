"""Messages are values: equal by id and arguments, the same again from JSON, and English as text."""

import json
import pickle
from dataclasses import replace

import pytest

from workbench.app.records.forms import restore_value
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.digest import canonical, digest_of
from workbench.model.messages.catalogue import message_of
from workbench.model.messages.message import FoundPart, all_of, plain
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.states import StateText
from workbench.model.messages.verdicts import ReasonText, VerdictNote, VerdictText

PARTS = VerdictNote.ALL_TURNS(parts=map(FoundPart, (0, 3)))
BOTH = all_of((VerdictNote.SPARE(grasp="part-1"), PARTS))


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (VerdictNote.FINGERS(opening=0.0449), "finger opening 45 mm"),
        (VerdictNote.INEXACT(excess=0.00126), "closer than the accuracy of the bodies, 1.3 mm"),
        (VerdictNote.INCLINED(angle=0.5), "at some turn a finger meets a face inclined by 29 deg"),
        (VerdictNote.LINE_ENDS(share=0.256), "the arm can follow 26% of the line"),
        (VerdictNote.ONLY_ARMS(arms=("a",)), "only for arm a"),
        (VerdictNote.ONLY_ARMS(arms=("a", "b", "c")), "only for arm a, b or c"),
        (VerdictNote.NO_PLACE_FOR_PART(count=1, part="peg"), "1 place, none for peg"),
        (VerdictNote.NO_PLACE_FOR_PART(count=2, part="peg"), "2 places, none for peg"),
    ],
)
def test_units_lists_and_plurals_are_shown(message, text):
    assert str(message) == text


@pytest.mark.parametrize("message", [BOTH, plain("as it was said"), StateText.NO_PROOF()])
def test_a_message_comes_back_from_json_and_from_another_process(message):
    assert message_of(json.loads(json.dumps(canonical(message)))) == message
    assert pickle.loads(pickle.dumps(message)) == message
    assert hash(message) == hash(message_of(message.form))


def test_arguments_that_are_not_those_of_the_text_are_refused():
    with pytest.raises(TypeError, match=r"note\.fingers has the places \['opening'\]"):
        VerdictNote.FINGERS(far=0.1)


@pytest.mark.parametrize(
    "form",
    [
        {"id": "note.that-nobody-knows", "args": {"far": 0.1}},
        {"id": "note.fingers", "args": {"opening": "wide", "far": 1}},
        {"id": "note.fingers", "args": {"opening": "wide"}},
    ],
)
def test_a_message_of_another_version_reads_as_its_id_and_arguments(form):
    assert str(message_of(form)).startswith(form["id"])


def test_messages_within_messages_end_somewhere():
    form = "deep"
    for _ in range(50):
        form = {"id": "state.next-cycle", "args": {"message": form}}
    with pytest.raises(ValueError, match="too deep"):
        message_of(form)


def test_parts_get_other_numbers_and_names_that_look_alike_stay():
    told = BOTH.renumber(lambda index: index + 1)
    assert str(told) == (
        "spare grasp: part-1 works and has priority; part-2 and part-5 with the space of all "
        "turns: the scan shows no roll"
    )
    assert BOTH.mentions(VerdictNote.SPARE) and not BOTH.mentions(VerdictNote.TOO_DEEP)


def test_a_verdict_tells_a_violated_margin_from_a_collision():
    near = Verdict(Reason.IN_COLLISION, Stage.GRASP, ("palm", "part-2"), 0.001)
    assert near.message == VerdictText.APART(
        reason=ReasonText.WITHIN_MARGIN(), one="palm", other=FoundPart(1), far=0.001
    )
    assert (
        str(replace(near, distance=-0.002)) == "in collision: palm and part-2, penetration 2.0 mm"
    )


def test_a_verdict_on_record_with_a_text_is_read():
    form = canonical(Verdict(Reason.NO_PATH, Stage.ROUTE))
    again = restore_value(Verdict, {**form, "note": "at its end"}, read=lambda digest: b"")
    assert again.note == plain("at its end") and str(again) == "no path (at its end)"
    assert restore_value(Verdict, {**form, "note": ""}, read=lambda digest: b"").note is None


def test_a_text_without_an_id_keeps_the_digest_that_it_had():
    assert digest_of(plain("too close")) == digest_of("too close")
    assert digest_of(PlanNote.NO_OTHER_ARM()) != digest_of(str(PlanNote.NO_OTHER_ARM()))
