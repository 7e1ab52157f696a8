"""`workbench serve`: the page of a cell, its session, and a robot to talk to."""

import logging
import signal
import socket
import threading
import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import FrameType

from workbench.app.records.session_archive import opened
from workbench.app.records.sessions import cell_of, new_session
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.watch import CellWatch
from workbench.app.runtime.watch_poses import PosesWatch
from workbench.cli.arguments import top as arguments
from workbench.cli.serving.fronted import front_options, fronted
from workbench.cli.serving.plc import plc
from workbench.cli.serving.simulation import simulated_controller
from workbench.formats.cells.predictions import predictions_path, read_predictions
from workbench.formats.cells.reading import cell_path, part_folders, read_cell
from workbench.model.cell import Controller
from workbench.model.errors import InputError
from workbench.web.access.identity import identify
from workbench.web.api.routes import api_routes
from workbench.web.http.origins import is_loopback

SESSIONS = Path("sessions")

CONNECT_SECONDS = 0.5


def serve(typed: arguments.Serve) -> int:
    """Serve the page until SIGINT or SIGTERM."""
    options = front_options(typed)
    logging.basicConfig(level=logging.WARNING, format="%(asctime)s %(name)s: %(message)s")
    cell, goes_on = read_cell(typed.cell), None
    if typed.session is not None:
        goes_on, name = opened(typed.session), cell.name
        cell = cell_of(goes_on)
        if cell.name != name:
            raise InputError(f"{typed.session}: is of cell {cell.name}, not of {name}; see --cell")
    predictions = read_predictions(predictions_path(typed.cell))
    with ExitStack() as stack:
        robot = f"robot controller: {_address(cell.controller)}"
        if is_loopback(cell.controller.host) and not _answers(cell.controller):
            simulated = simulated_controller(typed.cell, cell.controller)
            cell = replace(cell, controller=stack.enter_context(simulated))
            robot = f"robot controller: simulated, {_address(cell.controller)}"
        journal = goes_on or new_session(SESSIONS, cell, time.time())
        path = cell_path(typed.cell)
        bench = Bench(cell, journal, effects=partial(EffectRunner, cell_file=path))
        stack.callback(bench.close)
        # The file may have been changed since the session ended.
        stack.callback(CellWatch(path, bench, is_read=goes_on is None).close)
        stack.callback(PosesWatch(bench).close)
        stack.enter_context(plc(bench, typed))
        page = fronted(
            bench,
            typed.users,
            options,
            predictions=predictions,
            folders=part_folders(path),
            routes=api_routes(bench, identify),
        )
        front = stack.enter_context(page)
        print(f"Workbench, cell {cell.name}: {front.link}")
        print(robot)
        print(f"session: {journal.folder}", flush=True)
        wait_for_the_end()
    return 0


def wait_for_the_end() -> None:
    """Return at SIGINT or SIGTERM."""
    ended = threading.Event()

    def end(signum: int, frame: FrameType | None) -> None:
        ended.set()

    signal.signal(signal.SIGINT, end)
    signal.signal(signal.SIGTERM, end)
    ended.wait()


def _answers(controller: Controller) -> bool:
    """Whether a controller reports its state there; its motion port is left alone."""
    try:
        with socket.create_connection((controller.host, controller.state_port), CONNECT_SECONDS):
            return True
    except OSError:
        return False


def _address(controller: Controller) -> str:
    return f"{controller.host}:{controller.port}"
