"""Everything that can come to the RAPID modules, scene after scene, until each statement ran.

A scene is a function of a `Stage`; the arms stand at home before it, and T_LINK listens.
"""

import contextlib
import socket
import struct
import time

import numpy as np
from rapid_load_scenes import (
    a_part_is_reckoned_with_from_the_grasp_to_the_release,
    loads_that_cannot_be_are_refused,
)
from rapid_old_scenes import (
    a_hand_that_fails_in_the_older_protocol,
    the_older_protocol,
    the_older_protocol_while_an_arm_moves,
)
from rapid_stage import FORTH, HOME, LONG, MID, NEAR, old, stars, step
from rapid_step_scenes import (
    each_step_waits_for_its_word,
    stop_silence_and_faults_while_a_step_waits,
    words_that_let_no_step_run,
)
from waiting import wait_until
from wires import TASKS, Talk


def parts_are_picked_and_lost(stage):
    stage.one.closes_at = lambda task: 15.0 if task == "T_ROB_R" else 0.0
    talk = stage.begin(
        *step(1, "R", "free", NEAR["R"], MID["R"], NEAR["R"], hand="open"),
        *step(1, "L", "free", HOME["L"], NEAR["L"], hand="open", zone=0.0),
        *step(2, "R", "sync", HOME["R"], NEAR["R"], hand="grip", opening=30.0),
        *step(2, "L", "sync", HOME["L"], NEAR["L"], hand="grip", opening=30.0),
        *step(3, "L", "alone", HOME["L"], hand="open", opening=40.0),
        *step(4, "R", "alone", HOME["R"], hand="open", opening=40.0),
    )
    assert talk.until("done").rest == "04"
    parts = sorted(frame.rest for frame in talk.others if frame.word == "part")
    assert parts == ["L missed closed to 0.0 mm where 30.0 mm were expected", "R picked"]
    talk.link.close()


def a_part_that_slips_is_narrower_before_it_is_let_go(stage):
    stage.one.closes_at = lambda task: 15.0
    talk = stage.begin(
        *step(1, "R", "alone", NEAR["R"], hand="grip", opening=30.0, ms=20000),
        *step(2, "R", "alone", HOME["R"], hand="open", opening=40.0),
    )
    hand = stage.one.moving["T_ROB_R"].hand
    wait_until(lambda: hand.position == 15.0)
    hand.position = 3.0
    assert talk.until("part").rest.startswith("R failed closed to 6.0 mm")
    talk.until("done")
    talk.link.close()


def refusals_of_words_and_numbers(stage):
    plan, ticket = f"plan {'a' * 64}", "ticket 00000000000000ff 001 001"
    starts = [f"start {arm} {where}" for arm, where in HOME.items()]
    leg, to = "leg 01 R reach 001 0.200 open 30.0 alone", f"to 001 {NEAR['R']} 00400"
    full = [plan, ticket, *starts]
    begun = [*full, leg]
    for says, *lines in [
        ("not in order when ready", "start R"),
        ("not in order when ready", "x" * 70),
        ("no digest", "plan abc"),
        ("no ticket, or a second", plan, "ticket 1 1"),
        ("no ticket, or a second", plan, ticket, ticket),
        ("no counts", plan, "ticket 00000000000000ff x 001"),
        ("no start of an arm", plan, ticket, "start Q " + HOME["R"]),
        ("a second start", plan, ticket, starts[0], starts[0]),
        ("no number", plan, ticket, starts[0].replace("40.00", "x")),
        ("a leg at the wrong place", plan, ticket, starts[0], leg),
        ("a leg without its numbers", *full, leg.replace("0.200", "x")),
        ("too many legs or points", *full, leg.replace("001 0.2", "999 0.2")),
        ("not the next step", *full, leg.replace("leg 01", "leg 02")),
        ("no such hand", *full, leg.replace("open", "shut")),
        ("no such mode", *full, leg.replace("alone", "slow")),
        ("a point without its leg", *full, to),
        ("a point without its numbers", *begun, to.replace("00400", "x")),
        ("not the next point", *begun, to.replace("001", "002")),
        ("the last leg is not whole", *begun, "end 001 FFFF"),
        ("no count", *begun, to, "end x FFFF"),
        ("points are missing", *begun, to, "end 009 FFFF"),
        ("an arm moves twice", *begun, to, leg.replace("alone", "free")),
    ]:
        assert says in stage.refused(*lines), (says, lines[-1])
    talk = Talk(stage.one.port)
    assert talk.say("hello abb-socket/3") == ("no", "0001 the version here is abb-socket/2")
    assert talk.closed()
    talk = stage.talk()
    assert "the check sum is" in talk.say("ping", crc=b"0000")[1]
    talk = stage.talk()
    assert "not the next number" in talk.say("ping", number=7)[1]
    talk = stage.talk()
    talk.link.sendall(b"abcd ping".ljust(79) + b"\n")
    assert talk.answer()[0] == "no"


