"""`workbench serve --opcua`: an OPC UA server for a bench."""

import logging
import os
from collections.abc import Generator
from contextlib import closing, contextmanager

from workbench.app.core.people import Person, Role
from workbench.app.runtime.bench import Bench
from workbench.cli.arguments.serving import Serve
from workbench.extras.opcua.admission import OpcUaLogins, OpcUaOptions
from workbench.extras.opcua.certificates import CERTIFICATE
from workbench.extras.opcua.server import OpcUa
from workbench.web.access.lockout import Lockout
from workbench.web.access.store import Store
from workbench.web.access.users import Users

PASSWORD = "WORKBENCH_OPCUA_PASSWORD"
"""Variable of the environment: what is typed can be read by everybody on the machine."""


@contextmanager
def serve_opcua(bench: Bench, typed: Serve, port: int) -> Generator[None]:
    """Serve OPC UA as long as the block runs.

    Raises:
        InputError: the address cannot be had, or others could come without a password.
        FileError: the certificate or its key cannot be read.
    """
    # It warns that nothing is encrypted, as docs/opcua.md does.
    logging.getLogger("asyncua").setLevel(logging.ERROR)
    operator = Person(typed.opcua_operator, Role.OPERATOR)
    has_certificate = (typed.opcua_certificates / CERTIFICATE).is_file()
    with closing(Store(typed.users)) as store:
        options = OpcUaOptions(
            port,
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
