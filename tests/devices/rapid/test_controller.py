"""The loop around tasks, and sockets of modules on real TCP."""

import socket

import pytest
from patient import in_threads
from rapid_bench import module
from waiting import wait_until

from workbench.devices.rapid.controller import MOST_HELD, MOST_LINES, RapidController
from workbench.devices.rapid.sockets import Network
from workbench.formats.rapid.loading import read_source
from workbench.formats.rapid.setup import Setup, TaskSetup
from workbench.model.errors import LinkError, WorkbenchError


@pytest.fixture
def start(cell):
    """Starts controllers of one task; they end with the test."""

    def made(body, rest="", arm="", speed=100.0):
        source = read_source("m", module(body, rest))
        one = RapidController(cell, Setup({"T": TaskSetup([source], arm)}, {}), speed=speed)
        return started(one)

    with in_threads() as started:
        yield made


def connected(one):
    holder, at = one.tasks["T"].loaded.globals["server"].place
    wait_until(lambda: holder[at].is_listening)
    return socket.create_connection(("127.0.0.1", one.port))


SERVED = """
    SocketCreate server;
    SocketBind server,"192.168.125.1",5000;
    SocketListen server;
    SocketAccept server,client\\Time:=WAIT_MAX;"""
SOCKETS = "VAR socketdev server;\nVAR socketdev client;\nVAR string text;\n"


def test_what_a_late_piece_has_begun_is_had_by_a_smaller_request(start):
    rest = (
        SOCKETS
        + """PROC ask(num count)
            SocketReceive client\\Str:=text\\ReadNoOfBytes:=count\\Time:=0.3;
            TPWrite text;
        ERROR
            IF ERRNO=ERR_SOCK_TIMEOUT TPWrite "late";
            IF ERRNO=ERR_SOCK_CLOSED TPWrite "closed";
            RETURN;
        ENDPROC"""
    )
    body = SERVED + "ask 10; ask 2; ask 2; SocketReceive client\\Str:=text; TPWrite text; ask 1;"
    one = start(body, rest)
    with connected(one) as link:
        link.sendall(b"abcde")
        wait_until(lambda: len(one.written) == 5)
    assert one.written == ["late", "ab", "cd", "e", "late"]


@pytest.mark.parametrize("address", ["192.0.2.1", "127.example.com", "localhost"])
def test_a_module_connects_to_this_machine_and_to_no_other(start, address):
    one = start(f'SocketCreate client; SocketConnect client,"{address}",5000;', SOCKETS)
    wait_until(lambda: one.tasks["T"].stopped_by != "")
    assert "only 127.0.0.1 can be reached" in one.tasks["T"].stopped_by


def test_a_number_that_is_no_byte_stops_the_task_and_not_the_controller(start):
    one = start(SERVED + "SocketSend client\\Data:=wide;", SOCKETS + "VAR num wide{1}:=[300];")
    with connected(one):
        wait_until(lambda: one.tasks["T"].stopped_by != "")
    assert one.tasks["T"].stopped_by == "an argument makes no sense: bytes must be in range(0, 256)"


def test_a_port_has_one_controller(cell):
    first = Network("127.0.0.1", 0)
    with pytest.raises(LinkError, match="cannot listen"):
        Network("127.0.0.1", first.port)
    port = first.port
    first.close()
    Network("127.0.0.1", port).close()


def test_a_controller_that_fails_tells_and_ends(cell, caplog):
    one = RapidController(
        cell, Setup({"T": TaskSetup([read_source("m", module("WaitTime 9;"))])}, {})
    )
    one.later(lambda: {}["what nobody foresaw"])
    with pytest.raises(WorkbenchError, match="what nobody foresaw"):
        one.run()
    assert "the controller failed" in caplog.text
    assert not one.tasks["T"].is_alive


def test_an_interpreter_that_fails_ends_its_task(cell, caplog):
    one = RapidController(
        cell, Setup({"T": TaskSetup([read_source("m", module("WaitTime 9;"))])}, {})
    )
    one.tasks["T"].loaded.find("main").body = lambda frame: {}["what nobody foresaw"]
    one.tasks["T"].start()
    one.turn()
    assert "what nobody foresaw" in one.tasks["T"].stopped_by
    assert not one.tasks["T"].is_alive
    one.network.close()


def test_a_program_that_never_waits_does_not_hold_the_robots(start, caplog):
    body = """here:=CJointT(); here.robax.rax_1:=here.robax.rax_1+10;
        CONNECT once WITH looks; ITimer\\Single,0.2,once;
        MoveAbsJ here,v100,fine,tool0;
        TPWrite "there";"""
    rest = """VAR intnum once;
        VAR jointtarget here;
        TRAP looks
            WHILE TRUE DO
            ENDWHILE
        ENDTRAP"""
    one = start(body, rest, arm="right", speed=1.0)
    wait_until(lambda: one._held > MOST_HELD and one.mechanisms["T"].is_standing)
    assert caplog.text.count("does not wait") == 1


def test_only_the_newest_of_what_is_written_is_kept(cell):
    one = RapidController(
        cell, Setup({"T": TaskSetup([read_source("m", module("WaitTime 9;"))])}, {})
    )
    for k in range(MOST_LINES + 5):
        one._write("T", str(k))
    one.network.close()
    assert (len(one.written), one.written[0]) == (MOST_LINES, "5")
