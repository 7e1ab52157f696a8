"""The manual as a page, without a network: `docs/operator.md` and `docs/setting_up.md`.

Pictures and the other documents do not come along, so what leads to them stays as text.
"""

import re
from itertools import pairwise

from markdown_it import MarkdownIt

from workbench.formats.files.shipped import find

FILES = ("operator.md", "setting_up.md")
"""For people at the cell, and for engineers: one page here."""


def read_manual() -> str:
    """The manual as HTML, its headings named as links have them.

    Raises:
        FileError: it is missing.
    """
    return manual_html("\n".join(find("docs", name).read_text(encoding="utf-8") for name in FILES))


def manual_html(text: str) -> str:
    """A document in Markdown as HTML; what is HTML in it stays text.

    Args:
        text: of the document.
    """
    text = re.sub(r"^!\[[^\]]*\]\([^)]*\)\n*", "", text, flags=re.MULTILINE)
    text = re.sub(rf"\]\((?:{'|'.join(map(re.escape, FILES))})#", "](#", text)
    text = re.sub(r"\[([^\]]*)\]\((?!#)[^)]*\)", r"\1", text)
    made = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = made.parse(text)
    for token, content in pairwise(tokens):
        if token.type == "heading_open":
            token.attrSet("id", anchor(content.content))
    return made.renderer.render(tokens, made.options, {})


def anchor(heading: str) -> str:
    """The name by which links know a heading: `Stop, faults` is `stop-faults`."""
    return re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-")
