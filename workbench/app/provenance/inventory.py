"""What a session ran with, as a value: it is recorded at every start and told apart from others."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from workbench.model.digest import digest_of
from workbench.model.geometry import put


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
    """All that a result may depend on beside its input.

    `workbench` is the version and `files` the SHA-256 of its own files; `processor` is the model
    with what it can do, `system` kernel and C library.  `parts` (name -> digest) and
    `calibration`, the digest of where the scanner hangs, are in `cell_digest` too, so that a
    change is reported by its name.  `users` (name -> role) are those who may come in.
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


def differences(old: Inventory, new: Inventory) -> tuple[str, ...]:
    """What is otherwise in `new`, one phrase each; empty when nothing is."""
    return tuple(_differences(old, new))


def _differences(old: Inventory, new: Inventory) -> Iterator[str]:
    if old.workbench != new.workbench:
        yield f"workbench {old.workbench} is {new.workbench} now"
    elif old.files != new.files:
        yield f"the files of workbench {new.workbench} are others"
    before, now = _versions(old), _versions(new)
    yield from _compare(before, now)
    records = {distribution.name: distribution.record for distribution in old.distributions}
    for distribution in new.distributions:
        if (
            before.get(distribution.name) == distribution.version
            and records[distribution.name] != distribution.record
        ):
            yield f"the files of {distribution.name} {distribution.version} are others"
    for name in ("python", "processor", "system", "cell"):
        was, has = getattr(old, name), getattr(new, name)
        if was != has:
            yield f"{name} {was} is {has} now"
    parts = sorted(
        name for name in {*old.parts, *new.parts} if old.parts.get(name) != new.parts.get(name)
    )
    if parts:
        yield f"of the cell {', '.join(f'part {name}' for name in parts)} differ"
    if old.calibration != new.calibration:
        yield "the scanner's pose differs"
    if not parts and old.calibration == new.calibration and old.cell_digest != new.cell_digest:
        yield "the cell differs"
    yield from _people(old.users, new.users)


def _versions(inventory: Inventory) -> Mapping[str, str]:
    return {distribution.name: distribution.version for distribution in inventory.distributions}


def _people(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    """Who may come in now, or may not any more, or in another role; both are name -> role."""
    return _list_changes(
        old, new, "new user {name} ({has})", "user {name} ({was}) is gone",
        "user {name} is {has} now, was {was}",
    )  # fmt: skip


def _compare(old: Mapping[str, str], new: Mapping[str, str]) -> Iterator[str]:
    """What came, went or changed in a mapping from names to something short."""
    return _list_changes(
        old, new, "{name} {has} has come", "{name} {was} has gone", "{name} {was} is {has} now"
    )


def _list_changes(
    old: Mapping[str, str], new: Mapping[str, str], come: str, gone: str, other: str
) -> Iterator[str]:
    """A sentence for each name whose value `was` and `has` differ, by three templates."""
    for name in sorted({*old, *new}):
        was, has = old.get(name), new.get(name)
        if was != has:
            template = come if was is None else gone if has is None else other
            yield template.format(name=name, was=was, has=has)
