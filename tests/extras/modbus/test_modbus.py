"""The Modbus server, asked over loopback by the client of pymodbus."""

import contextlib
import threading

import pytest
from pymodbus.client import ModbusTcpClient
from waiting import PATIENCE, wait_until

from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.extras.modbus.jobs import JOBS, Answer, Error
from workbench.extras.modbus.registers import ACTOR, HIGHEST_VALUE, PHASES, SIZE, WRITTEN, Register
from workbench.extras.modbus.server import ModbusOptions, ModbusServer
from workbench.model.errors import InputError

SCAN, FIND, PLAN, PICKED, FAILED, STOP, RECIPE = 1, 2, 3, 7, 8, 10, 11
SEND, GO_ON, CANCEL, TAKE, RELEASE = 20, 21, 22, 23, 24
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3


class Plc:
    """A PLC's program: it writes commands, and waits for their answers."""

    def __init__(self, address):
        self.client = ModbusTcpClient(address[0], port=address[1], timeout=PATIENCE)
        assert self.client.connect()

    def read(self, register):
        return self.client.read_holding_registers(register, count=1).registers[0]

    def write(self, *words, at=0):
        return self.client.write_registers(at, list(words))

    def words(self, command, first=0, second=0):
        counter = self.read(Register.COUNTER_ANSWERED) % HIGHEST_VALUE + 1
        return self.read(Register.SESSION), command, first, second, counter

    def give(self, command, first=0, second=0):
        """Give a command, and wait until it no longer runs."""
        assert not self.write(*self.words(command, first, second)).isError()
        wait_until(lambda: self.read(Register.ANSWER) != Answer.RUNNING)
        assert self.read(Register.COMMAND_ANSWERED) == command
        return self.read(Register.ANSWER), self.read(Register.ERROR)

    def phase(self):
        return PHASES[self.read(Register.PHASE)]


DONE = (Answer.DONE, Error.NONE)


def not_done(error):
    return Answer.NOT_DONE, error


@pytest.fixture
def server(site):
    with contextlib.closing(ModbusServer(site.bench, ModbusOptions(0))) as one:
        yield one


@pytest.fixture
def plc(server):
    one = Plc(server.address)
    yield one
    one.client.close()


def test_a_plc_runs_a_cycle_that_a_person_approves(site, plc):
    assert plc.phase() is Phase.IDLE
    assert plc.give(FIND) == not_done(Error.NOT_NOW)
    assert plc.give(SCAN, 2) == DONE and plc.phase() is Phase.SCANNED
    assert plc.give(FIND) == DONE
    assert (plc.read(Register.PARTS_FOUND), plc.read(Register.PARTS_LEFT)) == (2, 2)
    assert plc.give(PLAN) == DONE and plc.read(Register.PROOF_HOLDS) == 1
    plan = plc.read(Register.PLAN_HIGH), plc.read(Register.PLAN_LOW)
    digest = site.bench.state.plan.digest
    assert f"{plan[0]:04x}{plan[1]:04x}" == digest[:8]
    assert plc.give(SEND, *plan) == not_done(Error.NOT_NOW), "nobody has approved it"
    first = site.bench.state.plan.arms[0]
    assert plc.read(Register.NEXT_PART) == first.detection + 1
    assert (plc.read(Register.NEXT_KIND), plc.read(Register.NEXT_PLACE) > 0) == (1, True)
    site.bench.do(WatchPlan(digest, is_reported=True), "Ada")
    site.bench.do(Approve(digest), "Ada")
    assert plc.read(Register.APPROVED) == 1
    assert plc.give(SEND, plan[0] ^ 1, plan[1]) == not_done(Error.ARGUMENT)
    assert plc.give(SEND, *plan) == DONE
    wait_until(lambda: plc.phase() is Phase.DONE)
    assert site.effects.sent == [digest]
    assert plc.give(SEND, *plan) == not_done(Error.NOT_NOW)
    assert (plc.read(Register.PARTS_PLACED), plc.read(Register.PARTS_LEFT)) == (2, 0)
    assert plc.read(Register.APPROVED) == 0, "it is spent"
    assert plc.give(PICKED, first.detection + 1) == DONE
    assert plc.give(FAILED, site.bench.state.plan.arms[1].detection + 1) == DONE
    assert (plc.read(Register.PARTS_PICKED), plc.read(Register.PICKS_FAILED)) == (1, 1)
    assert plc.give(PICKED, 99) == not_done(Error.NOT_NOW)
    assert plc.give(PICKED, 0) == not_done(Error.ARGUMENT)
    assert {row["actor"] for kind in ("TakeScan", "SendPlan") for row in site.on_record(kind)} == {
        ACTOR
    }