def refusals_of_whole_programs(stage):
    for says, *steps in [
        ("no steps",),
        ("one arm alone", *step(1, "R", "free", NEAR["R"])),
        ("one arm alone", *step(1, "L", "sync", NEAR["L"])),
        ("modes differ", *step(1, "R", "free", NEAR["R"]), *step(1, "L", "sync", NEAR["L"])),
        ("sync legs differ in length", *step(1, "R", "sync", NEAR["R"], HOME["R"]),
         *step(1, "L", "sync", NEAR["L"])),
        ("sync legs differ in time", *step(1, "R", "sync", NEAR["R"], ms=300),
         *step(1, "L", "sync", NEAR["L"], ms=301)),
    ]:  # fmt: skip
        talk = stage.talk()
        (word, why), _ = stage.load(talk, *steps)
        assert word == "no" and says in why, (says, why)
        assert talk.closed()
    talk = stage.talk()
    (word, why), _ = stage.load(talk, *FORTH, counts=(7, 2))
    assert "legs are missing" in why
    talk = stage.talk()
    stage.load(talk)
    talk = stage.talk()
    lines = [f"plan {'a' * 64}", f"ticket {'b' * 16} 001 002"]
    lines += [f"start {arm} {HOME[arm]}" for arm in TASKS]
    for line in [*lines, *FORTH]:
        talk.say(line)
    assert "the sum of all differs" in talk.say("end 002 0000")[1]


def a_ticket_runs_once_and_from_its_start_alone(stage):
    for _ in range(17):
        talk = stage.begin(*step(1, "R", "alone", HOME["R"], ms=100))
        talk.until("done")
        talk.link.close()
    talk = stage.talk()
    stage.load(talk, *FORTH)
    assert "another ticket was loaded" in talk.say("run 0000000000000000")[1]
    stage.tickets -= 2
    talk = stage.talk()
    _, ticket = stage.load(talk, *FORTH)
    assert "this ticket was run before" in talk.say(f"run {ticket}")[1]
    stage.tickets += 5
    for axis in range(7):
        words = HOME["R"].split()
        words[axis] = f"{float(words[axis]) + 0.6:.2f}"
        talk = stage.talk()
        _, ticket = stage.load(talk, *FORTH, stands={**HOME, "R": " ".join(words)})
        assert "an arm is not at its start" in talk.say(f"run {ticket}")[1]
        assert talk.closed()


def a_stop_while_arms_stand_lets_them_move_again(stage):
    talk = stage.talk()
    assert talk.say("abort")[0] == "stopped"
    assert talk.closed()
    talk = stage.begin(*FORTH)
    talk.until("done")
    talk.link.close()


def a_stop_while_an_arm_moves(stage):
    talk = stage.begin(*LONG)
    wait_until(lambda: stage.one.shared["wb_at"][0][0] == 1)
    assert talk.say("abort")[0] == "stopped"
    where = stage.one.axes()["T_ROB_R"]
    assert talk.closed()
    stage.stopped()
    time.sleep(0.2)
    assert np.array_equal(stage.one.axes()["T_ROB_R"], where)
    assert not np.allclose(where, stage.one.mechanisms["T_ROB_R"].axes.home, atol=0.01)
    stage.operator.asked.clear()
    stage.restart()
    assert any("The right arm is not at home" in asked for asked in stage.operator.asked)
    assert np.allclose(stage.one.axes()["T_ROB_R"], stage.one.mechanisms["T_ROB_R"].axes.home)


def a_client_that_leaves_or_is_silent(stage):
    for leave in (True, False):
        talk = stage.begin(*LONG)
        wait_until(lambda: stage.one.shared["wb_at"][0][0] == 1)
        if leave:
            talk.link.close()
        else:
            stage.clock.let_pass(2.5)
            wait_until(lambda: "silent" in " ".join(stage.one.written))
            talk.link.close()
        stage.stopped()
        stage.restart()


