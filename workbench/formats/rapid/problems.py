"""What is found in a RAPID program: before it runs, or while it does."""

from dataclasses import dataclass

from workbench.model.errors import InputError

WRONG, UNREADABLE, UNKNOWN_NAME = "wrong", "unreadable", "unknown"
LEFT_OUT, REMARK = "not executed", "remark"


@dataclass(frozen=True, slots=True, order=True)
class Problem:
    """One thing that was found in the text of a module; lines and columns count from 1.

    `kind` is `wrong`; `unreadable`: the file is no module, or ends in the middle of one; `unknown`:
    `name` is declared nowhere here; `not executed`: RobotWare has `name`, the interpreter does not;
    `remark`: a controller takes it, though it should not be so.
    """

    module: str
    line: int
    column: int
    what: str
    kind: str = WRONG
    name: str = ""

    def __str__(self) -> str:
        return f"{self.module}:{self.line}:{self.column}: {self.what}"


class Findings(list[Problem]):
    """Problems, each once; `uses` is what names are used as that are not known, by small name."""

    def __init__(self) -> None:
        super().__init__()
        self.uses: dict[str, str] = {}
        self._seen: set[Problem] = set()

    def add(self, problem: Problem) -> None:
        """Keep it, if it is new."""
        if problem not in self._seen:
            self._seen.add(problem)
            self.append(problem)

    def use(self, name: str, kind: str) -> None:
        """Remember what a name is used as; of several uses the one that says most."""
        if self.uses.get(name.lower(), "data") == "data":
            self.uses[name.lower()] = kind


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
