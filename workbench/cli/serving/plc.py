"""OPC UA and Modbus for a bench, where somebody has asked for them."""

import logging
import os
from collections.abc import Generator
from contextlib import closing, contextmanager

from workbench.app.core.people import Person, Role
from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.cli.terminal import check_whole
from workbench.model.errors import InputError
from workbench.web.access.lockout import Lockout
from workbench.web.access.store import Store
from workbench.web.access.users import Users

PASSWORD = "WORKBENCH_OPCUA_PASSWORD"
"""Variable of the environment: what is typed can be read by everybody on the machine."""


NEEDED = "the library asyncua: pip install 'workbench[opcua]'"


@contextmanager
def plc(bench: Bench, typed: Serve) -> Generator[None]:
    """Serve OPC UA as long as the block runs, if a port was typed for it.

    Raises:
        InputError: the library is missing, the address cannot be had, or others could come without
            a password.
        FileError: the certificate or its key cannot be read.
    """
    if typed.opcua is None:
        yield
        return
    check_whole("--opcua", typed.opcua, 1, 65535)
    try:
        from workbench.web.opcua.admission import OpcUaLogins, OpcUaOptions
        from workbench.web.opcua.certificates import CERTIFICATE
        from workbench.web.opcua.server import OpcUa
    except ModuleNotFoundError as error:
        raise InputError(f"--opcua needs {NEEDED}") from error
    # It warns that nothing is encrypted, as docs/opcua.md does.
    logging.getLogger("asyncua").setLevel(logging.ERROR)
    operator = Person(typed.opcua_operator, Role.OPERATOR)
    has_certificate = (typed.opcua_certificates / CERTIFICATE).is_file()
    with closing(Store(typed.users)) as store:
        options = OpcUaOptions(
            typed.opcua,
            operator,
            typed.host,
            os.environ.get(PASSWORD, ""),
            typed.opcua_certificates if has_certificate else None,
            is_plain=typed.opcua_plain,
            logins=OpcUaLogins(Users(store), Lockout(store)),
        )
        server = OpcUa(bench, options)
        how = "" if has_certificate else ", not encrypted: see workbench opcua certificate"
        print(f"OPC UA: {server.url}, as {operator.name}{how}")
        try:
            yield
        finally:
            server.close()


@contextmanager
def modbus(bench: Bench, typed: Serve) -> Generator[None]:
    """Serve Modbus as long as the block runs, if a port was typed for it.

    Raises:
        InputError: the library is missing, the address cannot be had, or it is not stated who may
            connect.
    """
    if typed.modbus is None:
        yield
        return
    check_whole("--modbus", typed.modbus, 1, 65535)
    try:
        from workbench.web.modbus.server import ModbusOptions, ModbusServer
    except ModuleNotFoundError as error:
        needed = "the library pymodbus: pip install 'workbench[modbus]'"
        raise InputError(f"--modbus needs {needed}") from error
    options = ModbusOptions(typed.modbus, typed.modbus_host, typed.modbus_client)
    with closing(ModbusServer(bench, options)) as server:
        host, port = server.address
        print(f"Modbus: {host} port {port}, for {', '.join(typed.modbus_client) or 'this machine'}")
        yield
