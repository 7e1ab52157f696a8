"""Only compiled functions take more parameters than `pyproject.toml` allows."""

import ast
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
RUFF = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]["lint"]
MOST, MOST_POSITIONAL = RUFF["pylint"]["max-args"], RUFF["pylint"]["max-positional-args"]


def excepted_files() -> set[Path]:
    files: set[Path] = set()
    for pattern, rules in RUFF["per-file-ignores"].items():
        if pattern.startswith("workbench/") and "PLR0913" in rules:
            folder, _, names = pattern.rpartition("/")
            if names == "**":
                files |= set((ROOT / folder).rglob("*.py"))
                continue
            for name in names.removesuffix(".py").strip("{}").split(","):
                files.add(ROOT / folder / f"{name}.py")
    return files


def long_functions(file: Path) -> set[str]:
    """Functions of a file that take more, but for those that Numba compiles."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.FunctionDef):
            continue
        if any("njit" in ast.unparse(mark) for mark in node.decorator_list):
            continue
        names = [arg.arg for arg in (*node.args.posonlyargs, *node.args.args)]
        positional = len(names) - (names[:1] in (["self"], ["cls"]))
        if positional > MOST_POSITIONAL or positional + len(node.args.kwonlyargs) > MOST:
            found.add(node.name)
    return found


def test_only_compiled_functions_of_excepted_files_take_more_parameters() -> None:
    files = excepted_files()
    assert files and all(file.exists() for file in files)
    assert not {(file, name) for file in files for name in long_functions(file)}
