"""The tables of the OPC UA server in the documents are those of the code."""

from pathlib import Path

from workbench.web.opcua.methods import METHODS
from workbench.web.opcua.values import VARIABLES

PAGE = (Path(__file__).parents[3] / "docs" / "opcua.md").read_text(encoding="utf-8")


def variables() -> list[str]:
    return [f"| `{name}` | {kind.name} |" for name, kind in VARIABLES.items()]


def methods() -> list[str]:
    rows = []
    for method in METHODS:
        given = ", ".join(f"{one.name}: {one.kind.name}" for one in method.arguments)
        rows.append(f"| `{method.name}({given})` |")
    return rows


def test_every_variable_and_method_stands_there():
    stands = [line for line in PAGE.splitlines() if line.startswith("| `")]
    assert stands == [*variables(), *methods()]
