"""What a controller must not report by abb-socket/2, before a program runs and while it does."""

import pytest
from abb_talk import as_begun

from workbench.model.errors import LinkError, ProtocolError


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ["state running 01 R00 L01"],
            "arm left goes to waypoint 1 in step 1; the plan moves right",
        ),
        (["state running 01 R99 L00"], "arm right goes to waypoint 99"),
        (["state running 01 R-1 L00"], "no report of a state"),
        (["state running 01 R1 L00"], "no report of a state"),
        (["state running 1e0 R01 L00"], "no report of a state"),
        (["state running 01 R01 R01"], "does not tell of every arm"),
        (["state running 03 R01 L00", "state running 02 R01 L00"], "step 2 after step 3"),
        (["state running 13 R00 L00"], "step 13 after step 0"),
        (["state ready 00 R00 L00"], "says it is ready, it should be running"),
        (["state running 01 R01"], "does not tell of every arm"),
        (["state running x R01 L00"], "no report of a state"),
        (["state resting 01 R01 L00"], "'resting' is no state"),
        (["at X 0.00"], "about no arm"),
        (["at R 0.00"], "1 numbers came for the 7 axes"),
        (["at R 1e308 0.00 0.00 0.00 0.00 0.00 0.00"], "1e308"),
        (["at R nan 0.00 0.00 0.00 0.00 0.00 0.00"], "nan"),
        (["at R 999.00 0.00 0.00 0.00 0.00 0.00 0.00"], "it goes from"),
        (["part R picked", "part R picked"], "comes twice"),
        (["part R perhaps"], "about no part"),
        (["done 12"], "0 of 2 parts reported"),
        (["part R picked", "part L picked", "done 11"], "done 11"),
        (["ok 0001 0000"], "acknowledged twice"),
        (["nonsense"], "means nothing"),
        (["fault emergency stop"], "reports a fault at step 0 of 12: emergency stop"),
    ],
)
def test_what_cannot_be_ends_the_sending(plan, talk, words, says):
    talk.go_on()
    with pytest.raises(LinkError, match=as_begun(plan, says)):
        for text in words:
            talk.tell(as_begun(plan, text))


@pytest.mark.parametrize(
    "words",
    [
        "part R picked",
        "done 12",
        "state running 00 R00 L00",
        "state waiting 01 R00 L00",
        "state loading 01 R00 L00",
        "state loading 00 R01 L00",
    ],
)
def test_nothing_moves_or_ends_before_run_was_sent(talk, words):
    talk.go_on("end")
    with pytest.raises(ProtocolError, match="before we sent run"):
        talk.tell(words)
