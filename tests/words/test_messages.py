"""Messages with ids: every one is there in every language, with the places that its args fill."""

import pytest

from workbench.model.messages.catalogue import SUBJECTS, TEXTS
from workbench.model.messages.message import Text, places_of, plain
from workbench.model.messages.states import StateText
from workbench.model.messages.verdicts import ReasonText, VerdictNote, VerdictText
from workbench.words.catalogs import CATALOGS, LANGUAGES, Catalog
from workbench.words.extract import subjects, templates
from workbench.words.words import IN_ENGLISH, words_of

OTHERS = tuple(language for language in LANGUAGES if language != "en")

BLOCKED = VerdictText.NOTED(
    verdict=VerdictText.APART(
        reason=ReasonText.WITHIN_MARGIN(), one="left palm", other="in collision", far=0.00123
    ),
    note=VerdictNote.ONLY_ARMS(arms=("left", "right")),
)
"""One of its bodies was called like a message by somebody."""


@pytest.fixture(params=OTHERS)
def catalog(request):
    return Catalog.read(CATALOGS / f"{request.param}.po")


def test_every_message_has_a_translation_of_its_english(catalog):
    english = {id: pair[0] for id, pair in catalog.by_id.items()}
    assert english == dict(templates()), "python -m workbench.words.extract"
    assert [id for id, (_, said) in catalog.by_id.items() if not said.strip()] == []


def test_a_translation_shows_the_same_arguments_in_the_same_units(catalog):
    def shown(template: str) -> dict[str, frozenset[str]]:
        # A language without plurals needs no second word.
        return {name: how - {"|", ""} for name, how in places_of(template).items()}

    assert [
        id for id, (english, said) in catalog.by_id.items() if shown(english) != shown(said)
    ] == []


def test_all_subjects_are_in_the_table_and_no_id_is_there_twice():
    every = subjects()
    assert set(every) == set(Text.__subclasses__())
    assert every[: len(SUBJECTS)] == SUBJECTS
    assert len(TEXTS) == sum(len(subject) for subject in SUBJECTS)
    assert len({subject.subject for subject in every}) == len(every)


def test_a_message_is_rendered_whole_and_names_stay():
    assert str(BLOCKED) == IN_ENGLISH.render(BLOCKED)
    german = words_of("de").render(BLOCKED)
    assert german == (
        "zu nah: left palm und in collision, Abstand 1.2 mm (nur für Arm links oder rechts)"
    )


def test_what_was_rendered_passes_the_page_as_it_is():
    words = words_of("de")
    german = words.render(BLOCKED)
    assert words.say(german) == german
    assert words.say(german[:1].upper() + german[1:]) == german[:1].upper() + german[1:]
    assert words.html(f"<b>{german}.</b>") == f"<b>{german}.</b>"


def test_a_text_without_an_id_is_found_by_its_english():
    said = StateText.NEXT_CYCLE(message=plain("there is no fault"))
    assert words_of("de").render(said).endswith(words_of("de").say("there is no fault"))
    assert words_of("de").render(plain("nobody says so")) == "nobody says so"
    assert words_of("de").render(None) == ""
