"""An MCAP file, written message by message: it is there wholly afterwards, or not at all."""

import contextlib
import json
from collections.abc import Generator, Mapping
from pathlib import Path
from typing import Any

from mcap.writer import Writer

from workbench.extras.mcap.foxglove import SCHEMAS, nanoseconds
from workbench.formats.files.whole_files import partial_of
from workbench.model.errors import FileError


class McapFile:
    """Messages by topic; channels and schemas are reported once, before their first message."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def describe(self, content: Mapping[str, str]) -> None:
        """A record of words that belong to the whole session."""
        self._writer.add_metadata("session", dict(content))

    def put(self, topic: str, schema: str, at: float, message: Mapping[str, Any]) -> None:
        """A message.

        Args:
            topic: always with the same schema.
            schema: one of `foxglove.SCHEMAS`.
            at: seconds since the epoch; need not grow.
            message: as the schema has it.
        """
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(topic, "json", self._id(schema))
        # NaN and infinity are no JSON: better no file than one that nobody reads.
        data = json.dumps(message, allow_nan=False).encode()
        when = nanoseconds(at)
        self._writer.add_message(self._channels[topic], when, data, when)

    def _id(self, schema: str) -> int:
        if schema not in self._schemas:
            text = json.dumps(SCHEMAS[schema]).encode()
            self._schemas[schema] = self._writer.register_schema(schema, "jsonschema", text)
        return self._schemas[schema]


@contextlib.contextmanager
def mcap_file(path: Path) -> Generator[McapFile]:
    """A file to put messages into; what was there is replaced when the block ends well.

    Raises:
        FileError: it cannot be written.
    """
    partial = partial_of(path)
    try:
        with partial.open("wb") as file:
            writer = Writer(file)
            writer.start(profile="", library="workbench")
            yield McapFile(writer)
            writer.finish()
        partial.replace(path)
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()
