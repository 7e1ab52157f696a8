"""Piles that were emptied, kept in a folder: a study that was stopped goes on from there."""

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from workbench.app.emptying.changes import apply_change
from workbench.app.provenance.gathering import files_digest
from workbench.formats.files.json_keys import json_text, parse_object
from workbench.formats.files.whole_files import MB, make_folder, read_whole, write_whole
from workbench.model.digest import canonical
from workbench.model.errors import FileError
from workbench.model.messages.catalogue import message_of
from workbench.model.messages.message import Message
from workbench.model.prediction import EmptiedPile, LeftPart, PileTask
from workbench.plugins.progress import Report
from workbench.studies.cases import run_cases
from workbench.studies.emptying.piles import cell_of, empty_pile

MOST_BYTES = 10 * MB
"""[bytes] No pile needs as much."""


def emptied_all(
    tasks: Sequence[PileTask],
    *,
    folder: Path | None,
    workers: int,
    scheduler: str | None,
    report: Report,
) -> list[EmptiedPile]:
    """All piles emptied, in the order of the tasks; see `run_cases`.

    Args:
        tasks: of the piles.
        folder: where each pile is kept as soon as it is done, and searched for first; None for
            nowhere.
        workers: see there.
        scheduler: see there.
        report: see there.

    Raises:
        FileError: the folder cannot be made, or what is in it cannot be read.
        InputError: as `run_cases`.
    """
    if folder is None:
        return run_cases(empty_pile, tasks, workers=workers, scheduler=scheduler, report=report)
    make_folder(folder)
    known = {task: scene for task in tasks if (scene := _read(folder, task)) is not None}
    rest = [task for task in tasks if task not in known]

    def keep(task: PileTask, scene: EmptiedPile) -> None:
        known[task] = scene
        path = _path(folder, task)
        write_whole(path, json_text(path, _content(scene)))

    if rest:
        run_cases(empty_pile, rest, workers=workers, scheduler=scheduler, report=report, keep=keep)
    return [known[task] for task in tasks]


def _path(folder: Path, task: PileTask) -> Path:
    """The file of a pile: another cell, part, seed or program has another one."""
    said = repr(
        (
            canonical(task),
            _digest(task.cell, task.part, task.change, task.recipe, task.bin),
            _program(),
        )
    )
    return folder / f"{hashlib.sha256(said.encode()).hexdigest()[:24]}.json"


@cache
def _program() -> str:
    """The program's own files: a version alone stays the same while they are worked on."""
    return files_digest()


@lru_cache(maxsize=256)
def _digest(cell: str, part: str, change: Message | None, recipe: int, bin: str) -> str:
    return apply_change(cell_of(cell, part, recipe, bin), change).digest


def _read(folder: Path, task: PileTask) -> EmptiedPile | None:
    """The pile as it was kept; None where it was not."""
    path = _path(folder, task)
    if not path.exists():
        return None
    content = parse_object(path, read_whole(path, MOST_BYTES))
    try:
        return _scene(task, content)
    except (TypeError, KeyError, ValueError):
        raise FileError(
            path, "is no pile that was kept; delete it to empty that one again"
        ) from None


def _content(scene: EmptiedPile) -> dict[str, Any]:
    plain = asdict(replace(scene, task=replace(scene.task, change=None), left=()))
    return {**plain, "task": canonical(scene.task), "left": canonical(scene.left)}


def _scene(task: PileTask, content: dict[str, Any]) -> EmptiedPile:
    if content.pop("task") != canonical(task):
        raise ValueError
    left = tuple(
        LeftPart(reason=message_of(fields.pop("reason")), **fields)
        for fields in content.pop("left")
    )
    stages = tuple((str(name), float(seconds)) for name, seconds in content.pop("stages"))
    beside = tuple((float(moves), float(took)) for moves, took in content.pop("beside"))
    lists = {key: tuple(content.pop(key)) for key in ("failed", "planning", "outcomes")}
    kits = content.pop("kits")
    lists |= {} if kits is None else {"kits": tuple(kits)}
    return EmptiedPile(task=task, left=left, stages=stages, beside=beside, **lists, **content)
