"""Before anything else: is this meant for us, and does it come from a page of ours?"""

from aiohttp import hdrs, web
from aiohttp.typedefs import Handler, Middleware

from workbench.web.access.identity import has_token
from workbench.web.http.headers import ALWAYS
from workbench.web.http.origins import Origins
from workbench.web.http.refusals import log_refusal

ENCODINGS = frozenset({"identity", "gzip", "deflate"})
"""Of a body, one at a time."""

READING = frozenset({hdrs.METH_GET, hdrs.METH_HEAD})


def guard(origins: Origins) -> Middleware:
    """The middleware that checks Host and Origin of all requests.

    What shows a token instead of a cookie needs no origin: it comes from no browser.
    """

    @web.middleware
    async def check_request(request: web.Request, handler: Handler) -> web.StreamResponse:
        host, origin = request.headers.get(hdrs.HOST), request.headers.get(hdrs.ORIGIN)
        if not origins.is_known(host):
            log_refusal("host", why=f"asked for {host!r}", origin=request.remote)
            text = "This is not the name of a workbench; see --name of `workbench serve`.\n"
            raise web.HTTPMisdirectedRequest(text=text)
        is_socket = request.headers.get(hdrs.UPGRADE, "").casefold() == "websocket"
        may_change = is_socket or request.method not in READING
        if may_change and not has_token(request) and not origins.is_own(origin, host):
            log_refusal("origin", why=f"{origin!r} asked {host!r}", origin=request.remote)
            raise web.HTTPForbidden(text="This came from a page of another site.\n")
        said = request.headers.getall(hdrs.CONTENT_ENCODING, ["identity"])
        encoding = ", ".join(said).strip().casefold()
        if encoding not in ENCODINGS:
            log_refusal("body", why=f"encoded as {encoding!r}", origin=request.remote)
            known = {hdrs.ACCEPT_ENCODING: ", ".join(sorted(ENCODINGS))}
            text = "The body has an encoding that is not known here.\n"
            raise web.HTTPUnsupportedMediaType(text=text, headers=known)
        try:
            return await handler(request)
        except web.RequestPayloadError as error:
            log_refusal("body", why=str(error), origin=request.remote)
            raise web.HTTPBadRequest(text="The body is not encoded as its head says.\n") from error

    return check_request


async def strictly(request: web.Request, response: web.StreamResponse) -> None:
    """Put the headers on that every answer has; to be called before each is sent."""
    for name, value in ALWAYS.items():
        if name == "Server" or name not in response.headers:
            response.headers[name] = value
