"""A page asked for a file, with login and TLS, by aiohttp."""

import asyncio
import ssl
from base64 import b64encode
from typing import Any
from urllib.parse import urlsplit

import aiohttp

from workbench.devices.scanners.logins import BASIC, DIGEST, NONE, HttpOptions, secret_of
from workbench.formats.clouds.scans import LARGEST_FILE
from workbench.model.errors import LinkError
from workbench.model.messages.devices import ScannerText


class _Pinned(aiohttp.Fingerprint):
    """A fingerprint; who shows another one is not said goodbye to, which could take long."""

    def check(self, transport: asyncio.Transport) -> None:
        try:
            super().check(transport)
        except aiohttp.ServerFingerprintMismatch:
            # The library still asks it for its address, and closes it.
            asyncio.get_running_loop().call_soon(transport.abort)
            raise


async def pull(address: str, options: HttpOptions, content: bytearray) -> None:
    """Fill `content` with what the page at an address gives, however long it takes.

    Raises:
        LinkError: the page cannot be reached or believed, or refuses.
    """
    try:
        trust = _trust(options)
        login = _login(options)
        # No time-outs here: the patience is looked after by who waits.
        session = aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=None))
        async with (
            session,
            session.get(address, ssl=trust, allow_redirects=False, **login) as answer,
        ):
            _check_status(answer, options.login)
            async for piece in answer.content.iter_any():
                content += piece
                if len(content) > LARGEST_FILE:
                    raise LinkError(ScannerText.TOO_LARGE())
    except aiohttp.ServerFingerprintMismatch as error:
        raise LinkError(ScannerText.OTHER_CERTIFICATE(found=error.got.hex())) from None
    except aiohttp.ClientConnectorCertificateError as error:
        reason = _plain(error.certificate_error)
        raise LinkError(ScannerText.CERTIFICATE(reason=reason)) from None
    except aiohttp.InvalidURL:
        raise LinkError(ScannerText.NO_ADDRESS()) from None
    except (aiohttp.ClientError, OSError, ValueError) as error:
        raise LinkError(f"{error or type(error).__name__}") from None


def _plain(error: Exception) -> str:
    """What OpenSSL says, without the place in its code."""
    return getattr(error, "verify_message", "") or str(error)


def _trust(options: HttpOptions) -> bool | aiohttp.Fingerprint | ssl.SSLContext:
    """Which certificates are believed: the usual ones, those of a file, or a single one."""
    if options.pinned:
        return _Pinned(bytes.fromhex(options.pinned))
    if not options.ca_file:
        return True
    try:
        return ssl.create_default_context(cafile=options.ca_file)
    except ssl.SSLError:
        detail = f"{options.ca_file} (ca_file) holds no certificates in PEM"
        raise LinkError(ScannerText.SECRET(detail=detail)) from None
    except OSError as error:
        detail = f"{options.ca_file} (ca_file): {error.strerror or error}"
        raise LinkError(ScannerText.SECRET(detail=detail)) from None


def _login(options: HttpOptions) -> dict[str, Any]:
    """How a request logs in, as the library takes it."""
    if options.login == NONE:
        return {}
    secret = secret_of(options)
    if options.login == DIGEST:
        return {"middlewares": (aiohttp.DigestAuthMiddleware(options.user, secret),)}
    if options.login == BASIC:
        both = b64encode(f"{options.user}:{secret}".encode()).decode()
        return {"headers": {"Authorization": f"Basic {both}"}}
    return {"headers": {"Authorization": f"Bearer {secret}"}}


def _check_status(answer: aiohttp.ClientResponse, login: str) -> None:
    """Refuse whatever is not a file.

    Raises:
        LinkError: the page refuses, is not there, or sends elsewhere.
    """
    status = f"{answer.status} {answer.reason}"
    if answer.status == 200:
        return
    if answer.status == 401 and login == NONE:
        raise LinkError(ScannerText.LOGIN_WANTED(status=status))
    if answer.status in (401, 403):
        raise LinkError(ScannerText.LOGIN_REFUSED(login=login, status=status))
    if 300 <= answer.status < 400:
        to = urlsplit(answer.headers.get("Location", "")).hostname or "elsewhere"
        raise LinkError(ScannerText.REDIRECTS(host=to, status=status))
    raise LinkError(ScannerText.NO_CLOUD(status=status))
