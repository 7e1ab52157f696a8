"""How the scanner `http` logs in, and whom it believes: keys that name secrets, never hold them.

A password or token is read when a scan is asked for, from a file that only its owner can read or
from the environment.  So it is in no cell file, digest, journal or message.
"""

import os
import re
import stat
from dataclasses import dataclass
from pathlib import Path

from workbench.model.errors import InputError, LinkError
from workbench.model.messages.devices import ScannerText
from workbench.plugins.options import option

NONE, BASIC, DIGEST, BEARER = "none", "basic", "digest", "bearer"

LONGEST_SECRET = 4096
"""[bytes] More is no password and no token."""

_VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}")
_SHA256 = re.compile(r"[0-9A-Fa-f]{64}")


@dataclass(frozen=True, slots=True)
class HttpOptions:
    """The keys of `http` under `[scanner.options]`."""

    login: str = option(NONE, among=(NONE, BASIC, DIGEST, BEARER), says="what the page asks for")
    user: str = option("", says="for basic and digest")
    secret_file: str = option(
        "", says="absolute path of a file with the password or token, for its owner alone"
    )
    secret_variable: str = option(
        "", says="environment variable with the password or token, instead of a file"
    )
    ca_file: str = option(
        "", says="absolute path of the certificates (PEM) that are believed, not the system's"
    )
    certificate_sha256: str = option(
        "", says="of the page's own certificate (DER), which then is the only one believed"
    )

    def __post_init__(self) -> None:
        named = [key for key in ("secret_file", "secret_variable") if getattr(self, key)]
        if self.login == NONE and (named or self.user):
            raise InputError(f"{(named or ['user'])[0]}: without login nobody is asked for it")
        if self.login != NONE and len(named) != 1:
            raise InputError(
                f"login: {self.login} needs one of secret_file and secret_variable, "
                f"{len(named)} are given"
            )
        if (self.login in (BASIC, DIGEST)) != bool(self.user):
            wants = "needs a user" if not self.user else "has no user"
            raise InputError(f"user: login {self.login} {wants}")
        if ":" in self.user or not self.user.isprintable():
            raise InputError("user: a name without colons and line ends is expected")
        # A secret that was put into the wrong key is not shown again.
        if self.secret_variable and not _VARIABLE.fullmatch(self.secret_variable):
            raise InputError("secret_variable: the name of an environment variable is expected")
        for key in ("secret_file", "ca_file"):
            if getattr(self, key) and not Path(getattr(self, key)).is_absolute():
                raise InputError(f"{key}: an absolute path is expected")
        if self.certificate_sha256 and self.ca_file:
            raise InputError("ca_file: certificate_sha256 is given, which believes no authority")
        if self.certificate_sha256 and not _SHA256.fullmatch(self.pinned):
            raise InputError(
                "certificate_sha256: 64 hexadecimal digits are expected, colons between or not"
            )

    @property
    def pinned(self) -> str:
        """The digits of `certificate_sha256`, empty where none is given."""
        return self.certificate_sha256.replace(":", "")


def secret_of(options: HttpOptions) -> str:
    """The password or token, as it stands in its file or in the environment.

    Raises:
        LinkError: it is not there, others may read it, or it is none.
    """
    if options.secret_variable:
        where = f"the environment variable {options.secret_variable} (secret_variable)"
        content = os.environ.get(options.secret_variable)
        if content is None:
            raise _unusable(f"{where} is not set")
    else:
        where = f"{options.secret_file} (secret_file)"
        content = _private(Path(options.secret_file), where)
    secret = content.removesuffix("\n").removesuffix("\r")
    if not secret or not secret.isprintable():
        raise _unusable(f"{where} holds no secret: one line of printable characters is expected")
    return secret


def _unusable(detail: str) -> LinkError:
    return LinkError(ScannerText.SECRET(detail=detail))


def _private(path: Path, where: str) -> str:
    """The content of a file that belongs to us or to root and is for its owner alone."""
    try:
        # A pipe would be waited for.
        number = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
        with open(number, "rb") as file:
            about = os.fstat(number)
            if not stat.S_ISREG(about.st_mode):
                raise _unusable(f"{where} is no file")
            if about.st_uid not in (os.geteuid(), 0):
                raise _unusable(f"{where} belongs to another user of this computer")
            if about.st_mode & 0o077:
                raise _unusable(
                    f"{where} can be used by others than its owner (mode "
                    f"{stat.S_IMODE(about.st_mode):04o}): `chmod 600 {path}`, and change the secret"
                )
            content = file.read(LONGEST_SECRET + 1)
    except OSError as error:
        raise _unusable(f"{where}: {error.strerror or error}") from None
    if len(content) > LONGEST_SECRET:
        raise _unusable(f"{where} holds more than {LONGEST_SECRET} bytes, which is no secret")
    try:
        return content.decode()
    except UnicodeDecodeError:
        raise _unusable(f"{where} is no text in UTF-8") from None
