"""Scenes with loads: told before a program, and what the arms reckon with while it runs."""

from rapid_stage import HOME, NEAR, step
from waiting import wait_until

TOOL = [
    "load R tool 0.230 8.2 11.7 52.0",
    "axes R tool 1.0000 0.0000 0.0000 0.0000 0.00021 0.00024 0.00009",
]
PART = [
    "load R part 0.134 0.0 -1.5 141.0",
    "axes R part 0.7071 0.7071 0.0000 0.0000 0.00004 0.00004 0.00001",
]
NOTHING = 0.001


def a_part_is_reckoned_with_from_the_grasp_to_the_release(stage):
    arm = stage.one.mechanisms["T_ROB_R"]
    talk = stage.begin(
        *TOOL,
        *PART,
        *step(1, "R", "alone", NEAR["R"], hand="open"),
        *step(2, "R", "alone", HOME["R"], hand="grip", opening=30.0, ms=20000),
        *step(3, "R", "alone", NEAR["R"], hand="open", opening=40.0),
        *step(4, "R", "alone", HOME["R"], hand="keep", opening=40.0),
    )
    wait_until(lambda: arm.payload[0] > 2 * NOTHING)
    assert round(arm.payload[0], 4) == 0.134
    assert [round(value, 2) for value in arm.payload[1]] == [0.0, -1.5, 141.0]
    assert round(arm.payload[2][1], 4) == 0.7071
    assert [round(value, 5) for value in arm.payload[3:]] == [0.00004, 0.00004, 0.00001]
    talk.until("done")
    assert arm.payload[0] < 2 * NOTHING
    assert round(arm.tool_load[0], 3) == 0.23
    assert [round(value, 2) for value in arm.tool_load[1]] == [8.2, 11.7, 52.0]
    talk.link.close()


def loads_that_cannot_be_are_refused(stage):
    begins = [f"plan {'a' * 64}", "ticket 00000000000000fe 001 001"]
    starts = [f"start {arm} {where}" for arm, where in HOME.items()]
    leg = "leg 01 R reach 001 0.200 open 30.0 alone"
    bad = (
        (TOOL[:1], "a load at the wrong place", begins),
        (["load R tool 0.230 8.2 11.7"], "a load at the wrong place", None),
        (["load X tool 0.230 8.2 11.7 52.0"], "a load at the wrong place", None),
        (["load R hand 0.230 8.2 11.7 52.0"], "a load at the wrong place", None),
        ([TOOL[0], TOOL[0]], "a load at the wrong place", None),
        ([*TOOL, TOOL[0]], "a second load", None),
        (["load R tool x 8.2 11.7 52.0"], "no number", None),
        (["load R tool 0.000 8.2 11.7 52.0"], "a load without mass or centre", None),
        (["load R tool 0.230 0.0 0.0 0.0"], "a load without mass or centre", None),
        (TOOL[1:], "axes without their load", None),
        ([TOOL[0], PART[1]], "axes without their load", None),
        ([TOOL[0], TOOL[1].replace("0.00009", "x")], "no number", None),
        ([TOOL[0], TOOL[1].replace("1.0000", "0.5000")], "no orientation", None),
        ([TOOL[0], TOOL[1].replace("0.00009", "-0.00009")], "an inertia below 0", None),
        ([TOOL[0], leg], "a leg at the wrong place", None),
    )
    for lines, why, first in bad:
        assert stage.refused(*(first or [*begins, *starts]), *lines) == why, lines
