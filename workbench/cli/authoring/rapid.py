"""`workbench rapid`: modules in RAPID."""

import sys
from collections.abc import Sequence
from typing import Any

from workbench.cli.arguments.rapid import RapidCommands
from workbench.cli.exits import BAD_INPUT, NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json
from workbench.formats.rapid.backups.files import ENCODED
from workbench.formats.rapid.check import Checked, Name, check
from workbench.formats.rapid.merging import Merged, merge
from workbench.formats.rapid.problems import (
    LEFT_OUT,
    REMARK,
    UNKNOWN_NAME,
    UNREADABLE,
    WRONG,
    Problem,
)
from workbench.model.errors import InputError


def rapid(typed: RapidCommands) -> int:
    """Check modules; one line for each mistake, and for each name that is not known or executed."""
    if not typed.paths:
        raise InputError("which modules? a folder, as a backup or robots/yumi/rapid, or files")
    checked = check(typed.paths, typed.signal)
    merged = merge(typed.paths, typed.beside) if typed.beside is not None else None
    if typed.json:
        print_json(_form(checked, merged))
    else:
        _print_findings(checked)
        if merged is not None:
            _print_merged(merged)
    if checked.of(UNREADABLE):
        return BAD_INPUT
    is_right = not checked.of(WRONG) and not (merged and merged.clashes)
    return SUCCESS if is_right else NO_PLAN


def _print_findings(checked: Checked) -> None:
    unreadable, wrong, remarks = (checked.of(kind) for kind in (UNREADABLE, WRONG, REMARK))
    unknown, left_out = checked.names(UNKNOWN_NAME), checked.names(LEFT_OUT)
    for problem in unreadable:
        print(f"workbench: {problem}", file=sys.stderr)
    _list("wrong", wrong)
    _list("not known here", [_line(name) for name in unknown])
    _list("known, not executed here", [_line(name) for name in left_out])
    _list("remarks", remarks)
    modules = _count(len({path for _, paths in checked.tasks for path in paths}), "module")
    print(
        f"{modules} in {_count(len(checked.tasks), 'task')}: {len(wrong)} wrong, "
        f"{len(unknown)} not known here, {len(left_out)} known and not executed here"
    )
    if checked.spare:
        modules = _count(len(checked.spare), "module")
        print(f"not checked, since no task loads them: {modules}, such as {checked.spare[0]}")
    if not (unreadable or wrong):
        print("nothing is wrong with them")


def _count(number: int, word: str) -> str:
    return f"{number} {word}" + ("s" if number != 1 else "")


def _list(title: str, rows: Sequence[Problem | str]) -> None:
    if rows:
        print(f"{title}:")
    for row in rows:
        print(f"  {row}")


def _line(name: Name) -> str:
    if name.use == ENCODED:
        return f"{name.first.module}: {ENCODED}"
    uses = _count(name.uses, "use")
    as_what = f", {name.use}" if name.use else ""
    where = f"{name.first.module}:{name.first.line}"
    there = ""
    if name.elsewhere:
        more = f" and {len(name.elsewhere) - 1} more" if len(name.elsewhere) > 1 else ""
        there = f"; declared in {name.elsewhere[0]}{more}, not in this task"
    return f"{name.name}{as_what}: {uses}, first in {where}{there}"


def _print_merged(merged: Merged) -> None:
    _list("both declare", merged.clashes)
    _list("both use", merged.shared)
    _list("to be done", merged.steps)


def _form(checked: Checked, merged: Merged | None) -> dict[str, Any]:
    clashes = merged.clashes if merged is not None else []
    form: dict[str, Any] = {
        "ok": not (checked.of(WRONG) or checked.of(UNREADABLE) or clashes),
        "unreadable": _places(checked.of(UNREADABLE)),
        "wrong": _places(checked.of(WRONG)),
        "not_known": [_name(name) for name in checked.names(UNKNOWN_NAME)],
        "not_executed": [_name(name) for name in checked.names(LEFT_OUT)],
        "remarks": _places(checked.of(REMARK)),
        "not_loaded": checked.spare,
        "tasks": [{"task": name, "modules": paths} for name, paths in checked.tasks],
    }
    if merged is not None:
        form["beside"] = {
            "clashes": _places(merged.clashes),
            "shared": merged.shared,
            "steps": merged.steps,
        }
    return form


def _places(problems: Sequence[Problem]) -> list[dict[str, Any]]:
    keys = ("module", "line", "column", "what")
    return [{key: getattr(problem, key) for key in keys} for problem in problems]


def _name(name: Name) -> dict[str, Any]:
    return {
        "name": name.name,
        "used_as": name.use,
        "uses": name.uses,
        "module": name.first.module,
        "line": name.first.line,
        "declared_in": list(name.elsewhere),
    }
