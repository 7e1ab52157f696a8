"""What each answer asks the browser to be strict about."""

from collections.abc import Mapping

ALWAYS: Mapping[str, str] = {
    "Server": "workbench",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), geolocation=(), microphone=(), usb=()",
    "X-Frame-Options": "DENY",
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; frame-ancestors 'none'",
}
"""Headers of every answer, unless it says otherwise."""


def page_policy(sockets: str) -> Mapping[str, str]:
    """For our own pages: nothing but our own files; the scene in its frame.

    Args:
        sockets: where websockets may be opened to, as `ws://127.0.0.1:8080`.
    """
    policy = (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; font-src 'self'; "
        f"connect-src 'self' {sockets}; frame-src 'self'; form-action 'self'; "
        "base-uri 'none'; frame-ancestors 'none'"
    )
    return {"Content-Security-Policy": policy}


def scene_policy(sockets: str, pieces: str) -> Mapping[str, str]:
    """For viser's page, which talks to nobody else either.

    It consists of inline scripts, WebAssembly whose glue is compiled from strings, and a worker
    made from a blob; the HTML of our tables has handlers in it.

    Args:
        sockets: where websockets may be opened to.
        pieces: address under which the pieces of the page are, and nothing else.
    """
    policy = (
        "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; worker-src blob:; "
        "style-src 'unsafe-inline'; img-src data: blob:; font-src 'self' data:; "
        f"connect-src {sockets} {pieces} data: blob:; "
        "form-action 'none'; base-uri 'none'; frame-ancestors 'self'"
    )
    return {"Content-Security-Policy": policy, "X-Frame-Options": "SAMEORIGIN"}
