"""The table of the interface in the documents is that of the code."""

from pathlib import Path

from workbench.web.api.openapi import PREFIX, REFUSALS, openapi

PAGE = (Path(__file__).parents[3] / "docs" / "api.md").read_text(encoding="utf-8")


def rows() -> list[str]:
    """A line for each route, as the description has it."""
    found = []
    for path, methods in openapi()["paths"].items():
        for method, operation in methods.items():
            body = operation.get("requestBody", {}).get("content", {}).get("application/json", {})
            schema = body.get("schema", {"properties": {}, "required": []})
            names = (
                f"`{name}`" if name in schema["required"] else f"`{name}`?"
                for name in schema["properties"]
            )
            keys, says = ", ".join(names), operation["summary"]
            bracket = f" ({keys})" if keys else ""
            found.append(f"- `{method.upper()} {PREFIX}{path}`{bracket}: {says}")
    return found


def test_every_route_stands_there():
    stands = [line for line in PAGE.splitlines() if line.startswith(("- `GET", "- `POST"))]
    assert stands == rows()


def test_every_refusal_stands_there():
    for status in REFUSALS:
        assert f"{status}" in PAGE.partition("## Refusals")[2].partition("## Events")[0]
