"""Robots as others describe them: which files are read, which arms are found, what is picked.

    python docs/make_robots.py FOLDER... [--pick WORD...]

prints a table in Markdown of every URDF file in the folders.  With `--pick` those whose path holds
a word become cells, as by `workbench cell new`, and pick from four piles of two parts.
"""

import argparse
import contextlib
import io
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import workbench
from workbench.cli.main import main as command
from workbench.formats.robots.descriptions import read_description
from workbench.model.errors import WorkbenchError
from workbench.studies.layout.arms import ends_of
from workbench.studies.layout.flanges import mounts_of

PILES = 4


def found(file: Path) -> tuple[str, str]:
    """How many links, and the links that carry tools; or why not."""
    try:
        said = read_description(file)
        robot = said.robot
    except WorkbenchError as error:
        return "", f"refused: {_short(error, file)}"
    try:
        ends = ends_of(robot, said.followers)
        return str(len(robot.links)), ", ".join(mounts_of(robot, ends).flanges)
    except WorkbenchError as error:
        return str(len(robot.links)), f"to be named: {_short(error, file)}"


def picked(file: Path) -> str:
    """In how many piles it picks, and the processor time of making the cell [s]."""
    with tempfile.TemporaryDirectory() as folder:
        place, began = Path(folder) / "cell", time.process_time()
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
            code = command(["cell", "new", "one", "--urdf", str(file), "--out", str(place)])
        if code:
            return f"no cell: {said.getvalue().strip().splitlines()[-1]}"
        took = time.process_time() - began
        cell = workbench.read_cell(place / "cell.toml")
        plans = 0
        for seed in range(PILES):
            parts = workbench.drop_parts(cell.parts[:1] * 2, cell.bin, seed=seed)
            plans += workbench.plan(cell, parts, seed=seed).plan is not None
        return f"{plans} of {PILES} piles, cell in {took:.0f} s"


def rows(folders: list[Path], words: list[str]) -> Iterator[str]:
    """The lines of the table."""
    yield "| file | links | arms, or why not |" + (" picks |" if words else "")
    yield "|---|---|---|" + ("---|" if words else "")
    for folder in folders:
        for file in sorted(folder.rglob("*.urdf")):
            name = file.relative_to(folder).as_posix().replace("|", "/")
            if words and not any(word in name for word in words):
                continue
            links, arms = found(file)
            line = f"| `{name}` | {links} | {arms} |"
            yield line + (f" {picked(file)} |" if words else "")


def _short(error: Exception, file: Path) -> str:
    text = str(error).replace(f"{file}: ", "")
    for above in reversed(file.parents):
        text = text.replace(f"{above}/", "")
    return text.replace("|", "/").partition("; name the links")[0]


if __name__ == "__main__":
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("folders", nargs="+", type=Path)
    reader.add_argument("--pick", nargs="*", default=[])
    typed = reader.parse_args()
    for row in rows(typed.folders, typed.pick):
        print(row, flush=True)
