"""Who asks: the one place that turns a cookie or a token into a person."""

from dataclasses import dataclass

from aiohttp import web

from workbench.app.core.people import Person
from workbench.web.access.sessions import Session, Sessions
from workbench.web.access.users import Users

BEARER = "bearer "


@dataclass(frozen=True, slots=True)
class Access:
    """What is needed to tell who asks."""

    users: Users
    sessions: Sessions
    cookie: str
    """Name of the cookie."""


ACCESS = web.AppKey("access", Access)


def session_of(request: web.Request) -> Session | None:
    """The login of a browser, by its cookie."""
    access = request.config_dict[ACCESS]
    cookie = request.cookies.get(access.cookie)
    return None if cookie is None else access.sessions.find(cookie)


async def identify(request: web.Request) -> Person | None:
    """Who asks, by a token if the request shows one, otherwise by the cookie of a login.

    What a browser sends with a cookie has passed the check of its origin before it comes here
    (`guard.py`).  A token that is not valid is nobody's, whatever cookie comes with it.
    """
    if has_token(request):
        token = request.headers["Authorization"][len(BEARER) :].strip()
        return request.config_dict[ACCESS].users.by_token(token)
    session = session_of(request)
    return None if session is None else session.person


def has_token(request: web.Request) -> bool:
    """Whether a request shows a token, valid or not; pages of other sites cannot add one."""
    return request.headers.get("Authorization", "").casefold().startswith(BEARER)
