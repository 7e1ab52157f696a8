"""Keys and signatures (Ed25519), and requests for a time stamp (RFC 3161).

The private key is a PEM file (PKCS #8), not encrypted, readable by its owner alone.
"""

import hashlib
import os
import secrets
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.extras.evidence.packing import signed_message
from workbench.formats.files.whole_files import read_whole
from workbench.model.errors import FileError, InputError
from workbench.plugins.extras import install_command

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

NEEDED = f"signing needs the package cryptography: {install_command('evidence')}"

LONGEST_KEY = 10_000

OWNER_ONLY = 0o600

SHA256 = bytes.fromhex("300d06096086480165030402010500")
"""DER: the algorithm SHA-256, without parameters but NULL."""


def make_key(path: Path) -> str:
    """Write a new private key into a new file.

    Returns:
        The public key, 64 hexadecimal digits.

    Raises:
        InputError: what signs is not installed.
        FileError: the file is there already, or cannot be written.
    """
    try:
        from cryptography.hazmat.primitives import serialization
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
    except ImportError:
        raise InputError(NEEDED) from None
    key = Ed25519PrivateKey.generate()
    pem = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    try:
        number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, OWNER_ONLY)
    except FileExistsError:
        raise FileError(path, "is there already; a key is never overwritten") from None
    except (OSError, ValueError) as error:
        raise FileError(path, getattr(error, "strerror", None) or "cannot be written") from None
    with open(number, "wb") as file:
        file.write(pem)
    return key.public_key().public_bytes_raw().hex()


def read_key(path: Path) -> "Ed25519PrivateKey":
    """The private key in a file.

    Raises:
        InputError: what signs is not installed.
        FileError: it cannot be read, or is no such key.
    """
    try:
        from cryptography.exceptions import UnsupportedAlgorithm
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
        from cryptography.hazmat.primitives.serialization import load_pem_private_key
    except ImportError:
        raise InputError(NEEDED) from None
    try:
        key = load_pem_private_key(read_whole(path, LONGEST_KEY), None)
    except (ValueError, TypeError, UnsupportedAlgorithm):
        key = None
    if not isinstance(key, Ed25519PrivateKey):
        raise FileError(path, "is no Ed25519 key in PEM without a password; see `evidence key`")
    return key


def signature_of(key: "Ed25519PrivateKey", manifest: bytes) -> bytes:
    """Public key and signature of a manifest, in hexadecimal digits, a line each."""
    public = key.public_key().public_bytes_raw().hex()
    return f"{public}\n{key.sign(signed_message(manifest)).hex()}\n".encode()


def time_stamp_request(content: bytes) -> bytes:
    """What a time-stamping authority is asked: a TimeStampReq (RFC 3161, 2.4.1) in DER.

    It names the SHA-256 of the content, asks for the certificate, and has a nonce.
    """
    imprint = _der(0x30, SHA256 + _der(0x04, hashlib.sha256(content).digest()))
    # The first bit of an INTEGER is its sign.
    nonce = _der(0x02, bytes([secrets.randbelow(127) + 1]) + secrets.token_bytes(7))
    return _der(0x30, _der(0x02, b"\x01") + imprint + nonce + _der(0x01, b"\xff"))


def _der(tag: int, content: bytes) -> bytes:
    """A value in DER; all of ours are shorter than 128 bytes."""
    return bytes([tag, len(content)]) + content
