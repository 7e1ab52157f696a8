"""The description of the interface as one page of HTML for people: no script, no other file."""

from collections.abc import Mapping
from html import escape
from typing import Any

STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:56rem;margin:2rem auto;padding:0 1rem;color:#212529}"
    "h2{margin:2rem 0 .3rem;font-size:1rem}code{background:#f1f3f5;padding:.1rem .3rem}"
    "table{border-collapse:collapse}td,th{text-align:left;padding:.2rem .8rem .2rem 0;"
    "vertical-align:top;border-top:1px solid #dee2e6}"
)


def reference_html(description: Mapping[str, Any]) -> str:
    """The page.

    Args:
        description: after OpenAPI, as `openapi.openapi` makes it.
    """
    info, prefix = description["info"], description["servers"][0]["url"]
    parts = [
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{escape(info['title'])}</title>",
        f"<style>{STYLE}</style><h1>{escape(info['title'])} {escape(info['version'])}</h1>",
        f"<p>{escape(info['description'])} A token goes into the header "
        "<code>Authorization: Bearer ...</code>. The same for programs: "
        f'<a href="openapi.json">openapi.json</a>.</p>',
    ]
    for path, methods in description["paths"].items():
        for method, operation in methods.items():
            parts.append(_operation(method, prefix + path, operation))
    return "\n".join(parts)


def _operation(method: str, path: str, operation: Mapping[str, Any]) -> str:
    says = f"{operation['summary']} {operation.get('description', '')}".strip()
    answers = " ".join(f"<code>{status}</code>" for status in operation["responses"])
    return (
        f"<h2><code>{method.upper()} {escape(path)}</code></h2><p>{escape(says)}</p>"
        f"{_fields(operation)}<p>Answers: {answers}</p>"
    )


def _fields(operation: Mapping[str, Any]) -> str:
    if "requestBody" not in operation:
        return ""
    (content,) = operation["requestBody"]["content"].values()
    schema = content["schema"]
    rows = "".join(
        f"<tr><td><code>{escape(name)}</code></td><td>{escape(_kind(field))}</td>"
        f"<td>{escape(_default(field, name in schema['required']))}</td>"
        f"<td>{escape(field['description'])}</td></tr>"
        for name, field in schema["properties"].items()
    )
    return f"<table>{rows}</table>" if rows else ""


def _kind(field: Mapping[str, Any]) -> str:
    if "anyOf" in field:
        return " or ".join(map(_kind, field["anyOf"]))
    if "items" in field:
        return f"array of up to {field['maxItems']}: {_kind(field['items'])}"
    if "enum" in field:
        return " | ".join(field["enum"])
    if "minimum" in field:
        return f"{field['type']}, {field['minimum']} to {field['maximum']}"
    return str(field.get("pattern", field["type"]))


def _default(field: Mapping[str, Any], is_required: bool) -> str:
    if is_required:
        return "required"
    return f"default {field['default']}" if "default" in field else "as the cell has it"
