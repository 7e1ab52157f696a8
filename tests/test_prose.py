"""The check of the documents' prose finds what its rules name, and the documents hold."""

import sys
import tomllib
from pathlib import Path

import pytest

SETUP = Path(__file__).resolve().parents[1] / "setup"
sys.path.append(str(SETUP))
from prose import counted, docstrings, faults, main, passages, problems, texts  # noqa: E402

RULES = tomllib.loads((SETUP / "prose.toml").read_text(encoding="utf-8"))
LONG = " ".join(["word"] * 26)


def found(text, name="docs/page.md"):
    return list(problems(name, text, RULES))


def test_a_sentence_of_26_words_is_found_with_its_line():
    (problem,) = found(f"# Page\n\nShort.\n\nShort again. {LONG}.\n")
    assert problem.startswith("docs/page.md:5: 26 words in a sentence")


@pytest.mark.parametrize(
    "text",
    [
        f"{LONG[:-5]}.\n",
        f"{LONG[:60]}; {LONG[:60]}.\n",
        f"- {LONG[:60]}\n- {LONG[:60]}\n",
        f"| {LONG[:60]} | {LONG[:60]} |\n",
        f"```\n{LONG}\n```\n",
        f"`{LONG}` runs.\n",
        f"# {LONG}\n",
    ],
    ids=["25 words", "semicolon", "list", "table", "block", "code", "heading"],
)
def test_what_is_short_or_no_sentence_is_not_found(text):
    assert found(text) == []


def test_a_word_that_readers_stumble_over_is_found_with_a_better_one():
    (problem,) = found("A person is told the reason.\n")
    assert '"told": rather reported' in problem
    assert found("The command `told` runs, and [the story](told.md) is untold.\n") == []


def test_pages_and_lines_of_the_changelog_have_a_limit():
    assert found("a\n\n" * 126) == ["docs/page.md: 252 lines, at most 250"]
    assert found("a\n\n" * 200, next(iter(RULES["longer_pages"]))) == []
    (problem,) = found("- " + "a" * 119, "CHANGELOG.md")
    assert problem == "CHANGELOG.md:1: 121 characters, at most 120"


def test_marks_are_no_words():
    text = "1. **Bold** [text](page.md) ![a picture](picture.webp)\n   `code one` more.\n"
    assert list(passages(text)) == [(1, "Bold text CODE more.")]


def test_a_longer_page_is_one_that_is_there():
    for name in [*RULES["longer_pages"], *RULES["left_out"]]:
        assert (SETUP.parent / name).is_file(), name


def test_docstrings_of_modules_functions_and_constants_are_read_with_their_lines():
    source = '"""The first."""\n\nMOST = 3\n"""It is told."""\n\ndef f():\n    """The third."""\n'
    assert list(docstrings(source)) == [(1, "The first."), (4, "It is told."), (7, "The third.")]
    assert [number for number, _ in faults("It is told.\n", RULES)] == [1]


def test_the_english_texts_of_a_catalog_are_read_and_their_places_are_no_words():
    catalog = 'msgid ""\nmsgstr ""\n\nmsgid "{told} of "\n"{most}"\nmsgstr "{told} von {most}"\n'
    assert list(texts(catalog)) == [(1, ""), (4, "CODE of CODE")]


def test_more_faults_in_docstrings_than_stated_are_reported():
    few = {"files": "setup/*.py", "at_most": 0}
    rules = {**RULES, "docstrings": few, "texts": few | {"files": "setup/*.po"}}
    assert list(counted(rules)) == []
    *wrong, last = counted({**rules, "words": {"documents": "pages"}})
    assert wrong and all(line.startswith("setup/prose.py:") for line in wrong)
    assert last == f"{len(wrong)} in docstrings, at most 0 (setup/prose.toml)"
    stated = few | {"at_most": len(wrong)}
    assert list(counted({**rules, "docstrings": stated, "words": {"documents": "pages"}})) == []


def test_the_documents_hold(capsys):
    assert main() == 0, capsys.readouterr().out
