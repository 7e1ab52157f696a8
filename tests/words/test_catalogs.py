"""Catalogs: every message in every language, with its places, and one word for one thing."""

import re

import pytest

from workbench.app.core.commands import COMMANDS
from workbench.model.messages.calibration import ObjectionText
from workbench.model.messages.commands import CommandText
from workbench.model.scan import Objection
from workbench.words.catalogs import CATALOGS, LANGUAGES, Catalog
from workbench.words.extract import ALONE, messages

OTHERS = tuple(language for language in LANGUAGES if language != "en")

SAFETY = {
    "de": ("Stopp", "Freigeben", "Senden", "Not-Halt"),
    "it": ("Ferma", "Approva", "Invia", "arresto di emergenza"),
    "fr": ("Arrêter", "Approuver", "Envoyer", "arrêt d'urgence"),
    "es": ("Detener", "Aprobar", "Enviar", "parada de emergencia"),
    "zh": ("停止", "批准", "发送", "急停"),
}
"""Stop, Approve, Send, and what is no button: the emergency stop."""

FORMATTED = re.compile(r"\{(\w+)(?::([^{}]*))?\}")
"""Name and format of a place."""

UNIT_TWICE = re.compile(
    r"\{\w+:(?:mm|ms|deg|kg|s|min)\d?\} ?"
    r"(?:(?:mm|ms|deg|kg|s|min)\b|°|[Gg]rad|degr|rés|毫米|毫秒|度|秒)"
)
"""A place whose format writes the unit, with the unit after it again."""


@pytest.fixture(scope="module", params=OTHERS)
def language(request):
    return request.param


@pytest.fixture(scope="module")
def catalog(language):
    return Catalog.read(CATALOGS / f"{language}.po")


@pytest.fixture(scope="module")
def said():
    return messages()


def test_every_message_is_there_and_no_other(catalog, said):
    assert dict(catalog.places) == dict(said), "python -m workbench.words.extract"
    assert [key for key, text in catalog.messages.items() if not text.strip()] == []


def test_a_translation_has_the_places_of_its_message(catalog):
    def places(text):
        return sorted(re.findall(r"\{(\w+)\}", text))

    pairs = catalog.messages.items()
    assert [key for key, text in pairs if places(key) != places(text)] == []


def test_a_translation_writes_each_value_in_the_unit_of_its_message(catalog):
    def formats(text):
        return {place for place in FORMATTED.findall(text) if "|" not in place[1]}

    pairs = [*catalog.by_id.values(), *catalog.messages.items()]
    assert [text for english, text in pairs if formats(english) != formats(text)] == []
    assert [text for _, text in pairs if UNIT_TWICE.search(text)] == []


def test_numbers_digests_and_keys_of_files_stay_as_they_are(catalog):
    kept = re.compile(r"\b[a-z]+_[a-z_]+\b|\[[a-z]+\]|\bNAME\b")
    assert [
        key
        for key, text in catalog.messages.items()
        if not set(kept.findall(re.sub(r"\{\w+\}", "", key))) <= set(kept.findall(text))
    ] == []


def test_a_catalog_is_written_as_it_is_read(catalog, tmp_path, language):
    catalog.write(tmp_path / "again.po")
    text = (tmp_path / "again.po").read_text(encoding="utf-8")
    assert text == (CATALOGS / f"{language}.po").read_text(encoding="utf-8")


def test_what_moves_or_stops_a_robot_has_one_word(catalog, language):
    stop, approve, send, emergency = SAFETY[language]
    found = catalog.messages
    assert (found["Stop"], found["Approve"], found["Send"]) == (stop, approve, send)
    # Of what may stand on a button; in the midst of a sentence a noun may read alike.
    on_buttons = [key for key in found if key[0].isupper()]
    assert sum(found[key] in (stop, approve, send) for key in on_buttons) == 3
    for key, text in found.items():
        if "emergency stop" in key.lower():
            assert emergency in text and emergency not in (stop, approve, send), key


def test_buttons_that_a_text_names_are_called_in_it_as_they_are(catalog):
    found = catalog.messages
    for key, text in found.items():
        for named in re.findall(r"\b(?:[Pp]ress|tab) ([A-Z][a-z]+(?: [a-z]+){0,2})", key):
            parts = named.split()
            names = (" ".join(parts[:count]) for count in range(len(parts), 0, -1))
            name = next(one for one in names if one in found)
            assert found[name] in text, (name, key)


def test_every_command_and_every_objection_has_a_text_of_its_own():
    assert len({command.right.says for command in COMMANDS}) == len(COMMANDS)
    assert set(CommandText) == {command.right.says for command in COMMANDS}
    assert {objection.name for objection in Objection} == set(ObjectionText.__members__) - {
        "OF_PART"
    }


def test_single_words_that_are_looked_for_are_still_said_somewhere(said):
    assert set(said) >= ALONE


@pytest.mark.parametrize(
    "broken", ['msgid "a"\nmsgstr "b"\n\nmsgid "a"\nmsgstr "c"\n', "msgid a\n", 'msgstr "b"\n']
)
def test_a_broken_catalog_is_refused(broken, tmp_path):
    path = tmp_path / "broken.po"
    path.write_text(f"# head\n\n{broken}", encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(str(path))):
        Catalog.read(path)
