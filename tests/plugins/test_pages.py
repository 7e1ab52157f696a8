"""The pages about plug-ins, followed literally: their code, their tests, their cell files."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from workbench.formats.cells.reading import cell_path, read_cell

HERE = Path(__file__).resolve().parent
PAGES = HERE.parents[1] / "docs" / "plugins"
ADD = sorted(page.name for page in PAGES.glob("add_*.md"))
PATIENCE = 1200


def files_of(page: Path) -> dict[str, str]:
    """The files that a page shows, by their paths."""
    return dict(re.findall(r"^`([\w/.]+)`:\n\n```\w+\n(.*?)^```$", page.read_text(), re.S | re.M))


def snippets_of(page: Path) -> list[str]:
    """What it shows of cell files."""
    return re.findall(r"```toml\n(.*?)```", page.read_text(), re.S)


def test_there_are_pages_for_every_seam():
    assert {"add_a_scanner.md", "add_a_robot_link.md", "add_a_planner.md"} < set(ADD)
    index = (PAGES / "index.md").read_text()
    assert all(f"]({name})" in index for name in ADD)


@pytest.mark.parametrize("name", ["index.md", *ADD])
def test_the_files_on_a_page_are_those_of_the_example(name):
    shown = files_of(PAGES / name)
    assert shown
    for path, content in shown.items():
        assert content == (HERE / "acme" / path).read_text(), f"{path} on {name}"


def test_a_part_of_a_file_is_in_that_of_the_example():
    text = (PAGES / "add_a_robot_link.md").read_text()
    ((path, part),) = re.findall(
        r"^Part of `([\w/.]+)`:\n\n```python\n(.*?)^```$", text, re.S | re.M
    )
    assert part in (HERE / "acme" / path).read_text()


@pytest.mark.timeout(PATIENCE)
@pytest.mark.parametrize("name", ADD)
def test_the_tests_on_a_page_pass_where_its_package_is_installed(name, acme_folder, tmp_path):
    tests = {path: text for path, text in files_of(PAGES / name).items() if "test_" in path}
    assert tests
    for path, content in tests.items():
        (tmp_path / path).write_text(content)
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(acme_folder), str(HERE.parents[1])])},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert f"{len(tests)} passed" in ended.stdout


@pytest.mark.parametrize("name", ADD)
def test_the_cell_files_on_a_page_are_read(name, acme, tmp_path):
    shipped = cell_path("yumi")
    for other in shipped.parent.iterdir():
        if other.name != "cell.toml":
            (tmp_path / other.name).symlink_to(other)
    text = shipped.read_text()
    for snippet in snippets_of(PAGES / name):
        for table in re.split(r"^(?=\[)", snippet, flags=re.M):
            text = merged(text, table) if table.strip() else text
    (tmp_path / "cell.toml").write_text(text)
    cell = read_cell(tmp_path)
    options = (cell.scanner.options, cell.controller.options, cell.localizer.options)
    assert any(options) or cell.policy.planner == "acme-vias" or "pincer" in text


def merged(text: str, table: str) -> str:
    """A cell file with a table's keys in place of those it has."""
    head, *lines = table.strip().splitlines()
    if head == "[[tool]]":
        return text.replace("[[tool]]", f"{table.strip()}\n\n[[tool]]", 1)
    if head not in text:
        where = "[[tool]]\n" if head == "[tool.options]" else None
        if where is None:
            return f"{text}\n{table}"
        name = text.index('kind = "acme-pincer"')
        return f"{text[:name]}options = {{ {lines[0]} }}\n{text[name:]}"
    before, after = text.split(f"{head}\n", 1)
    body, *rest = re.split(r"^(?=\[)", after, maxsplit=1, flags=re.M)
    keys = {line.partition(" ")[0] for line in lines}
    kept = [line for line in body.splitlines() if line.partition(" ")[0] not in keys]
    return "\n".join([before.rstrip("\n"), head, *lines, *kept, *rest])
