"""Tasks that share persistents, wait for each other, and are interrupted."""

import pytest
from rapid_bench import Tasks, module, written

SHARED = 'MODULE s\nPERS num order:=0;\nPERS tasks both{2}:=[["A"],["B"]];\nENDMODULE'


def pair(a, b, rest="", **how):
    texts = {"A": [SHARED, module(a, rest)], "B": [SHARED, module(b, rest)]}
    return Tasks(texts, **how).start()


def test_persistents_of_one_name_are_one_and_variables_are_not():
    one = pair(
        "order:=5; own:=5;",
        'WaitUntil order=5\\PollRate:=0.02; TPWrite "order"\\Num:=order; TPWrite "own"\\Num:=own;',
        "VAR num own:=1;",
    ).run()
    assert one.written == ["order5", "own1"]


def test_tasks_take_turns_also_when_one_never_waits():
    one = pair('WHILE order=0 DO\nENDWHILE\nTPWrite "seen";', "order:=1;").run()
    assert one.written == ["seen"]


def test_tasks_meet_at_a_name_and_go_on_together():
    rest = "VAR syncident here;\nVAR syncident there;"
    one = pair(
        'WaitTime 3; TPWrite "A came"; WaitSyncTask here,both; WaitSyncTask there,both;'
        'TPWrite "A went";',
        'WaitSyncTask here,both; WaitTime 2; TPWrite "B works"; WaitSyncTask there,both;',
        rest,
    ).run()
    assert one.written == ["A came", "B works", "A went"]
    assert one.now == pytest.approx(5, abs=0.1)


def test_who_is_waited_for_in_vain_is_an_error_and_has_not_been_met():
    rest = """VAR syncident here;
        PROC meet(num seconds)
            WaitSyncTask here,both\\TimeOut:=seconds;
            TPWrite "met";
        ERROR
            IF ERRNO=ERR_WAITSYNCTASK TPWrite "alone";
            RETURN;
        ENDPROC"""
    one = pair("meet 1; WaitTime 5; meet 100;", "WaitTime 3; meet 100;", rest).run()
    assert one.written == ["alone", "met", "met"]
    assert one.now == pytest.approx(6, abs=0.1)


def test_a_pointer_that_is_taken_out_runs_undo_and_leaves_nobody_waiting():
    rest = """VAR syncident here;
        PROC inner()
            WaitSyncTask here,both;
        UNDO
            TPWrite "inner undone";
        ENDPROC
        PROC outer()
            inner;
        ERROR
            TPWrite "no error";
        UNDO
            TPWrite "outer undone";
        ENDPROC"""
    one = pair('outer; TPWrite "A went";', 'WaitTime 10; inner; TPWrite "B went";', rest).run(5)
    one.tasks["A"].take_pointer()
    assert one.written == ["inner undone", "outer undone"]
    one.run(10)
    assert one.written == ["inner undone", "outer undone"], "B met somebody who is gone"
    one.tasks["A"].start()
    one.run()
    assert sorted(one.written[2:]) == ["A went", "B went"]


def test_stop_waits_for_start_and_goes_on():
    one = Tasks({"T": [module('TPWrite "a"; Stop; TPWrite "b";')]}).start().run()
    assert one.written == ["a"] and not one.tasks["T"].is_running
    one.tasks["T"].start()
    assert one.run().written == ["a", "b"]


def test_timers_interrupt_what_waits_and_once_is_once():
    rest = """VAR intnum often;
        VAR intnum once;
        VAR num n:=0;
        TRAP tick
            n:=n+1;
        ENDTRAP
        TRAP ring
            TPWrite "ring"\\Num:=n;
        ENDTRAP"""
    body = """CONNECT often WITH tick;
        ITimer 0.5,often;
        CONNECT once WITH ring;
        ITimer\\Single,1.2,once;
        WaitTime 3.2;
        TPWrite "ticks"\\Num:=n;
        ISleep often;
        WaitTime 2;
        IWatch often;
        IDisable;
        WaitTime 1.1;
        TPWrite "kept"\\Num:=n;
        IEnable;
        WaitTime 0.01;
        IDelete often;
        WaitTime 2;
        TPWrite "last"\\Num:=n;"""
    assert written(body, rest) == ["ring2", "ticks6", "kept6", "last7"]


def test_outputs_interrupt_and_are_waited_for():
    rest = """VAR intnum up;
        TRAP seen
            TPWrite "up";
        ENDTRAP"""
    body = """CONNECT up WITH seen;
        ISignalDO doLamp,1,up;
        SetDO doLamp,1;
        WaitTime 0.1;
        Reset doLamp;
        WaitTime 0.1;
        Set doLamp;
        WaitDO doLamp,1;
        TPWrite "lamp"\\Num:=DOutput(doLamp);"""
    assert written(body, rest, signals=["doLamp"]) == ["up", "up", "lamp1"]


