"""What others publish, brought through the documented commands: what a user reads, and the time.

`make foreign` prints it as a table.
"""

import os
import resource
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
DATA = HERE.parents[2] / "shared" / "data" / "foreign"

PATIENCE = 300
"""[s] For one command."""

PLACES = ("session: ", "written to ")
"""How lines begin that say where results lie."""

WIDEST = 110
"""Letters of a sentence in the table."""


@dataclass(frozen=True, slots=True)
class Brought:
    """One file, and what has to come of it (`corpus.toml` says what each is)."""

    kind: str
    name: str
    file: str
    ends: tuple[int, ...]
    options: tuple[str, ...] = ()
    says: str = ""
    is_slow: bool = False


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of it: `ends` of the commands that ran, a `sentence`, processor `seconds`."""

    brought: Brought
    ends: tuple[int, ...]
    said: str
    sentence: str
    seconds: float

    @property
    def is_as_wanted(self) -> bool:
        """Whether the commands ended and spoke as they have to."""
        wanted = self.brought.ends[: len(self.ends)] == self.ends
        return wanted and self.brought.says in self.said


def corpus() -> list[Brought]:
    """Everything that is brought."""
    rows = tomllib.loads((HERE / "corpus.toml").read_text())["brought"]
    return [
        Brought(**{k: tuple(v) if isinstance(v, list) else v for k, v in row.items()})
        for row in rows
    ]


def bring(one: Brought, folder: Path, data: Path = DATA, *, demo: bool = True) -> Outcome:
    """Run the commands for one file in an empty folder, until one of them fails."""
    ends: list[int] = []
    said, sentence, before = "", "", _seconds()
    for words in _commands(one, folder, data, demo):
        ran = subprocess.run(
            [sys.executable, "-m", "workbench", *words],
            cwd=folder,
            env={**os.environ, "COLUMNS": "200"},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        ends.append(ran.returncode)
        said = ran.stdout + ran.stderr
        sentence = _sentence(ran.stderr if ran.returncode else ran.stdout)
        if ran.returncode:
            break
    return Outcome(one, tuple(ends), said, sentence, _seconds() - before)


def _commands(one: Brought, folder: Path, data: Path, demo: bool) -> Iterator[list[str]]:
    file, options = str(data / one.file), list(one.options)
    match one.kind:
        case "robot":
            cell = folder / "cell"
            yield ["cell", "new", "cell", "--urdf", file, "--out", str(cell), *options]
            yield ["cell", "check", str(cell / "cell.toml")]
            if demo:
                yield ["demo", "--cell", str(cell / "cell.toml"), "--sessions", str(folder)]
        case "part":
            yield ["part", "import", file, "--name", "brought", "--into", str(folder), *options]
        case _:
            yield ["rapid", "check", file]


def _sentence(said: str) -> str:
    """The last line that says more than where something lies, with the names of files alone."""
    lines = [line.strip("│ ") for line in said.splitlines()]
    lines = [line for line in lines if line and not line.startswith(PLACES) and line[0].isalnum()]
    if not lines:
        return ""
    line = lines[-1].removeprefix("workbench: ")
    line = " ".join(
        word.rsplit("/", 1)[-1] if word.startswith("/") else word for word in line.split()
    )
    return line if len(line) <= WIDEST else line[: WIDEST - 3] + "..."


def _seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """Print the table; 1 where something is not as wanted."""
    if not DATA.is_dir():
        print(f"there is no {DATA}")
        return 2
    print("| what | commands end with | as wanted | what is said | processor |")
    print("|---|---|---|---|---|")
    bad = 0
    for one in corpus():
        with tempfile.TemporaryDirectory() as folder:
            out = bring(one, Path(folder))
        bad += not out.is_as_wanted
        ends = ", ".join(map(str, out.ends))
        wanted = "yes" if out.is_as_wanted else "**no**"
        sentence = out.sentence.replace("|", "/")
        print(f"| {one.name} | {ends} | {wanted} | {sentence} | {out.seconds:.1f} s |", flush=True)
    print(f"\n{len(corpus()) - bad} of {len(corpus())} as wanted.")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
