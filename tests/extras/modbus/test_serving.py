"""`workbench serve --modbus`, as people type it."""

import sys

import pytest
from idle import Idle
from ports import free_port
from pymodbus.client import ModbusTcpClient

from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.cli.serving.plc import serve_plc
from workbench.extras.modbus.registers import MAP_VERSION, Register
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.errors import InputError


@pytest.fixture
def bench(tmp_path):
    one = Bench(read_cell("yumi"), Journal(tmp_path / "session"), effects=Idle)
    yield one
    one.close()


def test_it_is_off_unless_asked_for(bench, capsys):
    with serve_plc("modbus", bench, Serve()):
        assert capsys.readouterr().out == ""


def test_it_is_served_where_that_was_typed(bench, capsys):
    port = free_port()
    with serve_plc("modbus", bench, Serve(modbus=port)):
        assert capsys.readouterr().out == f"Modbus: 127.0.0.1 port {port}, for this machine\n"
        with ModbusTcpClient("127.0.0.1", port=port) as client:
            read = client.read_holding_registers(Register.VERSION, count=1)
        assert read.registers == [MAP_VERSION]


def test_what_is_wrong_is_said(bench, monkeypatch):
    for typed, problem in (
        (Serve(modbus=0), "--modbus"),
        (Serve(modbus=502, modbus_host="192.0.2.1"), "state who may connect"),
    ):
        with pytest.raises(InputError, match=problem), serve_plc("modbus", bench, typed):
            pass
    monkeypatch.setitem(sys.modules, "pymodbus.constants", None)
    for name in ("server", "serving"):
        monkeypatch.delitem(sys.modules, f"workbench.extras.modbus.{name}")
    with (
        pytest.raises(InputError, match="pip install"),
        serve_plc("modbus", bench, Serve(modbus=502)),
    ):
        pass
