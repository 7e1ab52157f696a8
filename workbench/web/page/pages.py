"""Our own pages and files: read once, filled in, and nothing else is ever served from a disk."""

import gzip
import hashlib
import html
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

from aiohttp import hdrs, web

from workbench.formats.files.shipped import find
from workbench.web.http.headers import page_policy
from workbench.web.page.languages import language_of
from workbench.web.page.manual import read_manual
from workbench.words.words import script_messages, words_of

TYPES: Mapping[str, str] = {
    "login.css": "text/css",
    "login.js": "text/javascript",
    "shell.css": "text/css",
    "shell.js": "text/javascript",
    "manual.css": "text/css",
    "tour.css": "text/css",
    "tour.js": "text/javascript",
    "scene.js": "text/javascript",
    "words.js": "text/javascript",
    "logo.svg": "image/svg+xml",
    "logo-dark.svg": "image/svg+xml",
    "inter.woff2": "font/woff2",
}
"""Files under `static/` that anybody may have, and what they are."""

PAGES = ("login.html", "manual.html", "onward.html", "shell.html")


@dataclass(frozen=True, slots=True)
class Pages:
    """The texts of our pages and their files (gzip), by name; and the manual as HTML."""

    texts: Mapping[str, str]
    files: Mapping[str, bytes]
    manual: str

    @classmethod
    def read(cls) -> "Pages":
        """Read them.

        Raises:
            FileError: one is missing.
        """
        return cls(
            {name: find("static", name).read_text(encoding="utf-8") for name in PAGES},
            {name: gzip.compress(find("static", name).read_bytes(), mtime=0) for name in TYPES},
            read_manual(),
        )

    def page(
        self, request: web.Request, name: str, status: int = 200, **values: str
    ) -> web.Response:
        """A page with its places `{{name}}` filled in; what is put there is text, never HTML."""
        text = _translate(self.texts[name], language_of(request))
        text = re.sub(r"\{\{(\w+)\}\}", lambda place: html.escape(values[place[1]]), text)
        return self._answer(request, text, status)

    async def show_manual(self, request: web.Request) -> web.Response:
        """The manual, which is HTML made of our own text."""
        return self._answer(request, self.texts["manual.html"].replace("{{manual}}", self.manual))

    def _answer(self, request: web.Request, text: str, status: int = 200) -> web.Response:
        return web.Response(
            text=text,
            status=status,
            content_type="text/html",
            headers=page_policy(sockets_of(request)),
        )

    async def file(self, request: web.Request) -> web.Response:
        """One of our files; a browser that has it as it is gets no second copy."""
        name = request.match_info["name"]
        if name not in self.files:
            raise web.HTTPNotFound
        tag = f'"{hashlib.sha256(self.files[name]).hexdigest()[:32]}"'
        headers = {"Cache-Control": "no-cache", "ETag": tag}
        if request.headers.get(hdrs.IF_NONE_MATCH) == tag:
            return web.Response(status=304, headers=headers)
        body, encoding = packed_for(request, self.files[name])
        return web.Response(body=body, content_type=TYPES[name], headers={**headers, **encoding})


@cache
def _translate(page: str, language: str) -> str:
    """A page in a language; what its scripts say comes along, and its places stay."""
    words = words_of(language)
    page = words.html(page).replace('<html lang="en">', f'<html lang="{language}">')
    said = json.dumps(script_messages(language), ensure_ascii=False)
    return page.replace("{{words}}", html.escape(said))


def packed_for(request: web.Request, packed: bytes) -> tuple[bytes, Mapping[str, str]]:
    """A body (gzip) as this browser takes it, and the headers that say how it is."""
    if "gzip" in request.headers.get(hdrs.ACCEPT_ENCODING, ""):
        return packed, {"Content-Encoding": "gzip", "Vary": "Accept-Encoding"}
    return gzip.decompress(packed), {"Vary": "Accept-Encoding"}


def sockets_of(request: web.Request) -> str:
    """Where the page of this request may open websockets to: here."""
    # Not every browser counts them as 'self' in a policy.
    return f"{'wss' if request.secure else 'ws'}://{request.host}"
