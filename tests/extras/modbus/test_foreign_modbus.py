"""The server, asked by a client of another make: mbpoll, which is made with libmodbus."""

import contextlib
import re
import shutil
import subprocess

import pytest
from waiting import PATIENCE, wait_until

from workbench.extras.modbus.jobs import Answer
from workbench.extras.modbus.registers import MAP_VERSION, SIZE, WRITTEN, Register
from workbench.extras.modbus.server import ModbusOptions, ModbusServer

SCAN = 1


@pytest.fixture
def ask(site):
    """Runs mbpoll; what it has read, by register, and what it says."""
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")
    with contextlib.closing(ModbusServer(site.bench, ModbusOptions(0))) as server:
        host, port = server.address

        def run(first, *words, count=1):
            how = ["-m", "tcp", "-0", "-1", "-t", "4", "-r", str(first), "-p", str(port)]
            how += [] if words else ["-c", str(count)]
            asked = subprocess.run(
                ["mbpoll", *how, host, *map(str, words)],
                capture_output=True,
                text=True,
                timeout=PATIENCE,
                check=False,
            )
            read = re.findall(r"^\[(\d+)\]:\s+(\d+)", asked.stdout, re.MULTILINE)
            return {int(k): int(value) for k, value in read}, asked.stdout + asked.stderr

        yield run


def test_it_scans_and_reads_every_register(site, ask):
    found, _ = ask(0, count=SIZE)
    assert sorted(found) == list(range(SIZE)) and found[Register.VERSION] == MAP_VERSION
    words = found[Register.SESSION], SCAN, 2, 0, found[Register.COUNTER_ANSWERED] + 1
    for _ in range(2):
        assert f"Written {WRITTEN} references" in ask(0, *words)[1]
    wait_until(lambda: ask(Register.ANSWER)[0][Register.ANSWER] == Answer.DONE)
    assert ask(Register.PHASE)[0][Register.PHASE] == 1
    assert len(site.on_record("TakeScan")) == 1


def test_it_is_told_what_is_refused(ask):
    assert "Illegal data address" in ask(WRITTEN, 1)[1]
    assert "Illegal data address" in ask(SIZE)[1]
    assert "Illegal data value" in ask(0, 0, SCAN, 0, 0, 1)[1]
