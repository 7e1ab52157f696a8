"""What can be typed after `workbench opcua`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import CertificatesFolder, Json

CERTIFICATES = Path("sessions/opcua")
"""Where certificates are kept unless stated otherwise."""


@dataclass(frozen=True, slots=True)
class OpcUaCertificate:
    """Make the key of the OPC UA server and its certificate, which it signs itself.

    From then on `serve --opcua` takes only channels that are signed or encrypted.
    """

    name: tuple[str, ...] = ()
    """Host names and addresses by which clients reach this machine; its own name and localhost are
    always among them."""
    days: int = 1825
    """How long it is valid."""
    certificates: CertificatesFolder = CERTIFICATES


@dataclass(frozen=True, slots=True)
class OpcUaTrust:
    """Let a client open a channel: take its certificate into trusted/. No restart is needed.

    Those that came and were not trusted lie in rejected/. Compare the thumbprint with the one that
    the client shows, and delete the file from trusted/ to keep it out again.
    """

    file: Positional[Path]
    """The client's certificate: DER or PEM."""
    certificates: CertificatesFolder = CERTIFICATES


@dataclass(frozen=True, slots=True)
class OpcUaList:
    """List the server's certificate, those of trusted clients, and those that were rejected."""

    certificates: CertificatesFolder = CERTIFICATES
    json: Json = False


@dataclass(frozen=True, slots=True)
class OpcUaCommands:
    """Make the OPC UA server's certificate and say which clients are trusted."""

    what: (
        Annotated[OpcUaCertificate, subcommand("certificate")]
        | Annotated[OpcUaTrust, subcommand("trust")]
        | Annotated[OpcUaList, subcommand("list")]
    )
