"""What is wrong with a RAPID program: found before it runs, or while it does."""

from dataclasses import dataclass

from workbench.model.errors import InputError


@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """One thing that is wrong with the text of a module; lines and columns count from 1."""

    module: str
    line: int
    column: int
    what: str

    def __str__(self) -> str:
        return f"{self.module}:{self.line}:{self.column}: {self.what}"


class BadModule(InputError):
    """A module cannot be read or loaded; `problems` has every reason."""

    def __init__(self, problems: list[Problem]) -> None:
        self.problems = problems
        more = f", and {len(problems) - 1} more" if len(problems) > 1 else ""
        super().__init__(f"{problems[0]}{more}")


class RapidError(Exception):
    """An execution error that an ERROR handler can take.

    `name` is that of a predefined one, or empty for a `number` that a program has raised.
    """

    def __init__(self, name: str, number: float = 0.0) -> None:
        self.name, self.number = name, number
        super().__init__(name or f"error {number:g}")


class RapidStop(Exception):
    """An execution error that nothing can take: the task stops and says why."""


class PointerMoved(BaseException):
    """The program pointer was taken out of the routine: only its UNDO handlers run."""
