"""Anchors: heads of a journal that were stored elsewhere, compared with it.

`verify.py` of evidence contains this file, so it imports nothing but Python's own.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


def anchor_problems(
    hashes: Mapping[int, str], session: str, anchors: Iterable[Any]
) -> Iterator[str]:
    """Where the journal is not the one whose heads were stored elsewhere.

    Args:
        hashes: of its entries, by number.
        session: its name.
        anchors: of any sessions, see `anchors_from`.
    """
    found = 0
    for anchor in anchors:
        if anchor["session"] != session:
            continue
        found += 1
        kept = hashes.get(anchor["number"])
        if kept is None:
            yield f"entry {anchor['number']} was kept elsewhere and is not in the journal"
        elif kept != anchor["hash"]:
            yield f"up to entry {anchor['number']} the journal is not the one kept elsewhere"
    if not found:
        yield f"no anchor of session {session} was kept elsewhere"


def anchors_from(text: str) -> tuple[list[Any], list[str]]:
    """Anchors, one JSON object a line, and remarks on torn lines; ValueError when they are none."""
    anchors: list[Any] = []
    remarks: list[str] = []
    for place, line in enumerate((text_line.strip() for text_line in text.splitlines()), 1):
        if line.startswith("{") and not line.endswith("}"):
            # Disk or power were gone while it was written; it was written again after that.
            remarks.append(f"line {place} of the anchors was not written to its end")
        elif line:
            anchor = json.loads(line)
            kinds = [type(anchor[name]) for name in ("session", "number", "hash") if name in anchor]
            if kinds != [str, int, str]:
                raise ValueError("session, number or hash is missing, or of another kind")
            anchors.append(anchor)
    return anchors, remarks
