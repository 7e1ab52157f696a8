"""Carries out effects, by the worker process and the threads of the robot link."""

import logging
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, assert_never

from workbench.app.core.cell.changes import CellRead
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.effects import (
    Effect,
    KeepDrafts,
    LetStep,
    RemoveDraft,
    Send,
    StartJob,
    StopJob,
    StopSending,
    UseCell,
    WriteCell,
)
from workbench.app.core.people import CELL_FILE, WORKER
from workbench.app.emptying.film import Filmed
from workbench.app.runtime.jobs import WORK, Jobs, internal_error
from workbench.app.runtime.live import Live
from workbench.app.runtime.record_retries import insist
from workbench.app.runtime.robot_link import Clock, Do, LinkRunner
from workbench.app.runtime.worker import GettingReady, Question
from workbench.formats.cells.differences import difference
from workbench.formats.cells.edits import (
    has_fewer_pose_views,
    log_change,
    save_cell,
    written_cell,
)
from workbench.formats.cells.reading import part_folders, read_cell
from workbench.formats.files.toml_keys import LARGEST_FILE
from workbench.formats.files.whole_files import read_whole
from workbench.formats.parts.reading import read_part
from workbench.formats.parts.saves import drop_draft, is_resized, save_part, write_draft
from workbench.model.cell import Cell
from workbench.model.errors import InputError, WorkbenchError
from workbench.model.messages.message import Message
from workbench.model.messages.work import JobText
from workbench.model.scan import LocalizationResult
from workbench.plugins.robot_link import USUAL, LinkPatience

log = logging.getLogger(__name__)


