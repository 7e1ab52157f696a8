"""OPC UA beside a bench, when somebody has asked for it."""

import logging
import os
from collections.abc import Generator
from contextlib import contextmanager

from workbench.app.core.people import Person, Role
from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.top import Serve
from workbench.cli.terminal import check_whole
from workbench.model.errors import InputError

PASSWORD = "WORKBENCH_OPCUA_PASSWORD"
"""Variable of the environment: what is typed can be read by everybody on the machine."""


@contextmanager
def plc(bench: Bench, typed: Serve) -> Generator[None]:
    """Serve OPC UA as long as the block runs, if a port was typed for it.

    Raises:
        InputError: the library is missing, the address cannot be had, or others could come without
            a password.
    """
    if typed.opcua is None:
        yield
        return
    check_whole("--opcua", typed.opcua, 1, 65535)
    try:
        from workbench.web.opcua.server import OpcUa, Options
    except ModuleNotFoundError as error:
        raise InputError(
            "--opcua needs the library asyncua: pip install 'workbench[opcua]'"
        ) from error
    # It warns that nothing is encrypted, as docs/opcua.md does.
    logging.getLogger("asyncua").setLevel(logging.ERROR)
    operator = Person(typed.opcua_operator, Role.OPERATOR)
    password = os.environ.get(PASSWORD, "")
    server = OpcUa(bench, Options(typed.opcua, operator, typed.host, password))
    print(f"OPC UA: opc.tcp://{typed.host}:{typed.opcua}/workbench, as {operator.name}")
    try:
        yield
    finally:
        server.close()
