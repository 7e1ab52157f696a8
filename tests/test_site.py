"""The site of the documents: built without a warning, and whole without a network."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest
from chromium import find_chromium
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "docs"))
from make_site import BUILD, ELSEWHERE, EXAMPLES, build, gallery, reference  # noqa: E402

import workbench  # noqa: E402

OUTPUTS = {example.stem: f"output of {example.stem}\n" for example in EXAMPLES}
NEEDED = ("mkdocs", "material", "mkdocstrings", "mkdocstrings_handlers.python")


def is_installed(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """All of it but the output of the examples, which are tried by tests of their own."""
    if not all(is_installed(name) for name in NEEDED):
        pytest.skip("what the site is made with is not installed: `make docs` does that")
    folder = tmp_path_factory.mktemp("site")
    build(folder / "site", folder / "documents", OUTPUTS)
    return folder / "site"


def test_every_public_name_is_in_the_reference():
    page = reference()
    for name in workbench.__all__:
        assert page.count(f"heading: {name}\n") == 1, name
    assert "::: workbench.model.cell.Cell\n" in page
    assert "::: workbench.api.plan\n" in page


def test_every_example_is_in_the_gallery_with_what_it_prints():
    page = gallery(OUTPUTS)
    for example in EXAMPLES:
        assert f'title="examples/{example.name}"' in page
        assert f"```text\noutput of {example.stem}\n```" in page


def test_what_is_built_is_kept_out_of_the_repository():
    assert f"{BUILD.name}/" in (ROOT / ".gitignore").read_text().splitlines()


def test_every_document_is_a_page(site):
    for document in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]:
        page = site / document.relative_to(ROOT).with_suffix(".html")
        assert page.with_stem(page.stem.replace("README", "index")).is_file(), document
    assert "judge every grasp" in (site / "reference.html").read_text().lower()
    assert "output of why_not" in (site / "gallery.html").read_text()
    assert "note.lifts-tried" in (site / "messages.html").read_text()


def test_every_picture_is_where_the_pages_look_for_it(site):
    count = 0
    for page in site.rglob("*.html"):
        for source in re.findall(r"<img[^>]* src=\"?([^\s\">]+)", page.read_text()):
            assert (page.parent / source).is_file(), (page, source)
            count += 1
    assert count > 20


def test_nothing_is_loaded_from_elsewhere(site):
    loads = re.compile(
        r"<(?:script|img|iframe|source|video|audio|object|embed)\b[^>]*"
        r"\b(?:src|srcset|data)=[\"']?(?:https?:)?//[^>]*>"
        r"|<link\b[^>]*\bhref=[\"']?(?:https?:)?//[^>]*>"
    )
    for page in site.rglob("*.html"):
        assert loads.findall(page.read_text()) == [], page
    for style in site.rglob("*.css"):
        found = re.findall(r"(?:@import|url\()\s*[\"']?((?:https?:)?//[^\"')]+)", style.read_text())
        assert found == [], style
    for script in site.rglob("*.js"):
        assert ELSEWHERE.search(script.read_text()) is None, script


def test_a_browser_asks_nobody_else(site):
    chromium = find_chromium()
    if chromium is None:
        pytest.skip("no chromium here; on Debian: apt-get install chromium-headless-shell")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page()
        asked: list[str] = []
        problems: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.on("requestfailed", lambda request: problems.append(request.url))
        page.on("pageerror", lambda error: problems.append(str(error)))
        for name in ("index", "docs/architecture", "reference", "gallery", "messages"):
            page.goto((site / f"{name}.html").as_uri(), wait_until="networkidle")
        browser.close()
    assert problems == []
    assert len(asked) > 4
    assert [url for url in asked if not url.startswith(site.as_uri())] == []
