"""The description of the interface, OpenAPI 3.1, made from the tables that the routes come from."""

from collections.abc import Mapping
from typing import Any

from workbench import __version__
from workbench.web.api import schemas
from workbench.web.api.calls import CALLS, Call
from workbench.web.api.events import STREAM
from workbench.web.api.fields import Field
from workbench.web.api.problems import PROBLEM
from workbench.web.api.resources import JSON, READS, Read

PREFIX = "/api/v1"

Description = dict[str, Any]

REFUSALS: Mapping[int, str] = {
    400: "what was sent cannot be used",
    401: "nobody has logged in",
    403: "it is for people of another role",
    404: "it is not there yet",
    408: "the body did not arrive in time",
    409: "not now: the sentence says what to do first",
    413: "the body is too long",
    415: "the body is not JSON",
    503: "too many listen already",
}


def openapi() -> Description:
    """The whole description."""
    paths: dict[str, Description] = {}
    for read in READS:
        paths.setdefault(read.path, {})["get"] = _read(read)
    for call in CALLS:
        paths.setdefault(call.path, {})["post"] = _call(call)
    paths["/me"] = {"get": _operation("me", "Who asks, and what they may do.", schemas.PERSON)}
    paths["/events"] = {"get": _events()}
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "Workbench",
            "version": __version__,
            "description": "The same commands and rights as on the page. SI units and radians.",
        },
        "servers": [{"url": PREFIX}],
        "paths": dict(sorted(paths.items())),
        "components": {
            "schemas": {"Problem": schemas.PROBLEM},
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
        "security": [{"token": []}],
    }


def _operation(
    name: str,
    says: str,
    schema: schemas.Schema,
    *,
    kind: str = JSON,
    refusals: tuple[int, ...] = (),
) -> Description:
    answers: Description = {
        "200": {"description": "as it is now", "content": {kind: {"schema": schema}}}
    }
    answers |= {str(status): _refusal(status) for status in (401, *refusals)}
    return {"operationId": name, "summary": says, "responses": answers}


def _read(read: Read) -> Description:
    refusals = (404,) if read.missing else ()
    name = f"get {read.path}"
    return _operation(name, read.says, read.schema, kind=read.kind, refusals=refusals)


def _events() -> Description:
    says = "Every new state as a server-sent event; the newest wins. Progress as events `job`."
    operation = _operation("get /events", says, {"type": "string"}, kind=STREAM, refusals=(503,))
    operation["x-event"] = {"state": schemas.STATE, "job": schemas.JOB}
    return operation


def _call(call: Call) -> Description:
    right = call.kind.right
    status = "202" if call.begins else "200"
    done = {
        "description": "begun; see /jobs/current" if call.begins else "done",
        "content": {JSON: {"schema": schemas.DONE}},
    }
    answers: Description = {status: done}
    answers |= {str(code): _refusal(code) for code in (400, 401, 403, 408, 409, 413, 415)}
    return {
        "operationId": f"post {call.path}",
        "summary": call.says,
        "description": f"For {right.role}s and above."
        + (" Also while somebody else is in control." if right.without_control else ""),
        "requestBody": {
            "required": any(field.is_required for field in call.fields),
            "content": {JSON: {"schema": _body_schema(call.fields)}},
        },
        "responses": answers,
    }


def _body_schema(fields: tuple[Field, ...]) -> schemas.Schema:
    """What a body may be."""
    return {
        "type": "object",
        "properties": {field.name: _field(field) for field in fields},
        "required": [field.name for field in fields if field.is_required],
        "additionalProperties": False,
    }


def _field(field: Field) -> Description:
    schema = {**field.schema, "description": field.says}
    if field.items is not None:
        several = {"type": "array", "items": field.items, "maxItems": field.most}
        schema = {"anyOf": [field.schema, several], "description": field.says}
    # None stands for what the cell says: it is left out, never sent.
    return (
        schema
        if field.is_required or field.default is None
        else {**schema, "default": field.default}
    )


def _refusal(status: int) -> Description:
    return {
        "description": REFUSALS[status],
        "content": {PROBLEM: {"schema": {"$ref": "#/components/schemas/Problem"}}},
    }
