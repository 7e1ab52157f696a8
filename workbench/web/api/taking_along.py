"""What an engineer takes along from the page: the session for whoever helps, and a backup.

Restoring is done on the page itself (`gui/statistics/restoring.py`), or by `workbench restore`.
"""

import asyncio
import logging
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from functools import partial
from http import HTTPStatus
from logging.handlers import RotatingFileHandler
from pathlib import Path

from aiohttp import hdrs, web

from workbench.app.core.people import Role
from workbench.app.records.case_folder import case_files
from workbench.app.records.keeping import WITHOUT_SESSIONS, write_backup
from workbench.app.records.session_archive import export_session, open_journal
from workbench.model.errors import WorkbenchError
from workbench.web.access.identity import identify
from workbench.web.api.problems import problem, problem_of
from workbench.web.http.long_answers import send_pieces

CHUNK = 2**18
"""[bytes] Sent at once."""


def taking_along(session: Path, root: Path) -> list[web.RouteDef]:
    """The routes `/session.zip`, `/backup.zip` and `/cases/...`, for engineers.

    Args:
        session: the folder of the session that goes on.
        root: the working directory, with cells and parts.
    """
    # One at a time: a session can be large, and its file stands on the disk meanwhile.
    threads = ThreadPoolExecutor(1, thread_name_prefix="taking along")
    made = {
        "/session.zip": (f"{session.name}.zip", partial(_session, session)),
        "/backup.zip": ("workbench-backup.zip", partial(_backup, root)),
    }
    return [
        *(
            web.get(path, partial(_give, threads, name, make))
            for path, (name, make) in made.items()
        ),
        web.get("/cases/{name}", partial(_give_case, session)),
    ]


async def _give(
    threads: ThreadPoolExecutor, name: str, make: Callable[[Path], None], request: web.Request
) -> web.StreamResponse:
    """A file that is made for this request, and gone afterwards."""
    if (refusal := await _refuse(request)) is not None:
        return refusal
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / name
        try:
            await asyncio.get_running_loop().run_in_executor(threads, make, file)
        except WorkbenchError as error:
            return problem_of(error)
        return await _send(request, file)


async def _give_case(session: Path, request: web.Request) -> web.StreamResponse:
    """A case that was kept in the session."""
    if (refusal := await _refuse(request)) is not None:
        return refusal
    name = request.match_info["name"]
    try:
        file = next((path for path in case_files(session) if path.name == name), None)
    except WorkbenchError as error:
        return problem_of(error)
    if file is None:
        return problem(HTTPStatus.NOT_FOUND, "no case of this name is kept in this session")
    return await _send(request, file)


async def _refuse(request: web.Request) -> web.Response | None:
    """Why nothing is given to who asks; None when it is."""
    person = await identify(request)
    if person is None:
        return problem(HTTPStatus.UNAUTHORIZED, "log in first")
    if not person.role.covers(Role.ENGINEER):
        said = f"this file is for engineers; you are {person.role.said()}"
        return problem(HTTPStatus.FORBIDDEN, said)
    return None


async def _send(request: web.Request, file: Path) -> web.StreamResponse:
    """The content of a zip file, called as it is."""
    response = web.StreamResponse(
        headers={
            hdrs.CONTENT_TYPE: "application/zip",
            hdrs.CONTENT_DISPOSITION: f'attachment; filename="{file.name}"',
            hdrs.CACHE_CONTROL: "no-store",
        }
    )
    response.content_length = file.stat().st_size
    with file.open("rb") as content:
        return await send_pieces(request, response, iter(partial(content.read, CHUNK), b""))


def _session(folder: Path, file: Path) -> None:
    with closing(open_journal(folder)) as journal:
        export_session(journal, file, None, _log_file())


def _backup(root: Path, file: Path) -> None:
    write_backup(root, file, WITHOUT_SESSIONS, {})


def _log_file() -> Path | None:
    """Where the server writes its log, if it writes one."""
    handlers = logging.getLogger().handlers
    files = (
        Path(handler.baseFilename)
        for handler in handlers
        if isinstance(handler, RotatingFileHandler)
    )
    return next((file for file in files if file.is_file()), None)