def test_a_command_that_comes_again_is_not_given_again(site, plc):
    words = plc.words(SCAN)
    for _ in range(3):
        assert not plc.write(*words).isError()
    wait_until(lambda: plc.read(Register.ANSWER) == Answer.DONE)
    assert len(site.on_record("TakeScan")) == 1
    assert plc.read(Register.COUNTER_ANSWERED) == words[-1]


def test_another_command_with_a_counter_that_was_used_is_refused(site, plc):
    words = plc.words(SCAN)
    assert not plc.write(*words).isError()
    wait_until(lambda: plc.read(Register.ANSWER) == Answer.DONE)
    session, _, *others = words
    assert plc.write(session, STOP, *others).exception_code == ILLEGAL_VALUE
    assert plc.read(Register.COMMAND_ANSWERED) == SCAN


def test_a_counter_or_a_session_that_is_not_the_next_is_refused(site, plc):
    session, *words, counter = plc.words(SCAN)
    for wrong in ((session, *words, counter + 1), (session, *words, 0xFFFF)):
        assert plc.write(*wrong).exception_code == ILLEGAL_VALUE
    other = session % HIGHEST_VALUE + 1
    assert plc.write(other, *words, counter).exception_code == ILLEGAL_VALUE
    assert plc.write(0, *words, counter).exception_code == ILLEGAL_VALUE
    assert plc.read(Register.ANSWER) == Answer.NONE and not site.on_record("TakeScan")


def test_after_a_restart_an_old_command_is_not_given(site, plc):
    words = plc.words(SCAN)
    assert plc.give(SCAN) == DONE
    with contextlib.closing(ModbusServer(site.bench, ModbusOptions(0))) as anew:
        late = Plc(anew.address)
        if late.read(Register.SESSION) != words[0]:
            assert late.write(*words).exception_code == ILLEGAL_VALUE
        late.client.close()
    assert len(site.on_record("TakeScan")) == 1


def test_counters_begin_again_after_the_highest(site, plc, server):
    jobs = server._jobs
    jobs.answered = type(jobs.answered)(counter=HIGHEST_VALUE)
    assert plc.words(SCAN)[-1] == 1
    assert plc.give(SCAN) == DONE


def test_registers_can_be_written_one_by_one_with_the_counter_last(plc):
    for register, word in enumerate(plc.words(SCAN, 2)):
        assert not plc.client.write_register(register, word).isError()
    wait_until(lambda: plc.read(Register.ANSWER) == Answer.DONE)
    both = plc.client.readwrite_registers(
        read_address=0, read_count=WRITTEN, address=0, values=list(plc.words(TAKE))
    )
    assert both.registers[1] == TAKE


def test_one_connection_does_not_see_the_words_of_another(plc, server):
    other = Plc(server.address)
    plc.write(7, 7, 7, 7)
    assert plc.read(Register.COMMAND) == 7 and other.read(Register.COMMAND) == 0
    other.client.close()


def test_no_command_approves_or_acknowledges(site, plc):
    for command in set(range(40)) - set(JOBS):
        assert plc.give(command) == not_done(Error.COMMAND)
    assert {type(job.make(site.bench.state, 1, 1)).__name__ for job in JOBS.values()} == {
        "TakeScan",
        "FindParts",
        "MakePlan",
        "GoOn",
        "ReportPick",
        "Stop",
        "ChooseRecipe",
        "NewKit",
        "ChooseBin",
        "PlanView",
        "NewBin",
        "NoneType",
        "CancelJob",
        "TakeControl",
        "ReleaseControl",
    }


def test_whoever_is_in_control_is_not_overruled(site, plc):
    site.bench.do(TakeControl(), "Ada")
    assert plc.read(Register.CONTROL) == 2
    assert plc.give(SCAN) == not_done(Error.CONTROL)
    assert plc.give(TAKE) == not_done(Error.CONTROL)


