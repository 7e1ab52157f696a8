"""Nothing on the page is untranslated; two browsers have two languages; each is kept."""

import re
from functools import partial

import pytest
from front_page import Window, open_front
from hands import settle
from playwright.sync_api import expect

from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Role
from workbench.web.access.store import Store
from workbench.web.access.users import Users
from workbench.words import extract, words

PASSWORD = "a long password"

SHOWN = """
() => {
  const found = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const isThere = (one) => one && one.checkVisibility({ visibilityProperty: true })
    && !one.closest("style, script, svg, canvas, [data-notification]");
  for (let node; (node = walk.nextNode());) {
    if (isThere(node.parentElement) && node.data.trim()) found.push(node.data.trim());
  }
  const telling = "[title], [aria-label], [placeholder], input[aria-haspopup]";
  for (const one of document.querySelectorAll(telling)) {
    if (!isThere(one)) continue;
    const texts = [one.title, one.getAttribute("aria-label"), one.placeholder];
    if (one.matches("input[aria-haspopup=listbox]"))
      texts.push(one.value);
    found.push(...texts.filter(Boolean));
  }
  for (const style of document.querySelectorAll("style"))
    for (const said of style.textContent.matchAll(/--wb-(?:told|[123]):"([^"]*)"/g))
      found.push(said[1].replace(/\\\\([0-9a-f]+) /g, (_, c) => String.fromCharCode(`0x${c}`)));
  return [...new Set(found)];
}
"""
"""Each text that can be seen, or is told when one points at something."""

SAID = re.compile(r"⟦[^⟦⟧]*⟧")

LETTERS = re.compile(r"[^\W\d_]{2,}")


NAMES = re.compile(
    r"""
    Anna|Bert|Workbench|\btested\b|yumi|keyed_cylinder|smart_gripper|abb-socket/2|
    (left|right)\ (place|part-place)\ \d|
    (?<!\w)(left|right|side)(?!\w)|part-\d+|side(-\d)+|[\w]+_[\w]+|\b[0-9a-f]{12,64}\b|
    \b(palm|deg|mm|ms|min|kg)\b|\.(stl|obj|ply|3mf|dae|glb|gltf|stp|step|zip|zae)\b|certificate-[0-9a-f]+\.json|
    Collapse\ panel\ area|.*WebGL.*
    """,
    re.VERBOSE | re.IGNORECASE,
)
"""What is no message: names of people, of the cell and of what is in it, digests, units, kinds of
files; and what viser and the browser say themselves."""


def marked(message: str) -> str:
    """A message in no language: what is fixed in it stands in brackets, its places between them."""
    return "".join(
        re.sub(r":([^|]+)\|([^|}]+)", r":⟦\1⟧|⟦\2⟧", piece)
        if number % 2
        else f"⟦{piece}⟧"
        if piece
        else ""
        for number, piece in enumerate(re.split(r"(\{\w+(?::[^{}]*)?\})", message))
    )


@pytest.fixture
def no_language(monkeypatch):
    """Who asks for German gets a language that says nothing as English does."""
    found = {message: marked(message) for message in extract.messages()}
    by_id = {id: (text, marked(text)) for id, text in extract.templates().items()}
    catalog = extract.Catalog("", by_id, found, extract.messages())
    read = words._catalog.__wrapped__
    monkeypatch.setattr(words, "_catalog", lambda code: catalog if code == "de" else read(code))
    words.words_of.cache_clear()
    words.script_messages.cache_clear()
    yield
    words.words_of.cache_clear()
    words.script_messages.cache_clear()


def english(texts, names=NAMES):
    """Of texts that are shown, what no translation has touched, without names."""
    left = {SAID.sub(" ", text): text for text in texts}
    bare = {names.sub("", one): text for one, text in left.items()}
    return sorted(text for one, text in bare.items() if LETTERS.search(one))


@pytest.fixture
def front(bench, tmp_path):
    store = Store(tmp_path / "users.sqlite")
    for name in ("Anna", "Bert"):
        Users(store).add(name, Role.ENGINEER, PASSWORD)
    store.close()
    front, *ends = open_front(bench, tmp_path / "users.sqlite")
    yield front
    for end in ends:
        end.close()


class Reader(Window):
    """A window, and all that was to be read in it."""

    def __init__(self, context, front):
        super().__init__(context)
        self.seen = set()
        self.page.goto(front.url + "/login")

    def choose(self, language):
        self.page.locator("#language select").select_option(language)
        expect(self.page.locator(f"html[lang={language}]")).to_be_attached()

    def enter(self, name):
        self.page.locator("[name=name]").fill(name)
        self.page.locator("[name=password]").fill(PASSWORD)
        self.read()
        self.page.locator("main form button").first.click()
        self.is_there()

    def is_there(self):
        self.scene.locator(".wb-strip").wait_for()
        expect(self.page.locator("#wait")).to_be_hidden()

    def button(self, name):
        return self.scene.get_by_role("button", name=name, exact=True)

    def read(self):
        for frame in self.page.frames:
            self.seen.update(frame.evaluate(SHOWN))

    def walk(self):
        """Look at each tab, with everything in it unfolded."""
        for tab in self.scene.get_by_role("tab").all():
            tab.click()
            settle(self.page, 500)
            self.read()


def test_nothing_is_untranslated_and_each_has_a_language_that_is_kept(
    no_language, front, bench, new_context, reaches, shots
):
    anna, bert = Reader(new_context(), front), Reader(new_context(), front)
    anna.choose("de")
    anna.enter("Anna")
    bert.enter("Bert")
    anna.walk()
    do = partial(bench.do, actor="Anna", role=Role.ENGINEER)
    do(TakeScan(0, 2))
    reaches("scanned")
    do(FindParts(0))
    reaches("localized")
    anna.walk()
    do(MakePlan(threshold=bench.cell.policy.threshold))
    reaches("planned")
    do(WatchPlan(bench.state.plan.digest))
    anna.walk()
    # Side by side, in two languages.
    anna.scene.get_by_role("tab").first.click()
    expect(bert.button("Approve")).to_be_visible()
    anna.button("⟦Approve⟧").click()
    anna.scene.get_by_role("dialog").wait_for()
    anna.read()
    assert not (left := english(anna.seen)), "\n".join(left)
    assert english(bert.seen), "who reads English sees none of it"

    # Chosen on the page, without a new login, and kept with the user.
    anna.page.keyboard.press("Escape")
    anna.choose("fr")
    anna.is_there()
    anna.button("Approuver").wait_for()
    again = Reader(new_context(), front)
    again.enter("Anna")
    again.button("Approuver").wait_for()
    expect(bert.button("Approve")).to_be_visible()
    assert anna.errors == bert.errors == []
