"""What can be typed after `workbench serve`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path

from workbench.cli.arguments.access import USERS
from workbench.cli.arguments.names import CellName, ListenOn, Maybe, UsersFile
from workbench.cli.arguments.plc import CERTIFICATES


@dataclass(frozen=True, slots=True)
class Serve:
    """Serve the page of a cell to those who log in.

    A cell whose controller is on this machine, where nothing answers, gets a simulated one.
    Without users the link that is printed lets one browser in; `workbench user add` makes users.
    """

    cell: CellName = "yumi"
    host: ListenOn = "127.0.0.1"
    port: int = 8080
    """Port to listen on; 0 takes a free one."""
    session: Maybe[Path] = None
    """Folder of a session to go on with, where it ended; its cell is the one that it has now. One
    that another program writes to is only checked."""
    after: Maybe[Path] = None
    """Folder of a session that the new one names as the one before it."""
    anchor: tuple[str, ...] = ()
    """Where the head of the journal goes at every approval: a file, better on another disk, or an
    address to post to."""
    opcua: Maybe[int] = None
    """Serve OPC UA on this port, too; with a password from WORKBENCH_OPCUA_PASSWORD, or on this
    machine only."""
    opcua_operator: str = "plc"
    """Name of the operator that whoever calls over OPC UA acts as."""
    opcua_certificates: Path = CERTIFICATES
    """Folder of certificates. With one of the server in it (`workbench opcua certificate`) channels
    are signed or encrypted, and users may come by their own names and passwords."""
    opcua_plain: bool = False
    """Take channels that are neither signed nor encrypted all the same."""
    modbus: Maybe[int] = None
    """Serve Modbus TCP on this port, too: usually 502."""
    modbus_host: str = "127.0.0.1"
    """Address of this machine that Modbus listens on."""
    modbus_client: tuple[str, ...] = ()
    """Addresses that may connect over Modbus, which has no logins; on 127.0.0.1 none is needed."""
    log: Maybe[Path] = None
    """Write the log to this file, too, an object of JSON a line; turned at 10 MB, five are kept."""
    stalls: Maybe[Path] = None
    """Write what holds this process up for 50 ms or longer to this file, JSON, an object a line."""
    users: UsersFile = USERS
    certificate: Maybe[Path] = None
    """PEM file to serve over TLS with."""
    key: Maybe[Path] = None
    """PEM file of the certificate's key, not encrypted."""
    name: tuple[str, ...] = ()
    """Names under which browsers ask for this machine, beside --host and addresses."""
    hours: float = 8.0
    """How long a login lasts [h]."""
