"""The table of messages in `messages.md`, made from the texts of the code.

`python docs/make_messages.py` writes it anew; a test says when that is due.
"""

from collections.abc import Iterator
from pathlib import Path

from workbench.model.messages.catalogue import SUBJECTS
from workbench.model.messages.message import Others, Text

PAGE = Path(__file__).resolve().parents[1] / "docs" / "messages.md"

HEAD = """# Messages

What the workbench reports to people is a message: an id with arguments. Programs get it as `said`:

```json
{"id": "note.lifts-tried", "args": {"way": 0.012, "lifts": 4}, "text": "after 12 mm; 4 lifts tried"}
```

`text` is English and may change with each version; ids and arguments stay. Decide by them.
Lengths are in m, angles in rad, times in s, shares of 1. A part is `{"part": 0}`, its index in the
list of detections; a message within another one has `id` and `args` as well. Where `id` is empty,
`text` is all there is: not every text has an id yet, and records of older versions have none.

`{far:mm}` is the place of the argument `far`, a length that is shown in mm; `deg` shows angles,
`s` times, `%` shares, and a digit after them is the number of decimals. `{count:part|parts}` is a
word for one and one for several.
"""


def page() -> str:
    """The whole page: a row for each message; words of a closed set stand in one row."""
    rows = [row for subject in SUBJECTS if subject is not Others for row in _rows(subject)]
    head = "| id | English |\n|---|---|\n"
    return HEAD + "\n" + head + "\n".join(rows) + "\n"


def _rows(subject: type[Text]) -> Iterator[str]:
    words = [text for text in subject if not text.places]
    if 2 * len(words) > len(subject):
        ids = ", ".join(f"`{text.id}`" for text in words)
        yield f"| {ids} | {', '.join(text.template for text in words)} |"
    else:
        words = []
    for text in subject:
        if text not in words:
            english = text.template.replace("|", "&#124;")
            yield f"| `{text.id}` | {english} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