def test_waiting_has_an_end_when_it_is_asked_for():
    rest = """VAR bool late;
        PROC wait()
            WaitUntil FALSE\\MaxTime:=2;
        ERROR
            IF ERRNO=ERR_WAIT_MAXTIME TRYNEXT;
        ENDPROC"""
    body = """WaitUntil FALSE\\MaxTime:=1\\TimeFlag:=late;
        IF late TPWrite "late";
        wait;
        ClkReset c; ClkStart c; WaitTime 0.25; ClkStop c; WaitTime 1;
        TPWrite NumToStr(ClkRead(c),2);"""
    assert written(body, rest + "\nVAR clock c;") == ["late", "0.25"]


def test_the_operator_answers_when_he_does():
    rest = """VAR num key;
        PROC ask()
            TPReadFK key,"Go?","Yes",stEmpty,stEmpty,stEmpty,"No"\\MaxTime:=5;
        ERROR
            IF ERRNO=ERR_TP_MAXTIME TPWrite "nobody";
            RETURN;
        ENDPROC"""
    body = 'ask; TPWrite "key"\\Num:=key; ask;'
    assert written(body, rest, answers=[5]) == ["key5", "nobody"]
    said = written(body, rest, answers=[2])
    assert said == ["TPReadFK: key 2 has no text"]


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("ITimer 1,x;", "nothing handles ERR_UNKINO"),
        ("CONNECT x WITH t; CONNECT x WITH t;", "nothing handles ERR_ALRDYCNT"),
        ("CONNECT x WITH t; ITimer 0.05,x;", "ITimer: 0.05 s is too short"),
        ("WaitTime\\InPos,1;", "\\InPos is for tasks that move a robot"),
        ("SyncMoveOff here;", "SyncMoveOff: movements are not synchronised"),
        ("WaitSyncTask here,whom;", "the tasks A, B cannot meet from T"),
    ],
)
def test_what_makes_no_sense_stops_the_task(body, says):
    rest = """VAR intnum x;
        VAR syncident here;
        PERS tasks whom{2}:=[["A"],["B"]];
        TRAP t
        ENDTRAP"""
    assert written(body, rest) == [says]


def test_undo_handlers_that_fail_or_never_end_are_left():
    rest = """VAR num zero:=0;
        PROC inner()
            WaitTime 100;
        UNDO
            zero:=1/zero;
            TPWrite "never";
        ENDPROC
        PROC middle()
            inner;
        UNDO
            WHILE TRUE DO
            ENDWHILE
        ENDPROC
        PROC outer()
            middle;
        UNDO
            TPWrite "undone";
            WaitUntil FALSE;
        ENDPROC"""
    one = Tasks({"T": [module("outer;", rest)]}).start().run(1)
    one.tasks["T"].take_pointer()
    assert one.written == ["undone"] and not one.tasks["T"].is_alive
    one.start().run(1)
    assert one.tasks["T"].is_running
    one.end()


def test_an_error_of_a_trap_stops_the_task_and_is_not_the_interrupted_routines():
    rest = """VAR intnum once;
        VAR num zero:=0;
        TRAP fails
            zero:=1/zero;
            TPWrite "trapped";
        ENDTRAP
        PROC waits()
            WaitTime 3;
        ENDPROC
        PROC calls()
            CONNECT once WITH fails;
            ITimer\\Single,1,once;
            waits;
            TPWrite "waited";
        ERROR
            TPWrite "taken";
            RETURN;
        ENDPROC"""
    one = Tasks({"T": [module("calls;", rest)]}).start().run(10)
    assert one.tasks["T"].stopped_by == "nothing handles ERR_DIVZERO"
    holder, at = one.tasks["T"].loaded.globals["zero"].place
    holder[at] = 1.0
    one.tasks["T"].start()
    assert one.run().written == ["trapped", "waited"]


def test_an_interrupt_that_is_deleted_leaves_nothing_to_the_next_of_its_number():
    rest = """VAR intnum old;
        VAR intnum new;
        TRAP rings
            TPWrite "rung";
        ENDTRAP"""
    body = """CONNECT old WITH rings;
        ITimer\\Single,0.1,old;
        IDisable;
        WaitTime 0.2;
        ISleep old;
        IDelete old;
        CONNECT new WITH rings;
        IEnable;
        WaitTime 0.1;
        TPWrite "nothing";
        ITimer\\Single,0.1,new;
        WaitTime 0.2;"""
    assert written(body, rest) == ["nothing", "rung"]
