"""What is wrong with a robot file and need not end its reading."""

from pathlib import Path

from workbench.formats.meshes.reading import MESH_ENDINGS
from workbench.model.errors import FileError


class Remarks:
    """Collects faults that are passed over, each with what is done instead.

    Where it is strict it raises them: a cell that is used has to say what it means.
    """

    def __init__(self, *, is_strict: bool = True):
        self._is_strict = is_strict
        self._faults: dict[str, list[str]] = {}

    @property
    def is_strict(self) -> bool:
        """Whether nothing is passed over."""
        return self._is_strict

    def pass_over(self, error: FileError, instead: str) -> None:
        """Keep a fault, and what is done about it.

        Raises:
            FileError: it is strict.
        """
        if self._is_strict:
            raise error
        self._faults.setdefault(instead, []).append(_problem(error))

    def add(self, sentence: str, what: str = "") -> None:
        """Keep something that is no fault, and what it is about."""
        self._faults.setdefault(sentence, []).append(what)

    @property
    def sentences(self) -> tuple[str, ...]:
        """One for each kind of fault; of several alike the first is reported, and how many more."""
        return tuple(_sentence(instead, what) for instead, what in self._faults.items())


def _problem(error: FileError) -> str:
    """What is wrong; a mesh's own fault is reported with the name of its file."""
    file = Path(error.path)
    return (
        f"{file.name} {error.problem}"
        if file.suffix.lower() in MESH_ENDINGS
        else str(error.problem)
    )


def _sentence(instead: str, what: list[str]) -> str:
    distinct = list(dict.fromkeys(filter(None, what)))
    if not distinct:
        return instead
    more = f" (and {len(distinct) - 1} more)" if len(distinct) > 1 else ""
    return f"{distinct[0]}{more}: {instead}"
