"""Finds what the page shows in the sources; `python -m workbench.words.extract` updates catalogs.

The code has no marks for this.  A text on the page is a literal of the page or of the login page,
or a sentence of a lower layer: a refusal, a reason or a note.  So this takes literals, and leaves
out code, styles and names by their form.  A text with values has an id
(`workbench.model.messages`), so literals with values are left out, too.
"""

import ast
import importlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import workbench
from workbench.model.messages.catalogue import SUBJECTS
from workbench.model.messages.message import Others, Text
from workbench.words.catalogs import CATALOGS, LANGUAGES, Catalog
from workbench.words.markup import TAG, texts_of
from workbench.words.words import split_ends

PACKAGE = Path(workbench.__file__).parent
STATIC = PACKAGE.parent / "static"

PAGE_FOLDERS = ("gui", "web/page", "app/core")
"""Folders whose every text is for people at the page."""

SENTENCES = (
    "app/calibration",
    "app/emptying",
    "app/filling",
    "app/picking",
    "app/provenance/inventory.py",
    "app/records/case_folder.py",
    "app/runtime",
    "formats/cells/drawn_tools.py",
    "model",
    "perception/built_in.py",
    "perception/localization/kinds.py",
    "perception/localization/localize.py",
    "perception/scene",
    "planning/grasps",
    "planning/kinematics",
    "planning/picking",
    "planning/placing",
)
"""Folders, and files, of which only whole sentences come to the page: refusals, reasons, notes."""

STATES = ("devices",)
"""Folders of which single words come to the page: what robots report of themselves."""

UNSEEN = frozenset(
    {
        "model/candidate.py",
        "app/calibration/hand_eye.py",
        "app/runtime/anchors.py",
        "app/runtime/worker.py",
        "gui/incoming/files.py",
        "gui/incoming/gate.py",
        "gui/incoming/scene.py",
        "gui/incoming/values.py",
        "gui/incoming/widgets.py",
        "gui/shared/viser_server.py",
        "model/digest.py",
        "model/geometry.py",
        "model/motion.py",
        "model/robot.py",
        "model/symmetry.py",
        "planning/kinematics/posture_check.py",
        "web/page/connections.py",
        "web/page/conversation.py",
        "web/page/manual.py",
        "web/page/messages.py",
        "web/page/pages.py",
        "web/page/pieces.py",
        "web/page/rate_limit.py",
        "web/page/relay.py",
        "web/page/uploads.py",
    }
)
"""Files there whose texts have ids, or go to logs, to the command line or to programs alone."""

WITH_IDS = ("model/messages", "gui/texts", "web/texts.py")
"""Where messages that have ids are written: they are found by these."""

UNITS = ("cm", "deg", "mm", "ms", "rpy", "wb", "xyz")

ALONE = frozenset(
    """
    all alternated approach approve approved at auto axis both busy
    candidate closed coordinated crooked disabled engineer extract failed fault film
    flat found good grasp grasps home idle joint known leaning length linear missed moving
    none nothing off ok one-at-a-time operator part parts picked pitch
    place placed planning proof reach recorded regrasp rejected remaining
    resolve return roll route scan scanned scans sending simulated stopped
    stopping streamed synchronised thickness time-independent to touches
    turned unknown viewer waiting width yaw
    """.split()  # noqa: SIM905
)
"""Single words that are shown, among many that are names of something in the code."""

SCRIPTS = ("shell.js", "tour.js", "scene.js")
PAGES = ("shell.html", "login.html")

VALUE = "{}"
"""Stands for a value in a literal that is put together."""

_LOGS = ("debug", "info", "warning", "error", "exception")
_PLACE = re.compile(r"(\bpart-)?\{(\w+)\}")
_CODE = re.compile(
    r"[{}<>\\]|\bconst |\w\(\)|\b(SELECT|INSERT|DELETE|UPDATE)\b|^[\w.+-]+/[\w.+-]+$|px\b|"
    r" \| |^[#./]|--wb|: ?var\(|^(https?|ws)|;\w+:|\.(css|js|html|svg)$|\w=\"|rgba?\(|=="
)


