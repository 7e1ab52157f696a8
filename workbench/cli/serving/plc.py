"""OPC UA and Modbus servers for a bench."""

from contextlib import AbstractContextManager, nullcontext
from typing import Literal

from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.cli.terminal import check_whole
from workbench.plugins.extras import from_extra


def serve_plc(
    extra: Literal["opcua", "modbus"], bench: Bench, typed: Serve
) -> AbstractContextManager[None]:
    """Serve a PLC as long as the block runs, if its port was typed.

    Raises:
        InputError: the library is missing, the address is not available, or the options admit
            clients without a password (OPC UA) or a stated address (Modbus).
        FileError: the certificate or its key cannot be read.
    """
    port: int | None = getattr(typed, extra)
    if port is None:
        return nullcontext()
    check_whole(f"--{extra}", port, 1, 65535)
    return from_extra(f"{extra}.serving:serve_{extra}", f"--{extra} needs")(bench, typed, port)
