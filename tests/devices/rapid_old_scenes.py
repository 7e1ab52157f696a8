"""Scenes in `abb-socket`; see `rapid_scenes`."""

import contextlib

from rapid_stage import HOME, NEAR, old, stars
from waiting import wait_until
from wires import SPEED


def the_older_protocol(stage):
    link = old(
        stage, "startR#", "inR#" + stars(NEAR["R"]), "outR#" + stars(HOME["R"]), "stopR#",
        "startL#", "outL#" + stars(NEAR["L"]), "outL#" + stars(HOME["L"]), "stopL#",
    )  # fmt: skip
    link.close()
    for messages in [
        ("outR#" + stars(HOME["R"]),),
        ("startR#", "inL#" + stars(HOME["L"])),
        ("startR#", "goR#" + stars(HOME["R"])),
        ("startR#", "inR#" + "*1.00" * 3 + "*****"),
        ("startR#", "x" * 90),
        ("#********",),
        ("startR#", "R#********"),
        ("startR#", "inR#" + stars(HOME["R"]).replace("40.00", "4x.00")),
    ]:
        old(stage, *messages, ends=True)
    old(stage, "startR#").close()
    stage.settle()


def the_older_protocol_while_an_arm_moves(stage):
    one = stage.one
    for act in ("leave", "speak", "emergency"):
        one._speed = 0.2
        link = old(stage, "startR#")
        link.sendall(("inR#" + stars(NEAR["R"])).encode())
        wait_until(lambda: not one.mechanisms["T_ROB_R"].is_standing)
        if act == "leave":
            link.close()
        elif act == "speak":
            link.sendall(b"s")
        else:
            one.do(one.emergency_stop)
        stage.stopped()
        one._speed = SPEED
        stage.restart()
        with contextlib.suppress(OSError):
            link.close()


def a_hand_that_fails_in_the_older_protocol(stage):
    one = stage.one
    one.moving["T_ROB_R"].hand.has_fault = True
    link = old(stage, "startR#", "inR#" + stars(NEAR["R"]), ends=True)
    link.close()
    stage.stopped()
    assert "ERR_HAND_FAILEDMOVEPOS" in one.tasks["T_ROB_R"].stopped_by
    stage.restart()
