"""Checks documents, docstrings and English texts by `prose.toml`: short sentences, plain words."""

import ast
import inspect
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RULES = Path(__file__).with_name("prose.toml")

BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
SECTION = re.compile(r"^(?:Args|Returns|Raises):$", re.MULTILINE)
ITEM = re.compile(r"^\s*(?:[-*]|\d\d?\.) ")


def problems(name: str, text: str, rules: Mapping[str, Any]) -> Iterator[str]:
    """What a document has against the rules, a line each.

    Args:
        name: of its file, from the root.
        text: of the document, in Markdown.
        rules: as `prose.toml` has them.
    """
    lines = text.splitlines()
    if name == "CHANGELOG.md":
        most = rules["line_of_the_changelog"]
        for number, line in enumerate(lines, 1):
            if len(line) > most:
                yield f"{name}:{number}: {len(line)} characters, at most {most}"
    elif len(lines) > rules["lines_in_a_page"] and name not in rules["longer_pages"]:
        yield f"{name}: {len(lines)} lines, at most {rules['lines_in_a_page']}"
    for number, problem in faults(text, rules):
        yield f"{name}:{number}: {problem}"


def faults(text: str, rules: Mapping[str, Any]) -> Iterator[tuple[int, str]]:
    """Long sentences and words to avoid in a text, with the number of the line."""
    for number, passage in passages(text):
        for sentence in re.split(r"(?<=[.!?:;])\s+", passage):
            count = sum(any(map(str.isalnum, word)) for word in sentence.split())
            if count > rules["words_in_a_sentence"]:
                yield number, f"{count} words in a sentence: {sentence}"
        for word, better in rules["words"].items():
            if re.search(rf"\b{word}\b", passage, re.IGNORECASE):
                yield number, f'"{word}": rather {better}: {passage}'


def docstrings(source: str) -> Iterator[tuple[int, str]]:
    """Every docstring of a module, of attributes too, with the number of its first line."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            for one in node.body:
                value = one.value if isinstance(one, ast.Expr) else None
                if isinstance(value, ast.Constant) and isinstance(value.value, str):
                    text = inspect.cleandoc(value.value)
                    yield (
                        one.lineno,
                        re.sub(r"^(Args|Returns|Raises):$", "", text, flags=re.MULTILINE),
                    )


def texts(catalog: str) -> Iterator[tuple[int, str]]:
    """The English texts of a catalog of gettext, with the number of their line."""
    for found in re.finditer(r'^msgid ((?:"[^\n]*"\n)+)', catalog, re.MULTILINE):
        line = catalog.count("\n", 0, found.start()) + 1
        text = "".join(map(ast.literal_eval, found[1].splitlines()))
        yield line, re.sub(r"\{[^}]*\}", "CODE", text)


def counted(rules: Mapping[str, Any]) -> Iterator[str]:
    """What docstrings and English texts have against the rules, where it is more than stated."""
    for kind, read in (("docstrings", docstrings), ("texts", texts)):
        limit, wrong = rules[kind], list[str]()
        for file in sorted(ROOT.glob(limit["files"])):
            name = file.relative_to(ROOT).as_posix()
            for first, text in read(file.read_text(encoding="utf-8")):
                wrong += (f"{name}:{first + n - 1}: {what}" for n, what in faults(text, rules))
        if len(wrong) > limit["at_most"]:
            yield from wrong
            yield f"{len(wrong)} in {kind}, at most {limit['at_most']} (setup/{RULES.name})"
        elif len(wrong) < limit["at_most"]:
            print(f"{len(wrong)} in {kind}: lower {limit['at_most']} in setup/{RULES.name}")


def passages(text: str) -> Iterator[tuple[int, str]]:
    """Paragraphs, items of lists and cells of tables, with the number of their first line.

    Blocks of code and headings are left out; code in a sentence is one word.
    """
    text = BLOCK.sub(lambda block: "\n" * block[0].count("\n"), text)
    first, gathered = 1, ""
    for number, line in enumerate([*text.splitlines(), ""], 1):
        is_alone = line.startswith(("#", "|", "<!--")) or not line.strip()
        if gathered and (is_alone or ITEM.match(line)):
            yield first, plain(gathered)
            gathered = ""
        if line.startswith("|"):
            yield from ((number, plain(cell)) for cell in line.strip("| ").split(" | "))
        elif not is_alone:
            first = first if gathered else number
            gathered += f" {ITEM.sub('', line, count=1) if not gathered else line.strip()}"


def plain(text: str) -> str:
    """A passage without marks: the text of links, `CODE` for code, no pictures."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"`[^`]*`", "CODE", text)
    return " ".join(re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text).replace("*", "").split())


def main() -> int:
    """Print what is wrong; 1 when something is."""
    rules = tomllib.loads(RULES.read_text(encoding="utf-8"))
    found = {file for pattern in rules["files"] for file in ROOT.glob(pattern)}
    files = sorted(found - {ROOT / name for name in rules["left_out"]})
    wrong = [
        problem
        for file in files
        for problem in problems(
            file.relative_to(ROOT).as_posix(), file.read_text(encoding="utf-8"), rules
        )
    ]
    wrong += counted(rules)
    print("\n".join(wrong) or f"{len(files)} documents, all by setup/{RULES.name}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
