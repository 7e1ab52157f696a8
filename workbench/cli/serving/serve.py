"""`workbench serve`: the page of a cell, its session, and a robot to talk to."""

import socket
import time
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from pathlib import Path

from workbench.app.core.rights import changes_said
from workbench.app.provenance.gathering import inventory
from workbench.app.records.session_archive import open_journal
from workbench.app.records.sessions import cell_of, new_session
from workbench.app.records.starts import start, start_before
from workbench.app.runtime.anchors import Anchors, place
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.watch import CellWatch
from workbench.app.runtime.watch_poses import PosesWatch
from workbench.cli.arguments.serving import Serve
from workbench.cli.serving.front import front_options, serve_with_front, wait_for_the_end
from workbench.cli.serving.logs import begin_log
from workbench.cli.serving.open_session import look_at
from workbench.cli.serving.people import roles
from workbench.cli.serving.plc import serve_plc
from workbench.cli.serving.simulation import simulated_controller
from workbench.cli.terminal import progress
from workbench.formats.cells.predictions import predictions_path, read_predictions
from workbench.formats.cells.reading import cell_path, part_folders, read_cell
from workbench.journal.journal import Journal
from workbench.model.cell import Cell, Controller
from workbench.model.errors import InputError, JournalError
from workbench.plugins.addresses import is_loopback
from workbench.studies.stalls.watchdog import watch_stalls
from workbench.web.access.identity import identify
from workbench.web.api.routes import api_routes
from workbench.web.api.taking_along import taking_along
from workbench.web.robot_jobs import robot_jobs

SESSIONS = Path("sessions")

CONNECT_SECONDS = 0.5


def serve(typed: Serve) -> int:
    """Serve the page until SIGINT or SIGTERM."""
    options = front_options(typed)
    places = {anchor: place(anchor) for anchor in typed.anchor}
    begin_log(typed.log)
    cell, goes_on = read_cell(typed.cell), None
    if typed.session is not None:
        if typed.after is not None:
            raise InputError("--session goes on with a session, --after begins another: say one")
        goes_on = open_journal(typed.session)
        try:
            goes_on.claim(time.time())
        except JournalError as error:
            print(f"{error}; this page only looks at what was recorded until now")
            return look_at(goes_on, typed)
        cell = _begun_with(goes_on, cell.name)
    predictions = read_predictions(predictions_path(typed.cell))
    with ExitStack() as stack:
        stack.enter_context(watch_stalls(typed.stalls))
        robot = f"robot controller: {_address(cell.controller)}"
        if is_loopback(cell.controller.host) and not _answers(cell.controller):
            simulated = simulated_controller(typed.cell, cell.controller)
            cell = replace(cell, controller=stack.enter_context(simulated))
            robot = f"robot controller: simulated, {_address(cell.controller)}"
        journal = goes_on or _begin(cell, typed.after)
        path = cell_path(typed.cell)
        # Asked before this session has a start of its own, which would be the last one then.
        before = start_before(journal.folder.parent, cell.name)
        started = start(inventory(cell, roles(typed.users)), before)
        effects = partial(EffectRunner, cell_file=path)
        bench = Bench(cell, journal, effects=effects, start=started)
        if bench.state.changed:
            print(changes_said(bench.state))
        stack.callback(bench.close)
        stack.callback(CellWatch(path, bench).close)
        stack.callback(PosesWatch(bench).close)
        stack.callback(Anchors(bench, places, time.time).close)
        stack.enter_context(serve_plc("opcua", bench, typed))
        stack.enter_context(serve_plc("modbus", bench, typed))
        stack.enter_context(robot_jobs(bench))
        page = serve_with_front(
            bench,
            typed.users,
            options,
            predictions=predictions,
            folders=part_folders(path),
            routes=[*api_routes(bench, identify), *taking_along(journal.folder, Path.cwd())],
        )
        front = stack.enter_context(page)
        # Comes first at the end: an address of anchors that does not answer holds the rest up.
        stack.callback(bench.stop_sending)
        link = f"Workbench, cell {cell.name}: {front.link}"
        wait_for_the_end(link, robot, f"session: {journal.folder}")
    return 0


def _begun_with(journal: Journal, name: str) -> Cell:
    """The cell that a whole session of cell `name` began with.

    Raises:
        JournalError: the session was changed after it was written.
        InputError: it is of another cell.
    """
    with progress("session") as report:
        report(0.0, "looking whether it was changed")
        problems = journal.verify()
    if problems:
        more = f" ({len(problems) - 1} more by `workbench session verify`)" if problems[1:] else ""
        raise JournalError(
            f"{journal.folder}: {problems[0]}{more}; nothing is added to a session that was "
            "changed: --after instead of --session begins another that names it"
        )
    cell = cell_of(journal)
    if cell.name != name:
        raise InputError(f"{journal.folder}: is of cell {cell.name}, not of {name}; see --cell")
    return cell


def _begin(cell: Cell, after: Path | None) -> Journal:
    """A new session; its first entry names the one that it comes `after`."""
    if after is None:
        return new_session(SESSIONS, cell, time.time())
    with closing(open_journal(after)) as before:
        return new_session(SESSIONS, cell, time.time(), after=before)


def _answers(controller: Controller) -> bool:
    """Whether a controller reports its state there; its motion port is left alone."""
    try:
        with socket.create_connection((controller.host, controller.state_port), CONNECT_SECONDS):
            return True
    except OSError:
        return False


def _address(controller: Controller) -> str:
    return f"{controller.host}:{controller.port}"