def emergency_and_lost_pointers(stage):
    one = stage.one
    for act, says in [
        (one.emergency_stop, "emergency stop"),
        (lambda: one.lose_pointer("T_ROB_R"), "the program pointer of an arm is lost"),
        (lambda: one.lose_pointer("T_ROB_L"), "the program pointer of an arm is lost"),
    ]:
        talk = stage.begin(*LONG)
        wait_until(lambda: one.shared["wb_at"][0][0] == 1)
        one.do(act)
        assert talk.until("fault").rest == says
        talk.say("ping")
        assert talk.say("abort")[0] == "stopped"
        assert talk.closed()
        stage.restart()
    one.do(one.emergency_stop)
    talk = stage.talk()
    _, ticket = stage.load(talk, *FORTH)
    assert "emergency stop" in talk.say(f"run {ticket}")[1]
    assert talk.closed()
    stage.restart()


def an_arm_that_is_not_home_is_asked_for_and_keeps_the_rest_waiting(stage):
    talk = stage.begin(*step(1, "R", "alone", NEAR["R"]), *step(2, "L", "alone", NEAR["L"]))
    talk.until("done")
    talk.link.close()
    stage.operator.usual = 0
    stage.one.do(stage.one.start_anew)
    wait_until(lambda: stage.operator.asked[-1:] and "right" in stage.operator.asked[-1])
    talk = stage.talk()
    stands = {"R": NEAR["R"], "L": NEAR["L"]}
    _, ticket = stage.load(talk, *FORTH, stands=stands)
    assert "an arm is still on its way home" in talk.say(f"run {ticket}")[1]
    assert talk.closed()
    old(stage, "startR#", "inR#" + stars(HOME["R"]), ends=True)
    stage.operator.answers.append(5)
    wait_until(lambda: "left" in stage.operator.asked[-1])
    stage.operator.answers.append(1)
    stage.settle()
    assert np.allclose(stage.one.axes()["T_ROB_L"], stage.one.mechanisms["T_ROB_L"].axes.home)
    assert not np.allclose(stage.one.axes()["T_ROB_R"], stage.one.mechanisms["T_ROB_R"].axes.home)
    stage.operator.usual = 1
    stage.restart()


def a_hand_that_fails_and_an_arm_that_does_not_come(stage):
    one = stage.one
    one.moving["T_ROB_L"].hand.has_fault = True
    talk = stage.begin(
        *step(1, "R", "free", NEAR["R"]), *step(1, "L", "free", NEAR["L"], hand="open")
    )
    assert talk.until("fault").rest == "the program pointer of an arm is lost"
    assert "has a fault" in " ".join(one.written)
    stage.clock.let_pass(61)
    wait_until(lambda: any("the other arm does not come" in text for text in one.written))
    assert not one.tasks["T_ROB_R"].is_running
    talk.link.close()
    stage.stopped()
    one.do(one.tasks["T_ROB_R"].start)
    wait_until(lambda: one.tasks["T_ROB_R"].stopped_by == "nothing handles ERR_WAITSYNCTASK")
    stage.restart()


def an_arm_that_does_not_come_to_synchronise(stage):
    one = stage.one
    talk = stage.talk()
    _, ticket = stage.load(talk, *step(1, "R", "sync", NEAR["R"]), *step(1, "L", "sync", NEAR["L"]))
    one.do(lambda: one.shared["wb_leg_mode"][0][1].__setitem__(0, 1.0))  # alone, it is told now
    assert talk.say(f"run {ticket}")[0] == "ok"
    wait_until(lambda: one.shared["wb_at"][0][1] == 1)
    talk.link.close()
    stage.stopped()
    stage.clock.let_pass(61)
    wait_until(lambda: one.tasks["T_ROB_R"].stopped_by == "nothing handles ERR_SYNCMOVEON")
    stage.restart()


def a_report_while_an_arm_is_a_step_behind(stage):
    talk = stage.begin(*LONG)
    steps = stage.one.shared["wb_step"][0]
    wait_until(lambda: steps == [1.0, 1.0])
    stage.one.do(lambda: steps.__setitem__(0, 2.0))
    while talk.until("state").rest != "running 01 R00 L00":
        pass
    talk.link.close()
    stage.stopped()
    stage.restart()


