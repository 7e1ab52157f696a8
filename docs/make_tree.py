"""The tree of layers and folders in `architecture.md`, made from the docstrings of the code.

`python docs/make_tree.py` writes it anew; a test says when that is due.
"""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
BEGIN, END = "<!-- tree: docs/make_tree.py -->\n", "<!-- end of tree -->"
WIDTH = 26


def tree() -> str:
    """A line for each layer, and for each folder in it: its subject, without the details."""
    lines: list[str] = []
    for layer in sorted((ROOT / "workbench").glob("*/__init__.py")):
        lines.append(_line(layer.parent, 0))
        lines += [_line(folder.parent, 1) for folder in sorted(layer.parent.glob("*/__init__.py"))]
    return "```\n" + "\n".join(lines) + "\n```\n"


def _line(folder: Path, depth: int) -> str:
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
    name = f"{'  ' * depth}{folder.name}/"
    # The table of layers on the page says what they are for.
    subject = re.split("[:;]", text.splitlines()[0].rstrip("."))[0] if depth else ""
    return f"{name:{WIDTH}}{subject}".rstrip()


def whole(page: str) -> str:
    """The page with the tree of now."""
    before, _, rest = page.partition(BEGIN)
    return before + BEGIN + tree() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(whole(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
