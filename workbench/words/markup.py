"""Texts within HTML, CSS and Markdown as the page has them: found, and put in another language."""

import html
import re
from collections.abc import Callable, Iterator

TAG = re.compile(r"""<(?:[a-zA-Z/!](?:[^>"']|"[^"]*"|'[^']*')*)>""")

_SAID = re.compile(r"""\b(title|aria-label|placeholder|alt)="([^"]*)\"""")
_SILENT = ("style", "script", "svg")
_CUT = re.compile(r"(\*\*|\n+|^#+ |^- )", re.MULTILINE)


def _pieces(text: str) -> Iterator[tuple[str, str]]:
    """HTML in order: `text`, `tag`, or `silent` for styles, scripts and names people chose."""
    at, silent = 0, ""
    for found in TAG.finditer(text):
        if found.start() > at:
            yield ("silent" if silent else "text"), text[at : found.start()]
        yield "tag", found[0]
        name = re.match(r"</?(\w+)", found[0])
        is_name = not silent and 'translate="no"' in found[0]
        if name and (is_name or name[1] in (*_SILENT, silent)) and not found[0].endswith("/>"):
            silent = "" if found[0].startswith("</") else name[1]
        at = found.end()
    if at < len(text):
        yield ("silent" if silent else "text"), text[at:]


def _attributes(tag: str) -> Iterator[str]:
    """What a tag says to people."""
    for found in _SAID.finditer(tag):
        yield html.unescape(found[2])


def texts_of(text: str) -> Iterator[str]:
    """All that HTML says to people."""
    for kind, piece in _pieces(text):
        if kind == "tag":
            yield from _attributes(piece)
        elif kind == "text" and piece.strip():
            yield html.unescape(piece)


def html_said(text: str, say: Callable[[str], str]) -> str:
    """HTML with its texts put through `say`."""
    if "<" not in text:
        return _translate_html(text, say)
    made: list[str] = []
    for kind, piece in _pieces(text):
        if kind == "tag":
            piece = _SAID.sub(lambda match: f'{match[1]}="{_translate_html(match[2], say)}"', piece)
        elif kind == "text":
            piece = _translate_html(piece, say)
        made.append(piece)
    return "".join(made)


def _translate_html(text: str, say: Callable[[str], str]) -> str:
    """A text of HTML, which stays as it is written where nothing is changed."""
    bare = html.unescape(text)
    said = say(bare)
    return text if said == bare else html.escape(said)


def markdown_said(text: str, say: Callable[[str], str]) -> str:
    """Markdown with its texts put through `say`."""
    return "".join(
        piece if _CUT.fullmatch(piece) else say(piece) for piece in _CUT.split(text) if piece
    )