class EffectRunner:
    """The worker process and the robot of one bench.

    Lifetime: from construction until `close`, which first ends a sending and waits for the report
    of its end.

    Concurrency: `run`, `ask` and `live` return at once.  Jobs and sendings report from two
    threads, so that a stop never waits for a job.
    """

    def __init__(
        self,
        cell: Cell,
        do: Do,
        now: Clock,
        *,
        module: str = WORK,
        cell_file: Path | None = None,
        patience: LinkPatience = USUAL,
    ) -> None:
        """Start the worker and the robot link.

        Args:
            cell: the cell of the jobs and of the robot link.
            do: gives their reports to the bench.
            now: returns seconds since the epoch.
            module: the module of the worker's jobs.
            cell_file: file that changes of the cell are written to.
            patience: how long the robot link waits for the controller.
        """
        self._do = do
        self._now = now
        self._cell_file = cell_file
        # Whether the files hold half of the changes; only the thread of files uses it.
        self._is_half_saved = False
        self._lock = threading.Lock()
        # A thread of its own for files: a disk may be slow.
        self._files = ThreadPoolExecutor(1, "files")
        self._closing = threading.Event()
        self._live = Live()
        self._robot = LinkRunner(cell, do, now, self._show, patience=patience)
        self._jobs = Jobs(
            cell, self._job_ended, self._job_progressed, prepared=self._prepare, module=module
        )

    @property
    def live(self) -> Live:
        """Live data for display."""
        return self._live

    def run(self, effect: Effect) -> None:
        """Start an effect; its results go to `do`."""
        match effect:
            case StartJob(number=number, name=name, arguments=arguments):
                self._show(job=number, done=0.0, note="", started=self._now())
                # The folder of the parts decides nothing, so no entry records it.
                self._jobs.start(number, name, {**arguments, "cell_file": self._cell_file})
            case StopJob(number=number):
                self._jobs.cancel(number)
            case Send(plan=plan, approval=approval, following=following):
                self._robot.send(plan, approval, following)
            case LetStep(number=number):
                self._robot.let(number)
            case StopSending():
                self._robot.stop()
            case UseCell(cell=cell):
                self._jobs.use(cell)
                self._robot.use(cell)
            case WriteCell():
                self._show(is_saving=True)
                self._to_files(lambda: self._write_cell(effect))
            case KeepDrafts(parts=parts):
                self._drafts(
                    [part.name for part in parts],
                    lambda folders: [
                        write_draft(folders[part.name], part.library) for part in parts
                    ],
                )
            case RemoveDraft(part=part):
                self._drafts([part], lambda folders: drop_draft(folders[part]))
            case _:
                assert_never(effect)

    def ask(self, question: Question) -> None:
        """Have a question answered between jobs."""
        self._jobs.ask(question)

    def close(self) -> None:
        """End the sending first, then the worker; wait for both."""
        self._closing.set()
        self._robot.close()
        self._jobs.close()
        self._files.shutdown()

    def _drafts(self, parts: Sequence[str], change: Callable[[Mapping[str, Path]], object]) -> None:
        """Change drafts in the folders of parts; a failure is only logged."""
        if self._cell_file is None:
            return
        cell_file = self._cell_file

        def write() -> None:
            try:
                change(part_folders(cell_file, parts))
            except InputError as error:
                log.warning("a draft could not be changed: %s", error)

        self._to_files(write)

    def _to_files(self, work: Callable[[], None]) -> None:
        """Change files in the thread for them; a failure is only logged."""

        def work_and_log() -> None:
            try:
                work()
            except Exception:
                log.exception("files of the cell could not be changed")

        self._files.submit(work_and_log)

    def _write_cell(self, effect: WriteCell) -> None:
        try:
            cell, says = self._save(effect)
            command = CellRead(cell, is_saved=True, written=effect.cell.digest, says=says)
        except InputError as error:
            command = CellRead(problem=str(error))
        except Exception as error:
            log.exception("the cell could not be written")
            command = CellRead(problem=str(internal_error(error)))
        # A task may have begun meanwhile; the result of saving is reported after its end.
        insist(
            self._do,
            command,
            CELL_FILE,
            giving_up=self._closing,
            show_problem=self._show_unrecorded,
            is_waiting=True,
        )
        if not self._is_half_saved:
            self._show(is_saving=False)

    def _save(self, effect: WriteCell) -> tuple[Cell, Message]:
        """Write the cell and its parts; returns the cell read back from the files, and the changes.

        Raises:
            InputError: something cannot be written or read.
        """
        if self._cell_file is None:
            raise InputError(JobText.NO_CELL_FILE())
        known = None if self._is_half_saved else read_cell(self._cell_file)
        if known is not None and known.digest != effect.saved:
            raise InputError(JobText.FILES_CHANGED())
        folders = part_folders(self._cell_file, [part.name for part in effect.cell.parts])
        saved, before = list[Message](), read_whole(self._cell_file, LARGEST_FILE)
        filed = tuple(read_part(folders[part.name]) for part in effect.cell.parts)
        # Checked before anything is written: half a save would look like a change from outside.
        new = replace(effect.cell, parts=filed)
        written_cell(self._cell_file, new)
        self._is_half_saved = True
        for old, part in zip(filed, effect.cell.parts, strict=True):
            version = save_part(
                folders[part.name],
                old,
                part,
                actor=effect.actor,
                at=effect.at,
                remark=effect.remark,
            )
            if is_resized(old, part):
                saved.append(JobText.SIZE(part=part.name))
            if version is not None:
                saved.append(JobText.GRASPS(part=part.name, version=version))
        save_cell(self._cell_file, effect.cell)
        after = read_whole(self._cell_file, LARGEST_FILE)
        if not saved or after != before:
            saved.append(_changes_of(self._cell_file, known, new))
        if has_fewer_pose_views(before, after):
            saved.append(JobText.VIEWS_BY_JOINTS())
        log_change(self._cell_file, effect.cell, effect.actor, effect.at, effect.remark)
        cell = read_cell(self._cell_file)
        self._is_half_saved = False
        return cell, JobText.SAVED(things=saved)

    def _show(self, **changes: Any) -> None:
        if joints := changes.get("joints"):
            changes |= {"last_joints": joints, "reported_at": self._now()}
        with self._lock:
            self._live = replace(self._live, **changes)

    def _prepare(self, what: GettingReady | None) -> None:
        # A job that has waited for the worker starts now, and so does its clock.
        began = {} if what is not None else {"started": self._now()}
        self._show(getting_ready=what, **began)

    def _job_progressed(self, number: int, done: float, note: Message | str) -> None:
        if number == self._live.job:
            self._show(done=done, note=note)

    def _job_ended(self, number: int, result: Any) -> None:
        if isinstance(result, LocalizationResult):
            self._show(findings=result)
            result = result.detections
        if isinstance(result, Filmed):
            self._show(films=result)
            result = result.emptying
        try:
            self._insist(JobEnded(number, result))
        except Exception as error:
            # For instance a result without canonical form: the task must end all the same.
            log.exception("the result of task %d cannot be taken", number)
            self._insist(JobEnded(number, WorkbenchError(internal_error(error))))

    def _insist(self, ended: JobEnded) -> None:
        insist(self._do, ended, WORKER, giving_up=self._closing, show_problem=self._show_unrecorded)

    def _show_unrecorded(self, problem: Message | None) -> None:
        self._show(unrecorded=problem)


def _changes_of(file: Path, known: Cell | None, new: Cell) -> Message:
    """The cell file that was written, and the changes; `known` is its content before, or None."""
    if known is None:
        return JobText.THE_CELL()
    name = f"{file.parent.name}/{file.name}"
    return JobText.CELL_FILE(file=name, changes=difference(known, new))
