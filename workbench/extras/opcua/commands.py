"""`workbench opcua`: the certificates of the OPC UA server and of its clients."""

import socket
from pathlib import Path
from typing import assert_never

from cryptography.hazmat.primitives.serialization import Encoding

from workbench.cli.arguments.plc import (
    OpcUaCertificate,
    OpcUaCommands,
    OpcUaList,
    OpcUaTrust,
)
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_whole, print_json, print_table
from workbench.extras.opcua import certificates as kept
from workbench.extras.opcua.certificates import (
    REJECTED,
    TRUSTED,
    application_uri,
    read_certificates,
    thumbprint,
)

MOST_DAYS = 36500


def certificates(typed: OpcUaCommands) -> int:
    """Carry out a command about certificates.

    Raises:
        InputError: something typed cannot be.
        FileError: a file cannot be read or written.
    """
    what = typed.what
    match what:
        case OpcUaCertificate():
            check_whole("--days", what.days, 1, MOST_DAYS)
            own = dict.fromkeys((socket.gethostname(), "localhost", "127.0.0.1", *what.name))
            print(kept.make_certificate(what.certificates, tuple(own), what.days))
        case OpcUaTrust():
            certificate = kept.trust(what.certificates, what.file)
            who = certificate.subject.rfc4514_string()
            print(f"{who} ({kept.application_uri(certificate)}) is trusted")
        case OpcUaList():
            _list(what.certificates, as_json=what.json)
        case _:
            assert_never(what)
    return SUCCESS


def _list(folder: Path, *, as_json: bool) -> None:
    rows = [
        (
            name or "server",
            thumbprint(certificate.public_bytes(Encoding.DER)),
            certificate.subject.rfc4514_string(),
            application_uri(certificate),
            f"{certificate.not_valid_after_utc:%Y-%m-%d}",
        )
        for name in ("", TRUSTED, REJECTED)
        for _, certificate in read_certificates(folder / name)
    ]
    columns = ("whose", "thumbprint", "subject", "uri", "until")
    if as_json:
        print_json({"certificates": [dict(zip(columns, row, strict=True)) for row in rows]})
    else:
        # Thumbprints are compared digit by digit: what would make the table too wide is left out.
        narrow = [(whose, mark, uri, until) for whose, mark, _, uri, until in rows]
        print_table(f"Certificates in {folder}", ("whose", "thumbprint", "uri", "until"), narrow)
