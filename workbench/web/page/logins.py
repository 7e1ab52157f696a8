"""Coming in and going out: the login page, the first link, and logging out."""

import asyncio
import math
from collections.abc import Awaitable, Callable

from aiohttp import hdrs, web

from workbench.app.core.people import Person
from workbench.model.messages.message import Message
from workbench.web.access.first_key import FirstKey
from workbench.web.access.identity import ACCESS, session_of
from workbench.web.access.lockout import REMEMBERED, LockedOut, Lockout
from workbench.web.access.users import LONGEST_NAME
from workbench.web.http.refusals import log_refusal
from workbench.web.page.connections import Connections
from workbench.web.page.languages import language_of
from workbench.web.page.pages import Pages
from workbench.web.texts import BarText
from workbench.words.words import words_of

MOST_FORM = 4096
"""Bytes of a filled in form."""

FORM_SECONDS = 10.0
"""[s] How long a browser may take to send it."""

AT_ONCE = 2
"""Passwords that are tried at the same time; each takes 64 MiB and 0.1 s of a processor."""

MOST_WAITING = 20
"""Passwords that may wait to be tried."""

WRONG = "Name or password is wrong."
NO_USERS = (
    "There are no users yet. Open the link that the workbench printed when it was started. It "
    "works once, for one browser; a new start prints another. For more browsers and people add "
    "users: workbench user add NAME --role engineer. The first user ends the login by link: "
    "from then on everybody logs in here, by name and password."
)
USED = (
    "This link has been used, or belongs to an earlier start. It works once, for one browser; a "
    "new start prints another. For more browsers and people add users: workbench user add NAME "
    "--role engineer. The first user ends the login by link: from then on everybody logs in "
    "here, by name and password."
)

Ahead = Callable[[], Awaitable[str]]
"""Addresses of what a browser will need, see `Relay.ahead`."""


