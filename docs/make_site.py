"""The documents as a site to be read in a browser: `make docs`, or `python docs/make_site.py`.

The documents are gathered in the same folders as in the repository, so that a link between two of
them leads to the same place here and there, and nothing has to be rewritten.  Three pages are made:
the public interface, the examples with what they print, and the list of messages.
"""

import ast
import contextlib
import io
import os
import re
import runpy
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from make_messages import messages

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
GATHERED = (
    "*.md",
    "CITATION.cff",
    "docs/**/*.md",
    "docs/pictures/*",
    "docs/site.css",
    "robots/*/rapid*/README.md",
    "sessions/README.md",
    "tests/plugins/acme/acme_cell/robot_link.py",
    "tests/plugins/makers/*_*.py",
)
"""What is taken over as it is; a link to anything else fails the build."""

ELSEWHERE = re.compile(r"https://(unpkg\.com|api\.github\.com)/[\w@./-]*")
"""What the theme's script would fetch for diagrams, old browsers and counts of stars."""

SECTIONS: Mapping[str, Callable[[str], bool]] = {
    "Functions": lambda name: name[0].islower(),
    "Values": lambda name: name[0].isupper() and not _is_error(name),
    "Errors": lambda name: _is_error(name),
}


def build(site: Path, sources: Path, outputs: Mapping[str, str]) -> None:
    """Gather the documents, make the three pages, and the site from all of them.

    Args:
        site: the folder of the site, replaced.
        sources: a folder for what is gathered, replaced.
        outputs: what each example prints, by its name.
    """
    shutil.rmtree(sources, ignore_errors=True)
    for pattern in GATHERED:
        for file in ROOT.glob(pattern):
            copy = sources / file.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, copy)
    (sources / "reference.md").write_text(reference(), encoding="utf-8")
    (sources / "gallery.md").write_text(gallery(outputs), encoding="utf-8")
    (sources / "messages.md").write_text(messages(), encoding="utf-8")
    config = sources.with_suffix(".yml")
    config.write_text(
        (ROOT / "docs" / "mkdocs.yml").read_text(encoding="utf-8")
        + f"\ndocs_dir: {sources}\nsite_dir: {site}\n",
        encoding="utf-8",
    )
    # From the root, so that the interface is read from here, wherever the sources are gathered.
    mkdocs = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-f", str(config)]
    quiet = {"NO_MKDOCS_2_WARNING": "1"}  # the theme's notice about its successor
    subprocess.run(mkdocs, cwd=ROOT, env=os.environ | quiet, check=True)
    for script in site.rglob("*.js"):
        text = script.read_text(encoding="utf-8")
        script.write_text(ELSEWHERE.sub("", text), encoding="utf-8")


def reference() -> str:
    """The page of the public interface: where each name lies, for mkdocstrings to describe."""
    tree = ast.parse((ROOT / "workbench" / "api.py").read_text(encoding="utf-8"))
    homes = {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in tree.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    lines = ["# What `import workbench` offers", "", str(ast.get_docstring(tree)), ""]
    for title, belongs in SECTIONS.items():
        lines += [f"## {title}", ""]
        for name in _public(tree):
            if belongs(name):
                home = homes.get(name, f"workbench.api.{name}")
                lines += [f"::: {home}", "    options:", f"      heading: {name}", ""]
    return "\n".join(lines)


def _public(tree: ast.Module) -> list[str]:
    """The names in `__all__`."""
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return list(ast.literal_eval(node.value))
    raise ValueError("workbench/api.py has no __all__")


def _is_error(name: str) -> bool:
    return name.endswith("Error") or name == "CommandRefused"


def gallery(outputs: Mapping[str, str]) -> str:
    """The page of the examples: what each is about, its code, and what it prints."""
    lines = [
        "# Examples",
        "",
        "Each is a program in `examples/`; what it prints was printed when this page was made.",
    ]
    for example in EXAMPLES:
        code = example.read_text(encoding="utf-8")
        about = str(ast.get_docstring(ast.parse(code)))
        rest = code.partition('"""')[2].partition('"""')[2].strip()
        lines += ["", f"## {example.stem.replace('_', ' ').capitalize()}", "", about, ""]
        lines += [f'```python title="examples/{example.name}"', rest, "```", ""]
        lines += ["It prints:", "", "```text", outputs[example.stem].rstrip(), "```"]
    return "\n".join(lines) + "\n"


def printed(example: Path) -> str:
    """What an example prints; one that fails ends everything."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        runpy.run_path(str(example))
    return output.getvalue()


def main() -> None:
    """Run the examples, and make the site."""
    # In two processes that are used again, since importing takes longer than most examples.
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        outputs = dict(
            zip((one.stem for one in EXAMPLES), pool.map(printed, EXAMPLES), strict=True)
        )
    build(BUILD / "site", BUILD / "documents", outputs)
    print(f"{BUILD / 'site' / 'index.html'}: made; its search needs a server, for example")
    print("python -m http.server --directory build/site")


if __name__ == "__main__":
    main()
