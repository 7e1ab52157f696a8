"""Inventory of what a session runs with, recorded at every start and compared with others."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from workbench.model.digest import digest_of
from workbench.model.geometry import put
from workbench.model.messages.cells import InventoryText
from workbench.model.messages.commands import RoleText
from workbench.model.messages.message import Message, Text


@dataclass(frozen=True, slots=True, eq=False)
class Distribution:
    """An installed Python distribution; `record` is the SHA-256 of its RECORD file.

    RECORD has the digests of all its files; `record` is empty where there is none.
    """

    name: str
    version: str
    record: str


@dataclass(frozen=True, slots=True, eq=False)
class Inventory:
    """Everything besides the input that a result may depend on.

    `workbench` is the version, `files` the SHA-256 of its own files.  `processor` is the model
    with its features, `system` the kernel and the C library.  `cell_digest` covers `parts` (name ->
    digest) and `calibration` (digest of the scanner's pose), too.  They stand here so that a change
    can be reported by its name.  `users` (name -> role) have access.
    """

    workbench: str
    files: str
    python: str
    processor: str
    system: str
    distributions: tuple[Distribution, ...]
    cell: str
    cell_digest: str
    parts: Mapping[str, str]
    calibration: str
    users: Mapping[str, str]
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(self, digest=digest_of(self))


def differences(old: Inventory, new: Inventory) -> tuple[Message, ...]:
    """What is otherwise in `new`, one phrase each; empty when nothing is."""
    return tuple(_differences(old, new))


def _differences(old: Inventory, new: Inventory) -> Iterator[Message]:
    if old.workbench != new.workbench:
        yield InventoryText.VERSION(name="workbench", was=old.workbench, has=new.workbench)
    elif old.files != new.files:
        yield InventoryText.FILES(name="workbench", version=new.workbench)
    before, now = _versions(old), _versions(new)
    yield from _compare(before, now)
    records = {distribution.name: distribution.record for distribution in old.distributions}
    for distribution in new.distributions:
        if (
            before.get(distribution.name) == distribution.version
            and records[distribution.name] != distribution.record
        ):
            yield InventoryText.FILES(name=distribution.name, version=distribution.version)
    for name in ("python", "processor", "system", "cell"):
        was, has = getattr(old, name), getattr(new, name)
        if was != has:
            yield InventoryText.VERSION(name=name, was=was, has=has)
    parts = sorted(
        name for name in {*old.parts, *new.parts} if old.parts.get(name) != new.parts.get(name)
    )
    if parts:
        yield InventoryText.PARTS(parts=parts)
    if old.calibration != new.calibration:
        yield InventoryText.CALIBRATION()
    if not parts and old.calibration == new.calibration and old.cell_digest != new.cell_digest:
        yield InventoryText.CELL()
    yield from _people(old.users, new.users)


def _versions(inventory: Inventory) -> Mapping[str, str]:
    return {distribution.name: distribution.version for distribution in inventory.distributions}


def _people(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[Message]:
    """Who may come in now, or may not any more, or in another role; both are name -> role."""
    before, now = ({name: _role(role) for name, role in users.items()} for users in (old, new))
    texts = (InventoryText.NEW_USER, InventoryText.USER_GONE, InventoryText.USER_ROLE)
    return _list_changes(before, now, *texts)


def _compare(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[Message]:
    """What came, went or changed in a mapping from names to something short."""
    texts = (InventoryText.ADDED, InventoryText.REMOVED, InventoryText.VERSION)
    return _list_changes(old, new, *texts)


def _role(role: str) -> Message | str:
    known = RoleText.__members__.get(role.upper())
    return role if known is None else known()


def _list_changes(
    old: Mapping[str, Message | str],
    new: Mapping[str, Message | str],
    come: Text,
    gone: Text,
    other: Text,
) -> Iterator[Message]:
    """A message for each name whose value differs, by three texts."""
    for name in sorted({*old, *new}):
        was, has = old.get(name), new.get(name)
        if was != has:
            text = come if was is None else gone if has is None else other
            given = {"name": name, "was": was, "has": has}
            yield text(**{place: given[place] or "" for place in text.places})
