"""Viser's page in pieces, that a browser fetches side by side.

The page is one file of 0.7 MB, nearly all of it its packed program in one attribute.  On a line
that loses packets one connection carries a part of what the line could: each loss halves its
speed.  Several together fill it, and pieces that were fetched once are kept for good.
"""

import gzip
import hashlib
import re
from dataclasses import dataclass

PIECES = 6
"""As many connections as a browser opens to one address."""

PATH = "/scene/pieces"

_PROGRAM = re.compile(r'<script data-p="([^"<>]+)"')
_UNPACKS = "de(d.p)"


@dataclass(frozen=True, slots=True)
class CutPage:
    """A page and its pieces, packed (gzip).

    Attributes:
        page: what is left of the page, with a script that fetches the pieces.
        pieces: by the digest that is the end of their address; none where the page is whole.
    """

    page: bytes
    pieces: dict[str, bytes]


def cut(text: str) -> CutPage:
    """Cut a page up; one that is not as viser 1.1.1 makes it stays whole."""
    programs = _PROGRAM.findall(text)
    if len(programs) != 1 or text.count(_UNPACKS) != 1:
        return CutPage(_compress(text), {})
    program = programs[0]
    size = -(-len(program) // PIECES)
    pieces = [_compress(program[at : at + size]) for at in range(0, len(program), size)]
    named = {hashlib.sha256(piece).hexdigest()[:32]: piece for piece in pieces}
    addresses = ",".join(f'"{PATH}/{name}"' for name in named)
    # Fetched while the rest of the page is read.  A piece that does not come is asked for again:
    # half a page tells nobody what is wrong.
    fetching = (
        "<script>globalThis.wbProgram=Promise.all(["
        + addresses
        + "].map(async a=>{for(;;){try{const r=await fetch(a);if(r.ok)return await r.text();"
        "if(r.status===401)return parent.location.replace('/login')}catch{}"
        "await new Promise(r=>setTimeout(r,1000))}})).then(t=>t.join(''))</script>"
    )
    whole = text.replace(program, "", 1).replace(_UNPACKS, "de(await globalThis.wbProgram)", 1)
    return CutPage(_compress(whole.replace("<script", f"{fetching}<script", 1)), named)


def _compress(text: str) -> bytes:
    # The same bytes at each start: browsers know by them whether the page is another one.
    return gzip.compress(text.encode(), compresslevel=9, mtime=0)
