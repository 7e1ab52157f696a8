"""Refusals as programs read them: problem details after RFC 9457."""

import json
from collections.abc import Mapping
from http import HTTPStatus
from typing import Any

from aiohttp import web

from workbench.model.errors import CommandRefused, InputError, NotAllowed, WorkbenchError
from workbench.model.messages.message import Message, Others

PROBLEM = "application/problem+json"


def problem(
    status: HTTPStatus, detail: Message | str, *, headers: Mapping[str, str] | None = None
) -> web.Response:
    """A refusal.

    Args:
        status: of the answer; its phrase is the title.
        detail: a sentence for the client, which states what to do instead.  For a text with an id
            the answer has `said` as well, its id and arguments.
        headers: that the status wants beside.
    """
    content: dict[str, Any] = {
        "title": status.phrase,
        "status": status.value,
        "detail": str(detail),
    }
    if isinstance(detail, Message) and detail.text is not Others.PLAIN:
        content["said"] = detail.program_form
    return web.Response(
        body=json.dumps(content).encode(),
        status=status,
        content_type=PROBLEM,
        headers=headers,
    )


def problem_of(error: WorkbenchError) -> web.Response:
    """The refusal that an error is: a role's, the state's, or that of what was sent."""
    match error:
        case NotAllowed():
            status = HTTPStatus.FORBIDDEN
        case CommandRefused():
            status = HTTPStatus.CONFLICT
        case InputError():
            status = HTTPStatus.BAD_REQUEST
        case _:
            status = HTTPStatus.INTERNAL_SERVER_ERROR
    return problem(status, error.message)
