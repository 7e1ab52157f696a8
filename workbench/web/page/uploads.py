"""Counts the bytes of files that a browser sends through viser, which trusts the stated size."""

from dataclasses import dataclass

from workbench.web.page.messages import FileTransferPart, FileTransferStartUpload

MOST_BYTES = 50 * 1024 * 1024
"""Of one file."""

MOST_AT_ONCE = 2
"""Files of one browser."""

PART_BYTES = 512 * 1024
"""Of every part but the last, by viser's page (`UploadButton.tsx`)."""


@dataclass(frozen=True, slots=True)
class Broken:
    """Why no more may come from this browser."""

    why: str


@dataclass(slots=True)
class _Upload:
    widget: str
    size: int
    parts: int
    next: int = 0


class Uploads:
    """The files that one browser is sending.

    Parts have to come in their order, whole, and no more of them than were announced: so viser
    never holds more than `MOST_AT_ONCE * MOST_BYTES` for a browser.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        """No file yet; none may have more than `MOST_BYTES`."""
        self._files: dict[str, _Upload] = {}

    def begin(self, message: FileTransferStartUpload) -> Broken | None:
        """Take an announcement; what is wrong with it, if anything."""
        size, parts = message.size_bytes, message.part_count
        if size > MOST_BYTES:
            return Broken(f"a file of {size:,} bytes; at most {MOST_BYTES:,} may be sent")
        if parts != -(-size // PART_BYTES):
            return Broken(f"a file of {size:,} bytes does not come in {parts} parts")
        if message.transfer_uuid in self._files or len(self._files) >= MOST_AT_ONCE:
            return Broken(f"more than {MOST_AT_ONCE} files at once, or one of them twice")
        if parts:
            self._files[message.transfer_uuid] = _Upload(message.source_component_uuid, size, parts)
        return None

    def take(self, message: FileTransferPart) -> Broken | None:
        """Take a part; what is wrong with it, if anything."""
        file = self._files.get(message.transfer_uuid)
        if file is None or file.widget != message.source_component_uuid:
            return Broken("a part of a file that was not announced")
        if message.part_index != file.next:
            return Broken(f"part {message.part_index} of a file where part {file.next} is next")
        is_last = file.next + 1 == file.parts
        expected = file.size - file.next * PART_BYTES if is_last else PART_BYTES
        if len(message.content) != expected:
            return Broken(f"{len(message.content):,} bytes in a part that has {expected:,}")
        file.next += 1
        if is_last:
            del self._files[message.transfer_uuid]
        return None
