"""Counts names that a reader cannot understand alone: `python tests/count_names.py [folder...]`.

- functions whose first word is a participle, `brought_ahead`, and functions and variables that have
  no other word: `told`, `placed`;
- bindings of the variable `one`;
- class names that stand in several modules;
- functions, variables and classes with the words `told`, `tell` or `tells`.

`--list` prints each name with its place instead of the counts.
"""

import argparse
import ast
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]

IRREGULAR = frozenset(
    """
    begun bent borne bought bound brought built caught chosen cut done drawn driven felt found
    given gone got grown heard held hung kept known laid led left lent let lit lost made meant
    met paid put read said seen sent set shown sought spent split stood struck swept taken
    taught thought thrown told tried turned understood won worn woven written
    """.split()  # noqa: SIM905
)
NO_PARTICIPLES = frozenset({"embed", "exceed", "feed", "need", "proceed", "seed", "shed", "speed"})
COMMANDS = frozenset({"cut", "let", "put", "read", "set", "split"})
"""Participles that are imperatives as well: `read_part` is a verb and an object."""


class Binding(NamedTuple):
    """A name and the place that binds it."""

    name: str
    kind: str
    place: str


def is_participle(name: str) -> bool:
    """Whether the first word of a name is a past participle, and no imperative."""
    word = name.strip("_").lower().split("_")[0]
    if word in IRREGULAR:
        return word not in COMMANDS
    return len(word) > 3 and word.endswith("ed") and word not in NO_PARTICIPLES


def bindings(path: Path) -> Iterator[Binding]:
    """Every name that a file binds: functions, properties, classes, variables and parameters."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        name = kind = ""
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                marks = {ast.unparse(mark).split(".")[-1] for mark in node.decorator_list}
                is_property = bool(marks & {"property", "cached_property"})
                name, kind = node.name, "property" if is_property else "function"
            case ast.ClassDef():
                name, kind = node.name, "class"
            case ast.Name(ctx=ast.Store()):
                name, kind = node.id, "variable"
            case ast.arg():
                name, kind = node.arg, "variable"
            case _:
                continue
        yield Binding(name, kind, f"{path}:{node.lineno}")


def names_by_heading(folders: list[Path]) -> dict[str, list[Binding]]:
    """Headings and the names below each, in the order of files."""
    every = [b for top in folders for path in sorted(top.rglob("*.py")) for b in bindings(path)]
    modules = defaultdict[str, list[Binding]](list)
    for binding in every:
        if binding.kind == "class":
            modules[binding.name].append(binding)
    return {
        "functions named by a participle": [
            b for b in every if b.kind == "function" and is_participle(b.name)
        ],
        "functions named by a participle alone": [
            b
            for b in every
            if b.kind == "function" and is_participle(b.name) and "_" not in b.name.strip("_")
        ],
        "properties named by a participle": [
            b for b in every if b.kind == "property" and is_participle(b.name)
        ],
        "variables named by a participle alone": [
            b
            for b in every
            if b.kind == "variable" and is_participle(b.name) and "_" not in b.name.strip("_")
        ],
        "variables named one": [b for b in every if b.kind == "variable" and b.name == "one"],
        "class names with several meanings": [
            same[0] for same in modules.values() if len({b.place for b in same}) > 1
        ],
        "names with told or tell": [
            b for b in every if {"told", "tell", "tells"} & set(b.name.lower().split("_"))
        ],
    }


def main() -> None:
    """Prints the counts, or the names themselves."""
    parser = argparse.ArgumentParser(description="Counts names that do not explain themselves.")
    parser.add_argument("folders", nargs="*", type=Path, default=[ROOT / "workbench"])
    parser.add_argument("--list", action="store_true", help="print the names and their places")
    asked = parser.parse_args()
    for heading, found in names_by_heading(asked.folders).items():
        print(f"{len(found):6} {heading}")
        if asked.list:
            for binding in found:
                print(f"       {binding.place}: {binding.name}")


if __name__ == "__main__":
    main()