def clients_that_leave_at_once(stage):
    """While they are greeted, and while they are looked at: one of these errors, or the other."""
    for _ in range(30):
        with socket.socket() as link, contextlib.suppress(OSError):
            link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            link.connect(("127.0.0.1", stage.one.port))
        talk = stage.talk()
        talk.link.close()
        if not unhandled(stage):
            break
    stage.settle()


def unhandled(stage):
    """How those of WbLink's error handlers begin that have not run."""
    texts = stage.lines("WbLink.mod")
    left = {key for key in stage.one.keys if key[0] == "WbLink.mod"} - stage.one.covered
    return {texts[line - 1].strip() for _, line, _ in left if texts[line - 2].strip() == "ERROR"}


def a_pointer_set_to_main_in_a_synchronised_step(stage):
    one = stage.one
    talk = stage.begin(
        *step(1, "R", "sync", NEAR["R"], HOME["R"], ms=20000),
        *step(1, "L", "sync", NEAR["L"], HOME["L"], ms=20000),
    )
    wait_until(lambda: one.shared["wb_at"][0] == [1.0, 1.0])
    assert one.mechanisms["T_ROB_R"].is_in_step
    talk.link.close()
    stage.stopped()
    stage.restart()
    assert not one.mechanisms["T_ROB_R"].is_in_step


def a_move_that_cannot_be_ends_the_step(stage):
    """In both modes: the error goes from the leg to the program, and the task stops."""
    one = stage.one
    for mode in ("free", "sync"):
        far = {arm: where.replace("-125.00", "60.00") for arm, where in NEAR.items()}
        talk = stage.begin(*step(1, "R", mode, far["R"]), *step(1, "L", mode, far["L"]))
        assert talk.until("fault").rest == "the program pointer of an arm is lost"
        assert "50027 Joint Out of Range" in one.tasks["T_ROB_R"].stopped_by
        talk.link.close()
        stage.stopped()
        stage.restart()


def an_order_of_no_kind_and_one_that_is_not_done(stage):
    one = stage.one

    def give():
        one.shared["wb_kind"][0] = 9.0
        one.shared["wb_order"][0] += 1.0

    one.do(give)
    wait_until(lambda: any("unknown kind of order" in text for text in one.written))
    stage.settle()
    talk = stage.talk()
    _, ticket = stage.load(talk, *FORTH)
    one.do(lambda: setattr(one.tasks["T_ROB_R"], "is_running", False))
    one.do(give)
    assert "the program pointer of an arm is lost" in talk.say(f"run {ticket}")[1]
    assert talk.closed()
    stage.stopped()
    stage.restart()


def an_address_that_cannot_be_had(stage):
    """Binding fails; T_LINK tries again and again, and serves once the address is there."""
    holder, at = stage.one.tasks["T_LINK"].loaded.globals["wb_port"].place
    port, holder[at] = holder[at], 70000.0
    Talk(stage.one.port).link.close()  # it begins anew after this client
    wait_until(lambda: "SocketClose server;" not in unhandled(stage))
    holder[at] = port
    stage.settle()


SCENES = (
    a_part_is_reckoned_with_from_the_grasp_to_the_release,
    loads_that_cannot_be_are_refused,
    parts_are_picked_and_lost,
    a_part_that_slips_is_narrower_before_it_is_let_go,
    refusals_of_words_and_numbers,
    refusals_of_whole_programs,
    a_ticket_runs_once_and_from_its_start_alone,
    a_stop_while_arms_stand_lets_them_move_again,
    a_stop_while_an_arm_moves,
    a_client_that_leaves_or_is_silent,
    emergency_and_lost_pointers,
    an_arm_that_is_not_home_is_asked_for_and_keeps_the_rest_waiting,
    a_hand_that_fails_and_an_arm_that_does_not_come,
    an_arm_that_does_not_come_to_synchronise,
    a_report_while_an_arm_is_a_step_behind,
    an_address_that_cannot_be_had,
    each_step_waits_for_its_word,
    words_that_let_no_step_run,
    stop_silence_and_faults_while_a_step_waits,
    clients_that_leave_at_once,
    a_pointer_set_to_main_in_a_synchronised_step,
    a_move_that_cannot_be_ends_the_step,
    an_order_of_no_kind_and_one_that_is_not_done,
    the_older_protocol,
    the_older_protocol_while_an_arm_moves,
    a_hand_that_fails_in_the_older_protocol,
)
