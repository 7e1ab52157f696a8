"""OPC UA and Modbus for a bench, where somebody has asked for them."""

from contextlib import AbstractContextManager, nullcontext

from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.cli.terminal import check_whole
from workbench.plugins.extras import from_extra


def plc(bench: Bench, typed: Serve) -> AbstractContextManager[None]:
    """Serve OPC UA as long as the block runs, if a port was typed for it.

    Raises:
        InputError: the library is missing, the address cannot be had, or others could come without
            a password.
        FileError: the certificate or its key cannot be read.
    """
    return _serving("opcua", typed.opcua, bench, typed)


def modbus(bench: Bench, typed: Serve) -> AbstractContextManager[None]:
    """Serve Modbus as long as the block runs, if a port was typed for it.

    Raises:
        InputError: the library is missing, the address cannot be had, or it is not stated who may
            connect.
    """
    return _serving("modbus", typed.modbus, bench, typed)


def _serving(
    extra: str, port: int | None, bench: Bench, typed: Serve
) -> AbstractContextManager[None]:
    if port is None:
        return nullcontext()
    check_whole(f"--{extra}", port, 1, 65535)
    return from_extra(f"{extra}.serving:serve_{extra}", f"--{extra} needs")(bench, typed, port)
