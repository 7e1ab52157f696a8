"""Scenes of plans that the RAPID modules run step by step, each step by a word."""

import numpy as np
from rapid_stage import FORTH, HOME, LONG, NEAR, step
from waiting import wait_until


def each_step_waits_for_its_word(stage):
    one = stage.one
    talk = stage.stepped(
        *step(1, "R", "alone", NEAR["R"], hand="open"),
        *step(2, "R", "sync", HOME["R"], NEAR["R"], hand="grip"),
        *step(2, "L", "sync", NEAR["L"], HOME["L"]),
        *step(3, "L", "alone", NEAR["L"]),
        *step(4, "R", "free", HOME["R"], hand="open"),
        *step(4, "L", "free", HOME["L"]),
    )
    for number in (1, 2, 3, 4):
        stands = {task: where.copy() for task, where in one.axes().items()}
        # Longer than arms wait for each other.
        for _ in range(40):
            talk.say("ping")
            stage.clock.let_pass(1.6)
        stage.waits(talk, number)
        assert all(np.array_equal(one.axes()[task], where) for task, where in stands.items())
        assert talk.say(f"next {number:02d}")[0] == "ok"
        if number < 4:
            stage.waits(talk, number + 1)
            assert not np.allclose(one.axes()["T_ROB_L"], stands["T_ROB_L"]) or number in (1, 2)
    assert talk.until("done").rest == "04"
    talk.link.close()
    stage.settle()


def words_that_let_no_step_run(stage):
    one = stage.one
    begun = [f"plan {'a' * 64}", "ticket 00000000000000ff 001 001"]
    assert "no manner" in stage.refused(begun[0], begun[1] + " slowly")
    assert "no ticket" in stage.refused(begun[0], begun[1] + " stepped now")
    for line, says in [
        ("next", "no number of a step"),
        ("next x1", "no number of a step"),
        ("next 1", "no number of a step"),
        ("next 02", "another step waits"),
        ("next 00", "another step waits"),
        ("run 00000000000000ff", "not in order when waiting"),
    ]:
        talk = stage.stepped(*FORTH)
        where = one.axes()["T_ROB_R"].copy()
        assert says in talk.say(line)[1], line
        assert talk.closed()
        stage.stopped()
        assert np.array_equal(one.axes()["T_ROB_R"], where)
        stage.restart()
    talk = stage.stepped(*LONG)
    assert talk.say("next 01")[0] == "ok"
    assert "not in order when running" in talk.say("next 01")[1]
    assert talk.closed()
    stage.stopped()
    stage.restart()


def stop_silence_and_faults_while_a_step_waits(stage):
    one = stage.one
    talk = stage.stepped(*FORTH)
    assert talk.say("abort")[0] == "stopped"
    assert talk.closed()
    stage.stopped()
    stage.restart()
    talk = stage.stepped(*FORTH)
    stage.clock.let_pass(2.5)
    # Who asks at once is heard, maybe, before the silence is noticed.
    wait_until(lambda: "silent" in " ".join(one.written[stage.seen :]))
    assert "silent" in talk.until("fault").rest
    talk.link.close()
    stage.stopped()
    stage.restart()
    talk = stage.stepped(*FORTH)
    one.do(one.emergency_stop)
    assert talk.until("fault").rest == "emergency stop"
    assert "not in order when fault" in talk.say("next 01")[1]
    assert talk.closed()
    stage.restart()
