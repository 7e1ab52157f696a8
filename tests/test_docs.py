"""What the documents say is there, and what is there stands in the documents."""

import ast
import dataclasses
import re
import shlex
import tomllib
import typing
from itertools import takewhile
from pathlib import Path

import pytest

import workbench
from workbench.app.core import commands
from workbench.app.core.state import Phase
from workbench.cli.arguments import top as arguments
from workbench.cli.main import parse
from workbench.model.candidate import Reason

ROOT = Path(__file__).resolve().parents[1]
COMMANDS = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
ARCHITECTURE = "".join(
    (ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("architecture.md", "inside.md")
)
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted((ROOT / "docs").rglob("*.md")),
    ROOT / "sessions" / "README.md",
    *(ROOT / "robots" / "yumi" / name / "README.md" for name in ("rapid", "rapid_egm")),
]
PICTURES = ROOT / "docs" / "pictures"
every_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def links_of(page: Path) -> list[str]:
    found = re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8"))
    return [link for link in found if "://" not in link]


def blocks_of(page: Path) -> list[tuple[str, str]]:
    """Language and content of every block of code."""
    text = page.read_text(encoding="utf-8")
    assert text.count("```") % 2 == 0
    return re.findall(r"^```(\w*)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def prose_of(page: Path) -> str:
    """What stands outside of the blocks, lines joined as they are when shown."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    return " ".join(text.split())


@every_page
def test_every_link_leads_somewhere(page):
    for link in links_of(page):
        path, _, heading = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        if heading:
            titles = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            plain = [
                re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-") for title in titles
            ]
            assert heading in plain, link


def test_every_picture_is_used_and_small():
    used = {(page.parent / link).resolve() for page in PAGES for link in links_of(page)}
    for picture in PICTURES.iterdir():
        assert picture.resolve() in used, picture.name
        assert picture.stat().st_size < (1_500_000 if picture.stem == "play" else 250_000)


@every_page
def test_every_command_in_a_block_can_be_typed(page):
    for _, block in blocks_of(page):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True) if "workbench " in line else []
            if words and words[0].removeprefix(".venv/bin/") == "workbench":
                parse([*takewhile(lambda word: word not in ("&", "<", ">"), words[1:])])


def command_of(words: list[str]) -> tuple[typing.Any, list[str]]:
    """The dataclass of a command, followed from verb to verb, and the words that are left."""
    known: typing.Any = arguments.Arguments
    while typing.get_args(known):
        verbs = {typing.get_args(one)[1].name: typing.get_args(one)[0] for one in known.__args__}
        if not words or words[0] not in verbs:
            assert not words or words[0].startswith("-") or words[0].isupper(), words
            return None, words
        known, words = verbs[words[0]], words[1:]
        what = known.__dataclass_fields__.get("what")
        if what is not None and len(known.__dataclass_fields__) == 1:
            known = what.type
    return known, words


@every_page
def test_every_command_in_a_sentence_is_one_with_these_options(page):
    for span in re.findall(r"`((?:\.venv/bin/)?workbench [^`]+)`", prose_of(page)):
        command, words = command_of(span.split()[1:])
        long = {word.partition("=")[0] for word in words if word.startswith("--")}
        options = long - {"--help", "--version"}
        fields = dataclasses.fields(command) if command is not None else ()
        assert options <= {"--" + field.name.replace("_", "-") for field in fields}, span


@every_page
def test_toml_and_python_in_blocks_are_well_formed(page):
    for language, block in blocks_of(page):
        if language == "toml":
            tomllib.loads(block)
        elif language == "python":
            ast.parse(block)


def test_safety_names_files_and_tests_that_are_there():
    page = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:workbench|tests)/[^`]+)`", page):
        assert (ROOT / name).is_file(), name


def test_sources_are_cited_where_they_are_used():
    page = (ROOT / "docs" / "sources.md").read_text(encoding="utf-8")
    rows = [line.split(": `", 1) for line in page.splitlines() if ": `workbench/" in line]
    assert len(rows) > 15
    for source, files in rows:
        for file in re.findall(r"([^`]+)`(?:, `|$)", files):
            text = (ROOT / file).read_text(encoding="utf-8")
            years, names = re.findall(r"\b(?:19|20)\d\d\b", source), source.replace(",", "").split()
            assert not years or any(year in text for year in years), (source, file)
            assert any(name in text for name in names if name[0].isupper() and len(name) > 3), file


def test_changes_and_commands_name_the_version_that_this_is():
    version = workbench.__version__
    # What is new since then stands above it, under its own heading.
    headings = re.findall(r"^## \[(.+?)\](.*)$", (ROOT / "CHANGELOG.md").read_text(), re.M)
    assert headings[0] == ("Unreleased", "") and headings[1][0] == version
    assert re.fullmatch(r" - \d{4}-\d\d-\d\d", headings[1][1])
    assert f'\nversion: "{version}"\n' in (ROOT / "CITATION.cff").read_text()
    for path in ("docs/service.md", "setup/Containerfile"):
        named = set(re.findall(r"workbench-(\d+\.\d+\.\d+)", (ROOT / path).read_text()))
        assert named == {version}, path


def test_every_layer_is_described():
    layers = {path.parent.name for path in (ROOT / "workbench").glob("*/__init__.py")}
    assert len(layers) == 16
    for layer in layers:
        assert f"\n- `{layer}`" in ARCHITECTURE


def test_every_file_that_is_named_exists():
    named = set(re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.(?:py|toml|md))", ARCHITECTURE))
    assert len(named) > 20
    for name in named:
        assert (ROOT / "workbench" / name).exists() or (ROOT / name).exists(), name


def spans_of(page: Path) -> list[str]:
    """Code in sentences and tables."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    return re.findall(r"`([^`\n]+)`", text)


def classes() -> dict[str, set[str]]:
    """Every class of the code and its tests, with its members and those of its bases."""
    found: dict[str, set[str]] = {}
    bases: dict[str, set[str]] = {}
    for file in (*(ROOT / "workbench").rglob("*.py"), *(ROOT / "tests").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                members = found.setdefault(node.name, set())
                bases.setdefault(node.name, set()).update(map(ast.unparse, node.bases))
                for one in ast.walk(node):
                    if isinstance(one, ast.FunctionDef):
                        members.add(one.name)
                    elif isinstance(one, ast.AnnAssign | ast.Assign):
                        targets = [one.target] if isinstance(one, ast.AnnAssign) else one.targets
                        members |= {target.id for target in targets if isinstance(target, ast.Name)}

    def all_of(name: str) -> set[str]:
        return found.get(name, set()).union(*map(all_of, bases.get(name, ())))

    return {name: all_of(name) for name in found}


def test_every_module_that_is_named_exists_also_without_its_folder():
    files = {path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*.py") if not hidden(path)}
    known = {
        "/".join(parts[start:])
        for file in files
        if (parts := file.split("/"))
        for start in range(len(parts))
    }
    for page in PAGES:
        made = {
            name.split("/")[-1] for name in re.findall(r"^`([\w/.]+)`:$", page.read_text(), re.M)
        }
        for span in spans_of(page):
            for name in re.findall(r"(?<![\w/.*-])((?:[\w-]+/)*\w+\.py)\b", span):
                assert name in known or name in made, f"{page.name}: {name}"


def hidden(path: Path) -> bool:
    return any(part.startswith(".") or part == "build" for part in path.relative_to(ROOT).parts)


ELSEWHERE = {"Settings.load", "RAPIDtoRobot.dnum", "RAPIDfromRobot.dnum"}
"""Members of what others have made."""


def test_every_member_of_a_class_that_is_named_exists():
    known, count = classes(), 0
    for page in PAGES:
        if page.name == "CHANGELOG.md":
            continue
        for span in spans_of(page):
            for name, member in re.findall(r"(?<![\w./])([A-Z][A-Za-z]+)\.([a-z_]+)\b", span):
                if f"{name}.{member}" not in ELSEWHERE and member not in FILES:
                    assert member in known.get(name, set()), f"{page.name}: {name}.{member}"
                    count += 1
    assert count > 10


FILES = {"md", "ply", "cfg", "mod", "zip", "toml"}
"""What ends the name of a file and is no member."""


def test_every_name_after_a_colon_is_in_its_file():
    named = re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.py):([A-Za-z_]+)", ARCHITECTURE)
    assert named
    for file, name in named:
        tree = ast.parse((ROOT / "workbench" / file).read_text(encoding="utf-8"))
        assert name in {
            node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)
        }, f"{file}:{name}"


def test_every_command_phase_and_verdict_is_listed():
    asked = {kind.__name__ for kind in commands.COMMANDS}
    assert len(asked) > 10
    rights = (ROOT / "docs" / "rights.md").read_text(encoding="utf-8")
    for name in (*asked, *Phase):
        assert f"`{name}`" in ARCHITECTURE + rights, name
    for reason in Reason:
        assert reason.name in ARCHITECTURE


def test_every_typed_command_stands_on_the_page_of_commands():
    verbs = [typing.get_args(one)[1].name for one in typing.get_args(arguments.Arguments)]
    assert len(verbs) == 31
    for verb in verbs:
        assert f"workbench {verb}" in COMMANDS


@every_page
def test_every_make_target_exists(page):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    code = "\n".join([*spans_of(page), *(block for _, block in blocks_of(page))])
    for target in re.findall(r"^make ([a-z]+)", code, re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target
        assert f"make {target}" in makefile or target == "constraints", "it stands in `make help`"
