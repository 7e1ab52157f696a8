"""The page around the scene, and what it asks about itself."""

from aiohttp import web

from workbench import __version__
from workbench.model.messages.message import Message
from workbench.web.access.identity import ACCESS, session_of
from workbench.web.page.languages import language_of
from workbench.web.page.pages import Pages
from workbench.words.words import words_of


class Shell:
    """The frame that says who is logged in and lets them out.

    Concurrency: immutable.
    """

    def __init__(self, pages: Pages, title: Message | str):
        """A shell with this title."""
        self._pages = pages
        self._title = title

    async def page(self, request: web.Request) -> web.StreamResponse:
        """The page, or the way to the login."""
        session = session_of(request)
        if session is not None:
            person, words = session.person, words_of(language_of(request))
            role = person.role.value
            return self._pages.page(
                request,
                "shell.html",
                title=words.render(self._title),
                user=person.name,
                role=role,
                role_said=words.say(role),
                returns=str(request.config_dict[ACCESS].users.are_there()).lower(),
            )
        # A strict cookie does not come along on the way from another site, but it does on the
        # next step from here.
        if request.headers.get("Sec-Fetch-Site") == "cross-site":
            return self._pages.page(request, "onward.html")
        raise web.HTTPSeeOther("/login")

    async def who(self, request: web.Request) -> web.StreamResponse:
        """Who is logged in, for the script of the page when it comes back."""
        session = session_of(request)
        if session is None:
            return web.json_response({"name": None}, status=401)
        return web.json_response({"name": session.person.name, "role": session.person.role.value})

    async def health(self, request: web.Request) -> web.StreamResponse:
        """That we are there, for anybody, and nothing else."""
        return web.json_response({"ok": True, "version": __version__})
