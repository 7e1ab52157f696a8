"""`workbench serve --modbus`: a Modbus server for a bench."""

from collections.abc import Generator
from contextlib import closing, contextmanager

from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.extras.modbus.server import ModbusOptions, ModbusServer


@contextmanager
def serve_modbus(bench: Bench, typed: Serve, port: int) -> Generator[None]:
    """Serve Modbus as long as the block runs.

    Raises:
        InputError: the address cannot be had, or it is not stated who may connect.
    """
    options = ModbusOptions(port, typed.modbus_host, typed.modbus_client)
    with closing(ModbusServer(bench, options)) as server:
        host, port = server.address
        print(f"Modbus: {host} port {port}, for {', '.join(typed.modbus_client) or 'this machine'}")
        yield