def messages() -> Mapping[str, tuple[str, ...]]:
    """All messages in English, with the files that have them, from the package down."""
    found: dict[str, set[str]] = {}

    def take(text: str, where: str) -> None:
        if VALUE not in text and (said := tidy(text)) and _is_said(said):
            found.setdefault(said, set()).add(where)

    for folder in PAGE_FOLDERS + SENTENCES + STATES:
        root = PACKAGE / folder
        for path in [root] if root.is_file() else sorted(root.rglob("*.py")):
            where = path.relative_to(PACKAGE).as_posix()
            if where in UNSEEN or where.startswith(WITH_IDS):
                continue
            for text, is_name in _literals(ast.parse(path.read_text(encoding="utf-8"))):
                is_sentence = folder in SENTENCES and " " in text and not is_name
                if folder in PAGE_FOLDERS or is_sentence or text in ALONE:
                    for piece in texts_of(text) if TAG.search(text) else (text,):
                        take(piece, where)
    for name in PAGES:
        text = (STATIC / name).read_text(encoding="utf-8")
        for piece in texts_of(text.replace("{{", "{").replace("}}", "}")):
            take(piece, f"static/{name}")
    for name in SCRIPTS:
        for piece in _said_in_script((STATIC / name).read_text(encoding="utf-8")):
            take(piece, f"static/{name}")
    return {text: tuple(sorted(found[text])) for text in sorted(found)}


def templates() -> Mapping[str, str]:
    """The English templates of the messages that have ids."""
    texts = (text for subject in subjects() for text in subject)
    return {text.id: text.template for text in texts if text is not Others.PLAIN}


def subjects() -> tuple[type[Text], ...]:
    """All enumerations of texts: those that may be on record, then those of the page alone."""
    found = list(SUBJECTS)
    for folder in WITH_IDS[1:]:
        root = PACKAGE / folder
        for path in [root] if root.is_file() else sorted(root.glob("*.py")):
            name = ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts)
            module = importlib.import_module(name.removesuffix(".__init__"))
            found += [it for it in Text.__subclasses__() if it.__module__ == module.__name__]
    return tuple(found)


def tidy(text: str) -> str:
    """A text as a message: without what joins it to others, white space as one blank."""
    return split_ends(" ".join(text.split()))[1]


def _is_said(text: str) -> bool:
    """Whether a text is for people, and no code, style, name of something or mere places."""
    bare = _PLACE.sub("", text)
    if (
        text in LANGUAGES.values()
        or _CODE.search(bare)
        or not re.search(r"[A-Za-z]{2}|\ba\b", bare)
    ):
        return False
    words = re.findall(r"[A-Za-z]{2,}|\ba\b", bare)
    if " " in text.strip():
        return any(word not in UNITS for word in words)
    return text in ALONE or re.fullmatch(r"[A-Z][a-z]+[a-z-]*[:.…]?", bare) is not None


def _literals(tree: ast.Module) -> Iterator[tuple[str, bool]]:
    """Texts in a file, and whether each is no more than a name."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            for statement in body:
                if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
                    skipped.add(id(statement.value))
        if isinstance(node, ast.JoinedStr):
            skipped.update(map(id, node.values))
        if isinstance(node, ast.Call) and _is_silent(node.func):
            skipped.update(map(id, ast.walk(node)))
        if isinstance(node, ast.Subscript | ast.AnnAssign):
            inner = node.slice if isinstance(node, ast.Subscript) else node.annotation
            skipped.update(map(id, ast.walk(inner)))
        if isinstance(node, ast.Assert):
            skipped.update(map(id, ast.walk(node)))
    for node in ast.walk(tree):
        if id(node) not in skipped and isinstance(node, ast.Constant | ast.JoinedStr):
            text = _read_literal(node)
            yield text, isinstance(node, ast.Constant) and " " not in text


def _is_silent(called: ast.expr) -> bool:
    """Whether a call shows its arguments to nobody: a log, a pattern, or names of fields."""
    if isinstance(called, ast.Name):
        return called.id == "own"
    if not isinstance(called, ast.Attribute) or not isinstance(called.value, ast.Name):
        return False
    return (called.value.id == "log" and called.attr in _LOGS) or called.value.id == "re"


def _read_literal(node: ast.Constant | ast.JoinedStr) -> str:
    """What a literal reads, `{}` for each value in it; empty where it is no text."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    return "".join(
        str(value.value).replace("{", "\\").replace("}", "\\")
        if isinstance(value, ast.Constant)
        else VALUE
        for value in node.values
    )


def _said_in_script(text: str) -> Iterator[str]:
    """What stands in `word("...")`, pieces with a plus between them put together."""
    for found in re.finditer(r'\bword\(\s*((?:"(?:[^"\\]|\\.)*"\s*\+?\s*)+)', text):
        yield "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', found[1]))


def main() -> None:
    """Write what is new into all catalogs, and drop what is said no more."""
    wanted = messages()
    for language in LANGUAGES:
        if language != "en":
            path = CATALOGS / f"{language}.po"
            Catalog.read(path).brought_to(templates(), wanted).write(path)


if __name__ == "__main__":
    main()
