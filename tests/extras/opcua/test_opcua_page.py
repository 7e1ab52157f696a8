"""The tables of the OPC UA server in the documents are those of the code."""

from pathlib import Path

from workbench.app.core.state import Phase
from workbench.extras.opcua.methods import METHODS
from workbench.extras.opcua.values import VARIABLES

PAGE = (Path(__file__).parents[3] / "docs" / "opcua.md").read_text(encoding="utf-8")


def variables() -> list[str]:
    return [f"- `{name}` ({kind.name}): " for name, kind in VARIABLES.items()]


def methods() -> list[str]:
    rows = []
    for method in METHODS:
        given = ", ".join(f"{one.name}: {one.kind.name}" for one in method.arguments)
        rows.append(f"- `{method.name}({given})`")
    return rows


def test_every_variable_and_method_stands_there():
    lists = PAGE.partition("## Variables")[2].partition("How they act:")[0]
    stands = [line for line in lists.splitlines() if line.startswith("- `")]
    told = [*variables(), *methods()]
    assert [line[: len(row)] for line, row in zip(stands, told, strict=True)] == told


def test_every_variable_has_a_meaning():
    rows = [line for line in PAGE.splitlines() if line.startswith(tuple(variables()))]
    assert rows and all(row.partition("): ")[2] for row in rows)


def test_every_phase_stands_at_its_variable():
    (row,) = (line for line in PAGE.splitlines() if line.startswith("- `Phase`"))
    assert {f"`{phase}`" for phase in Phase} <= set(row.replace(",", "").split())