class Logins:
    """The requests about logging in.

    Concurrency: the front's event loop only; passwords are tried in threads.
    """

    def __init__(
        self,
        pages: Pages,
        lockout: Lockout,
        first: FirstKey,
        connections: Connections,
        title: Message | str,
        ahead: Ahead,
    ):
        """Made by `serve_front`; `title` stands above the form, `ahead` is fetched meanwhile."""
        self._pages = pages
        self._lockout = lockout
        self._first = first
        self._connections = connections
        self._title = title
        self._ahead = ahead
        self._trying = asyncio.Semaphore(AT_ONCE)
        self._waiting = 0

    async def form(self, request: web.Request) -> web.StreamResponse:
        """The login page."""
        if session_of(request) is not None:
            raise web.HTTPSeeOther("/")
        has_users = request.config_dict[ACCESS].users.are_there()
        pieces = await self._ahead()
        return self._form(request, 200, "" if has_users else NO_USERS, pieces=pieces)

    async def login(self, request: web.Request) -> web.StreamResponse:
        """A form that was filled in."""
        form = await read_form(request)
        name, password = str(form.get("name", "")), str(form.get("password", ""))
        shown = name[:LONGEST_NAME]
        if self._waiting >= MOST_WAITING:
            log_refusal("login", why="too many at once", origin=request.remote, who=shown)
            return self._form(request, 503, "Too many are logging in. Try again.", shown)
        self._waiting += 1
        try:
            async with self._trying:
                found = await asyncio.to_thread(self._try, request, name, password)
        finally:
            self._waiting -= 1
        if isinstance(found, LockedOut):
            log_refusal("login", why="too many failed", origin=request.remote, who=shown)
            minutes = math.ceil(found.seconds / 60)
            text = BarText.LOCKED_OUT(minutes=minutes)
            answer = self._form(request, 429, text, shown)
            answer.headers[hdrs.RETRY_AFTER] = str(math.ceil(found.seconds))
            return answer
        if found is None:
            log_refusal("login", why="wrong name or password", origin=request.remote, who=shown)
            return self._form(request, 401, WRONG, shown)
        answer = web.Response(status=303, headers={hdrs.LOCATION: "/"})
        await self._begin(request, answer, found)
        shown = request.cookies.get(_known_cookie(request), "")
        known = await asyncio.to_thread(self._lockout.remember, found.name, shown)
        answer.set_cookie(
            _known_cookie(request),
            known,
            max_age=int(REMEMBERED),
            path="/login",
            httponly=True,
            samesite="Strict",
            secure=request.secure,
        )
        return answer

    async def by_link(self, request: web.Request) -> web.StreamResponse:
        """The link that was printed at the start."""
        access = request.config_dict[ACCESS]
        if not self._first.take(request.query.get("key", ""), request.remote):
            log_refusal("first link", why="used, wrong, or from elsewhere", origin=request.remote)
            return self._form(request, 401, USED if not access.users.are_there() else "")
        answer = self._pages.page(request, "onward.html")
        await self._begin(request, answer, None)
        return answer

    async def logout(self, request: web.Request) -> web.StreamResponse:
        """The end of a login, in all windows of the browser."""
        session = session_of(request)
        if session is not None:
            await asyncio.to_thread(request.config_dict[ACCESS].sessions.end, session.digest)
            self._connections.cut(frozenset({session.digest}))
        answer = web.Response(status=303, headers={hdrs.LOCATION: "/login"})
        answer.del_cookie(request.config_dict[ACCESS].cookie, path="/")
        return answer

    def _try(self, request: web.Request, name: str, password: str) -> Person | LockedOut | None:
        """In a thread: whose name and password these are, unless nothing may be tried."""
        known = request.cookies.get(_known_cookie(request), "")
        attempt = self._lockout.begin(request.remote or "", name, known)
        if isinstance(attempt, LockedOut):
            return attempt
        person = request.config_dict[ACCESS].users.by_password(name, password)
        if person is not None:
            self._lockout.note_success(attempt)
        return person

    async def _begin(
        self, request: web.Request, answer: web.Response, person: Person | None
    ) -> None:
        """Give the browser a new login; one that it has is over, whoever's it was."""
        access, before = request.config_dict[ACCESS], session_of(request)
        if before is not None:
            await asyncio.to_thread(access.sessions.end, before.digest)
            self._connections.cut(frozenset({before.digest}))
        cookie = await asyncio.to_thread(access.sessions.begin, person)
        answer.set_cookie(
            access.cookie,
            cookie,
            max_age=int(access.sessions.seconds),
            path="/",
            httponly=True,
            samesite="Strict",
            secure=request.secure,
        )

    def _form(
        self,
        request: web.Request,
        status: int,
        problem: Message | str,
        name: str = "",
        pieces: str = "",
    ) -> web.Response:
        render = words_of(language_of(request)).render
        title, said = render(self._title), render(problem)
        values = {"title": title, "problem": said, "user": name, "pieces": pieces}
        return self._pages.page(request, "login.html", status, **values)


def _known_cookie(request: web.Request) -> str:
    """Name of the cookie of a browser in which somebody has logged in before."""
    return f"{request.config_dict[ACCESS].cookie}_known"


async def read_form(request: web.Request) -> dict[str, object]:
    """What was filled in.

    Raises:
        HTTPException: it is too long, takes too long, or is no form.
    """
    charset = (request.charset or "utf-8").casefold()
    if request.content_type != "application/x-www-form-urlencoded" or charset != "utf-8":
        raise web.HTTPUnsupportedMediaType
    if request.content_length is None or request.content_length > MOST_FORM:
        raise web.HTTPRequestEntityTooLarge(MOST_FORM, request.content_length or 0)
    try:
        async with asyncio.timeout(FORM_SECONDS):
            return dict(await request.post())
    except TimeoutError as error:
        raise web.HTTPRequestTimeout from error
    except UnicodeDecodeError as error:
        raise web.HTTPBadRequest(text="The form is not in UTF-8.\n") from error
