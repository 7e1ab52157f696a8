"""The list of all messages, a page of the site, made from the texts of the code."""

from collections.abc import Iterator

from workbench.model.messages.catalogue import SUBJECTS
from workbench.model.messages.message import Others, Text

HEAD = """# Messages

A message to people has an id and arguments. Programs get it as `said`, and decide by id and
arguments, which stay; the English `text` may change with each version:

```json
{"id": "note.lifts-tried", "args": {"way": 0.012, "lifts": 4}, "text": "after 12 mm; 4 lifts tried"}
```

Lengths are in m, angles in rad, times in s, shares of 1. A part is `{"part": 0}`, its index in the
list of detections. A message within another one has `id` and `args` as well. Some texts, and
records of older versions, have an empty `id` and `text` alone.

Below, `{far:mm}` is the place of the argument `far`, shown in mm; `deg` shows angles, `s` times,
`%` shares, and a digit after them is the number of decimals. `{count:part|parts}` is a word for one
and one for several.

"""


def messages() -> str:
    """The whole page: a line for each message, a blank line between subjects."""
    blocks = ["\n".join(_lines(subject)) for subject in SUBJECTS if subject is not Others]
    return f"{HEAD}```text\n" + "\n\n".join(blocks) + "\n```\n"


def _lines(subject: type[Text]) -> Iterator[str]:
    return (f"{text.id}: {text.template}" for text in subject)
