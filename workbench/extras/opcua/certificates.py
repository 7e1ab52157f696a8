"""The folder of certificates: the server's own, those of clients that are trusted, and others.

`server.der` and `server_key.pem` are the server's; `trusted/` holds a file (DER or PEM) for each
client that may open a channel; `rejected/` the last ones that came and were not among these.
"""

import hashlib
import ipaddress
import logging
import os
import socket
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import rsa
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from workbench.formats.files.whole_files import make_folder, read_whole, write_whole
from workbench.model.errors import FileError, InputError

log = logging.getLogger(__name__)

CERTIFICATE, KEY, TRUSTED, REJECTED = "server.der", "server_key.pem", "trusted", "rejected"

FILE_ENDINGS = frozenset((".der", ".pem", ".crt", ".cer"))

BITS = 3072
"""Of the server's RSA key; the policies take 2048 to 4096 (OPC 10000-7)."""

LEAST_BITS = 2048
LONGEST_CERTIFICATE = 16 * 1024
"""Bytes of a certificate."""

MOST_TRUSTED = 500
MOST_REJECTED = 20
"""The oldest go: who reaches the port can have these written."""

OWNER_ONLY = 0o600


def make_certificate(folder: Path, names: Sequence[str], days: int) -> str:
    """Write the server's key and the certificate that it signs itself, valid from now on.

    Args:
        folder: of certificates, made if it is not there.
        names: host names and addresses by which clients reach the server.
        days: for how long.

    Returns:
        Its thumbprint.

    Raises:
        InputError: a name cannot be one.
        FileError: there is one already, or it cannot be written.
    """
    make_folder(folder)
    for name in (CERTIFICATE, KEY):
        if (folder / name).exists():
            raise FileError(folder / name, "is there already: move it away to make another one")
    host = socket.gethostname()
    alternatives = [x509.UniformResourceIdentifier(f"urn:{host}:workbench")]
    key = rsa.generate_private_key(public_exponent=65537, key_size=BITS)
    subject = x509.Name(
        [
            x509.NameAttribute(NameOID.COMMON_NAME, f"Workbench on {host}"[:64]),
            x509.NameAttribute(NameOID.ORGANIZATION_NAME, "Workbench"),
        ]
    )
    now = datetime.now(UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + timedelta(days=days))
        .add_extension(
            x509.SubjectAlternativeName(
                [*alternatives, *(_name(host_name) for host_name in names)]
            ),
            critical=False,
        )
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(_usage(), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    try:
        number = os.open(folder / KEY, os.O_WRONLY | os.O_CREAT | os.O_EXCL, OWNER_ONLY)
        with os.fdopen(number, "wb") as file:
            file.write(secret)
    except OSError as error:
        raise FileError(folder / KEY, error.strerror or "cannot be written") from error
    der = certificate.public_bytes(serialization.Encoding.DER)
    write_whole(folder / CERTIFICATE, der)
    return thumbprint(der)


def read_certificate(path: Path) -> x509.Certificate:
    """A certificate from a file, DER or PEM.

    Raises:
        FileError: it cannot be read, or is none.
    """
    content = read_whole(path, LONGEST_CERTIFICATE)
    try:
        if b"-----BEGIN" in content:
            return x509.load_pem_x509_certificate(content)
        return x509.load_der_x509_certificate(content)
    except ValueError as error:
        raise FileError(path, "is no certificate (DER or PEM)") from error


def application_uri(certificate: x509.Certificate) -> str:
    """The URI by which OPC UA knows the application that a certificate is of; "" without one."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName)
    except (x509.ExtensionNotFound, ValueError):
        return ""
    found = names.value.get_values_for_type(x509.UniformResourceIdentifier)
    return found[0] if found else ""


def thumbprint(der: bytes) -> str:
    """The SHA-1 by which OPC UA names a certificate (OPC 10000-6, 6.2.3); proves nothing."""
    return hashlib.sha1(der, usedforsecurity=False).hexdigest()


def trust(folder: Path, path: Path) -> x509.Certificate:
    """Trust the client whose certificate this file is; it may come from `rejected`.

    Raises:
        InputError: the key is of another kind than the policies take, or too short.
        FileError: it is no certificate, or cannot be kept.
    """
    certificate = read_certificate(path)
    key = certificate.public_key()
    if not isinstance(key, rsa.RSAPublicKey) or key.key_size < LEAST_BITS:
        raise InputError(f"{path}: an RSA key of at least {LEAST_BITS} bits was expected")
    der = certificate.public_bytes(serialization.Encoding.DER)
    make_folder(folder / TRUSTED)
    name = f"{thumbprint(der)}.der"
    write_whole(folder / TRUSTED / name, der)
    (folder / REJECTED / name).unlink(missing_ok=True)
    return certificate


def read_certificates(folder: Path) -> Iterator[tuple[Path, x509.Certificate]]:
    """The certificates in a folder, by the names of their files; what is none is passed over."""
    try:
        there = (path for path in folder.iterdir() if path.suffix.lower() in FILE_ENDINGS)
        paths = sorted(path for path in there if path.name != KEY)
    except OSError:
        return
    for path in paths[:MOST_TRUSTED]:
        try:
            yield path, read_certificate(path)
        except FileError as error:
            log.warning("passed over a certificate: %s", error)


def problem(folder: Path, der: bytes | None) -> str:
    """Why a client with this certificate is kept out; "" when it is trusted.

    The folder is read each time: whom an engineer trusts comes in without a restart.
    """
    if not der or len(der) > LONGEST_CERTIFICATE:
        return "it shows no certificate"
    try:
        certificate = x509.load_der_x509_certificate(der)
    except ValueError:
        return "what it shows is no certificate"
    now = datetime.now(UTC)
    if not any(
        trusted.public_bytes(serialization.Encoding.DER) == der
        for _, trusted in read_certificates(folder / TRUSTED)
    ):
        _reject(folder / REJECTED, der)
        return f"its certificate {thumbprint(der)} is not trusted"
    if not certificate.not_valid_before_utc <= now <= certificate.not_valid_after_utc:
        return f"its certificate {thumbprint(der)} is not valid at this time"
    return ""


def _reject(folder: Path, der: bytes) -> None:
    """Keep a certificate for an engineer to look at."""
    path = folder / f"{thumbprint(der)}.der"
    try:
        make_folder(folder)
        if not path.exists():
            write_whole(path, der)
        there = sorted(folder.glob("*.der"), key=lambda file: file.stat().st_mtime_ns)
        for file in there[:-MOST_REJECTED]:
            file.unlink(missing_ok=True)
    except (OSError, FileError) as error:
        log.warning("a rejected certificate cannot be kept: %s", error)


def _name(text: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(text))
    except ValueError:
        pass
    if not text or not text.isascii() or len(text) > 253 or set(text) & set(" /:@"):
        raise InputError(f"{text!r} is neither a host name nor an address")
    return x509.DNSName(text)


def _usage() -> x509.KeyUsage:
    """What OPC 10000-6 (6.2.2) asks of the certificate of an application."""
    return x509.KeyUsage(
        digital_signature=True,
        content_commitment=True,
        key_encipherment=True,
        data_encipherment=True,
        key_agreement=False,
        key_cert_sign=False,
        crl_sign=False,
        encipher_only=False,
        decipher_only=False,
    )