def test_control_is_taken_and_given_back(plc):
    assert plc.give(TAKE) == DONE and plc.read(Register.CONTROL) == 1
    assert plc.give(RELEASE) == DONE and plc.read(Register.CONTROL) == 0


def test_a_running_task_is_followed_and_cancelled(site, plc):
    site.effects.hold.set()
    assert not plc.write(*plc.words(SCAN)).isError()
    wait_until(lambda: plc.read(Register.TASK) == 1)
    assert plc.read(Register.ANSWER) == Answer.RUNNING
    assert plc.give(CANCEL) == DONE and plc.read(Register.TASK) == 0


def test_a_task_that_somebody_else_cancels_has_no_result(site, plc):
    site.effects.hold.set()
    assert not plc.write(*plc.words(SCAN)).isError()
    wait_until(lambda: site.bench.state.job is not None)
    site.bench.do(CancelJob(), "Ada")
    wait_until(lambda: plc.read(Register.ANSWER) == Answer.NOT_DONE)
    assert plc.read(Register.ERROR) == Error.NO_RESULT


def test_arguments_that_cannot_be_are_refused(plc):
    assert plc.give(SCAN, HIGHEST_VALUE) == not_done(Error.NOT_NOW)
    assert plc.give(RECIPE, 7) == not_done(Error.NOT_NOW)
    assert plc.give(STOP) == not_done(Error.NOT_NOW), "nothing is being sent"


def test_an_error_of_ours_ends_no_connection(site, plc, monkeypatch, caplog):
    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr(site.bench, "do", broken)
    assert plc.give(SCAN) == not_done(Error.INTERNAL)
    assert "broken" in caplog.text


def test_only_the_first_registers_are_written_and_none_beyond_the_last_is_read(plc):
    assert plc.write(1, at=WRITTEN).exception_code == ILLEGAL_ADDRESS
    assert plc.write(*range(WRITTEN + 1)).exception_code == ILLEGAL_ADDRESS
    assert plc.write(1, at=0xFFFF).exception_code == ILLEGAL_ADDRESS
    read = plc.client.read_holding_registers
    assert len(read(0, count=SIZE).registers) == SIZE
    assert read(1, count=SIZE).exception_code == ILLEGAL_ADDRESS
    assert read(0xFFFF, count=1).exception_code == ILLEGAL_ADDRESS


def test_other_functions_are_refused(plc):
    for asked in (
        plc.client.read_coils(0, count=1),
        plc.client.read_input_registers(0, count=1),
        plc.client.write_coil(0, True),
        plc.client.read_device_information(),
        plc.client.diag_query_data(b"\x00\x01"),
        plc.client.mask_write_register(),
    ):
        assert asked.exception_code == ILLEGAL_FUNCTION
    assert plc.read(Register.VERSION) == 1


def test_life_goes_on(plc):
    before = plc.read(Register.LIFE)
    wait_until(lambda: plc.read(Register.LIFE) != before)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (ModbusOptions(0, "0.0.0.0", ("10.0.0.1",)), "one address"),
        (ModbusOptions(0, "::", ("10.0.0.1",)), "one address"),
        (ModbusOptions(0, "192.0.2.1"), "state who may connect"),
        (ModbusOptions(0, "localhost"), "no names"),
        (ModbusOptions(0, "127.0.0.1", ("plc",)), "no names"),
        (ModbusOptions(0, "192.0.2.1", ("10.0.0.1",)), "cannot be served"),
    ],
)
def test_it_listens_where_that_is_stated_and_for_whom(site, options, problem):
    with pytest.raises(InputError, match=problem):
        ModbusServer(site.bench, options)
    assert not [one for one in threading.enumerate() if one.name == "modbus"]


def test_parts_that_are_left_stay_until_a_plc_asks_for_new_ones(site, plc):
    assert plc.give(SCAN, 3) == DONE
    first = site.bench.state.pile
    # The scan is the same here, and is no new one.
    plc.give(SCAN)
    assert site.bench.state.pile.name == first.name
    plc.give(SCAN, 0, 1)
    assert (site.bench.state.pile.parts, site.bench.state.pile.seed != first.seed) == (3, True)
    assert plc.give(SCAN, 0, 2) == not_done(Error.ARGUMENT)
