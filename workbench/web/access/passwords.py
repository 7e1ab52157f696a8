"""Passwords: Argon2id, as RFC 9106 has it for machines with little memory (64 MiB, 3 passes)."""

from argon2 import PasswordHasher, extract_parameters
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.profiles import RFC_9106_LOW_MEMORY

from workbench.model.errors import InputError

SHORTEST = 10
LONGEST_PASSWORD = 200

_HASHER = PasswordHasher.from_parameters(RFC_9106_LOW_MEMORY)

NOBODYS = (
    "$argon2id$v=19$m=65536,t=3,p=4$YSBzYWx0IGZvciBub2JvZA"
    "$AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"
)
"""A hash that no password has: a name that nobody has shall take as long to refuse as any other."""


def hash_of(password: str) -> str:
    """What is kept of a password, in the PHC string format.

    Raises:
        InputError: it is too short or too long, or holds bytes that are no text.
    """
    if len(password) < SHORTEST:
        raise InputError(f"a password needs at least {SHORTEST} characters, not {len(password)}")
    if len(password) > LONGEST_PASSWORD:
        raise InputError(
            f"a password has at most {LONGEST_PASSWORD} characters, not {len(password)}"
        )
    try:
        return _HASHER.hash(password)
    except UnicodeEncodeError:
        raise InputError("a password consists of characters; this one holds other bytes") from None


def is_right(password: str, kept: str) -> bool:
    """Whether it is the password that a hash was made of; takes some 0.1 s either way."""
    try:
        return _HASHER.verify(kept, password[: LONGEST_PASSWORD + 1])
    except (VerificationError, InvalidHashError):
        return False


def is_hash(kept: object) -> bool:
    """Whether it is a hash as we make them; one that asks for more memory would be an attack."""
    try:
        return isinstance(kept, str) and extract_parameters(kept) == RFC_9106_LOW_MEMORY
    except InvalidHashError:
        return False
