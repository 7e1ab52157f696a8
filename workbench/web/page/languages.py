"""In which language somebody has the page: kept with the user, or with the browser of nobody."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping

from aiohttp import hdrs, web

from workbench.app.core.people import NOBODY
from workbench.web.access.identity import ACCESS, session_of
from workbench.words.choosing import find_language, first_guess

COOKIE = "workbench-language"
"""Name of the cookie; one for all workbenches on a machine, since it is nobody's secret."""

KEPT_SECONDS = 365 * 24 * 3600

Form = Callable[[web.Request], Awaitable[Mapping[str, object]]]
"""Reads what was filled in, as strictly as the login does."""


def language_of(request: web.Request) -> str:
    """The language of who asks: the user's, or the browser's, or what that likes best."""
    session = session_of(request)
    if session is not None and session.person.name != NOBODY:
        kept = find_language(request.config_dict[ACCESS].users.language(session.person.name))
        if kept:
            return kept
    chosen = find_language(request.cookies.get(COOKIE, ""))
    return chosen or first_guess(request.headers.get(hdrs.ACCEPT_LANGUAGE, ""))


def choice(read: Form) -> Callable[[web.Request], Awaitable[web.StreamResponse]]:
    """The request by which a language is chosen, on the page or before the login."""

    async def choose(request: web.Request) -> web.StreamResponse:
        language = find_language(str((await read(request)).get("language", "")))
        if not language:
            raise web.HTTPBadRequest(text="There is no such language.\n")
        session = session_of(request)
        if session is not None and session.person.name != NOBODY:
            users = request.config_dict[ACCESS].users
            await asyncio.to_thread(users.keep_language, session.person.name, language)
        answer = web.Response(
            status=303, headers={hdrs.LOCATION: "/login" if session is None else "/"}
        )
        answer.set_cookie(
            COOKIE,
            language,
            max_age=KEPT_SECONDS,
            path="/",
            httponly=True,
            samesite="Strict",
            secure=request.secure,
        )
        return answer

    return choose
