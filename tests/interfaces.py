"""What others rely on, as plain facts: one fact lost breaks somebody's script, cell or plug-in.

A fact ends with `needed` where whoever uses it has to give that.
"""

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import workbench
from workbench.app.core.commands import COMMANDS
from workbench.app.records.record import SESSION_FORMAT
from workbench.cli import exits
from workbench.formats.cells.schema import cell_schema, grasp_schema, part_schema
from workbench.formats.plans.plan_files import plan_content
from workbench.model.plan import PLAN_FORMAT
from workbench.plugins.localizer import Localizer
from workbench.plugins.planner import Planner
from workbench.plugins.robot_link import RobotLink, SteppedLink
from workbench.plugins.scanner import Scanner
from workbench.plugins.tab import Tab
from workbench.plugins.tool import ToolKind
from workbench.web.api.openapi import openapi

FILE = Path(__file__).parent / "golden" / "interfaces.json"

HELP = Path(__file__).parent / "golden" / "help"

EXAMPLE = Path(__file__).resolve().parents[1] / "sessions" / "example"

SEAMS = (Scanner, RobotLink, SteppedLink, Planner, Localizer, ToolKind, Tab)

Facts = dict[str, list[str]]


def interfaces() -> Facts:
    """All facts by interface, in order."""
    found = {
        "cell files": _keys(cell_schema()),
        "part files": _keys(part_schema()),
        "grasp files": _keys(grasp_schema()),
        "plan files": _plan_keys(),
        "sessions": _commands(),
        "HTTP": _routes(openapi()),
        "Python": _names(),
        "plug-ins": _members(),
        "commands": _options(),
        "exit codes": (f"{name} {value}" for name, value in vars(exits).items() if name.isupper()),
    }
    return {name: sorted(set(facts)) for name, facts in found.items()}


def broken(before: Mapping[str, list[str]], now: Mapping[str, list[str]]) -> list[str]:
    """What somebody relies on and no longer finds, or has to give where he did not."""
    lost = [
        f"{name}: {fact}"
        for name, facts in before.items()
        for fact in facts
        if fact not in now.get(name, ())
    ]
    owners = {name: {_owner(fact) for fact in facts} for name, facts in before.items()}
    asked = [
        f"{name}: {fact}"
        for name, facts in now.items()
        for fact in facts
        if fact.endswith(" needed")
        and fact not in before.get(name, ())
        and _owner(fact) in owners.get(name, ())
    ]
    return lost + asked


def _owner(fact: str) -> str:
    """What a key, field or argument belongs to."""
    return re.split(r" takes | has |\.[^.]*$", fact)[0]


def _needed(name: str, required: bool) -> str:
    return f"{name} needed" if required else name


def _keys(schema: Mapping[str, Any], place: str = "") -> Iterator[str]:
    """The keys of a file, by a JSON schema."""
    for form in schema.get("anyOf", ()):
        yield from _keys(form, place)
    if "items" in schema:
        yield from _keys(schema["items"], f"{place}[]")
    for key, form in schema.get("properties", {}).items():
        name = f"{place}.{key}"
        yield _needed(name, key in schema.get("required", ()))
        yield from _keys(form, name)


def _plan_keys() -> Iterator[str]:
    """The keys of a plan file, as the plan of the recorded example has them."""
    yield f"format {PLAN_FORMAT}"
    session = workbench.open_session(EXAMPLE)
    try:
        *_, (_, state) = workbench.replay(session)
    finally:
        session.close()
    assert state.plan is not None
    yield from _content(json.loads(json.dumps(plan_content(state.plan, state.proof))), "")


def _content(value: object, place: str) -> Iterator[str]:
    if isinstance(value, dict):
        for key, held in value.items():
            yield f"{place}.{key}"
            yield from _content(held, f"{place}.{key}")
    elif isinstance(value, list):
        for held in value:
            yield from _content(held, f"{place}[]")


def _commands() -> Iterator[str]:
    """What sessions hold; every field of a command that is read again."""
    yield f"format {SESSION_FORMAT}"
    for kind in COMMANDS:
        yield kind.__name__
        yield from (f"{kind.__name__} has {field.name}" for field in fields(kind))


def _routes(description: Mapping[str, Any]) -> Iterator[str]:
    for path, operations in description["paths"].items():
        for method, operation in operations.items():
            name = f"{method} {path}"
            yield name
            for content in operation.get("requestBody", {}).get("content", {}).values():
                body = content["schema"]
                needed = body.get("required", ())
                yield from (
                    _needed(f"{name} takes {key}", key in needed) for key in body["properties"]
                )
            for status, answer in operation["responses"].items():
                for content in answer.get("content", {}).values() if status < "300" else ():
                    keys = content["schema"].get("properties", {})
                    yield from (f"{name} has {key}" for key in keys)


def _names() -> Iterator[str]:
    """What `import workbench` gives: functions with their arguments, values with their fields."""
    for name in workbench.api.__all__:
        thing = getattr(workbench, name)
        yield name
        if inspect.isfunction(thing):
            yield from _arguments(name, thing)
        elif is_dataclass(thing):
            yield from (f"{name} has {f.name}" for f in fields(thing) if f.name[0] != "_")


def _arguments(name: str, function: Any) -> Iterator[str]:
    for argument in inspect.signature(function).parameters.values():
        if argument.name != "self":
            is_needed = argument.default is argument.empty and argument.kind < argument.VAR_KEYWORD
            yield _needed(f"{name} takes {argument.name}", is_needed)


def _members() -> Iterator[str]:
    """What a plug-in of each seam has to have, and what it is called with."""
    for seam in SEAMS:
        names = {*vars(seam), *getattr(seam, "__annotations__", ())}
        for name in names:
            if name == "__init__" or name == "__call__" or not name.startswith("_"):
                yield f"{seam.__name__} has {name}"
                if inspect.isfunction(thing := vars(seam).get(name)):
                    yield from _arguments(f"{seam.__name__}.{name}", thing)


def _options() -> Iterator[str]:
    """The commands and their options, as their recorded help lists them."""
    for file in HELP.glob("*.txt"):
        name = file.stem.replace("-", " ")
        yield name
        for option in re.findall(r"^│ (--[a-z-]+)", file.read_text(encoding="utf-8"), re.M):
            yield f"{name} takes {option}"
