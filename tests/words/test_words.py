"""Whole texts and messages are put in a language; names and numbers stay."""

import pytest

from workbench.gui.texts.cycle import CyclePageText
from workbench.gui.texts.labels import arm_label
from workbench.model.messages.cells import CellText, InventoryText
from workbench.model.messages.message import plain
from workbench.model.messages.plans import StrategyText
from workbench.model.messages.states import StateText
from workbench.words.choosing import find_language, first_guess
from workbench.words.words import IN_ENGLISH, Words, words_of


@pytest.fixture(scope="module")
def words():
    return Words(
        "de",
        {
            "there is no fault": "es gibt keine Störung",
            "approach": "Anfahren",
            "Stop": "Stopp",
            "stop": "anhalten",
        },
    )


@pytest.mark.parametrize(
    ("english", "said"),
    [
        ("Stop", "Stopp"),
        ("  Stop\n", "  Stopp\n"),
        (", approach;", ", Anfahren;"),
        ("There is no fault.", "Es gibt keine Störung."),
        ("stop", "anhalten"),
        ("certificate-8bf864650bb2.json", "certificate-8bf864650bb2.json"),
        ("Stopped by nobody", "Stopped by nobody"),
        ("", ""),
    ],
)
def test_a_whole_text_is_translated(words, english, said):
    assert words.say(english) == said


def test_html_keeps_its_tags_and_what_was_typed_stays_text(words):
    said = words.html('<b title="Stop">Stop</b> <i>&lt;b&gt; parts</i><style>a{Stop}</style>')
    assert said == '<b title="Stopp">Stopp</b> <i>&lt;b&gt; parts</i><style>a{Stop}</style>'
    evil = "No plan: &lt;script&gt;alert(1)&lt;/script&gt;"
    assert words.html(evil) == evil


def test_a_handler_of_a_tag_is_no_text(words):
    tag = "<span onclick=\"if(event.key==='Stop'){go('Stop')}\">Stop</span>"
    assert words.html(tag) == tag.replace(">Stop<", ">Stopp<")


def test_a_name_that_people_chose_is_not_translated(words):
    said = words.html('<td translate="no">Stop</td><td title="Stop">Stop</td>')
    assert said == '<td translate="no">Stop</td><td title="Stopp">Stopp</td>'


def test_markdown_keeps_its_marks(words):
    assert words.markdown("**Stop** 12 parts\n\nStop") == "**Stopp** 12 parts\n\nStopp"


def test_chinese_sentences_end_as_those_do():
    assert words_of("zh").say("There is no fault.") == "没有故障。"


def test_english_is_left_alone():
    assert words_of("en").say("Stop") == words_of("xx").say("Stop") == "Stop"


@pytest.mark.parametrize(
    ("accepted", "language"),
    [
        ("de-CH,de;q=0.9,en;q=0.8", "de"),
        ("pt-BR, zh-CN;q=0.5, fr;q=0.7", "fr"),
        ("nl", "en"),
        ("", "en"),
        ("it;q=0, es", "es"),
        ("de;q=often, it", "it"),
        ("*", "en"),
    ],
)
def test_the_first_guess_is_what_the_browser_likes_best(accepted, language):
    assert first_guess(accepted) == language


@pytest.mark.parametrize("language", ["it", "fr", "es", "zh"])
def test_a_step_within_a_sentence_is_said_as_one(language):
    step = StateText.STEP(number=4, total=11, legs=plain("left extract"))
    whole = words_of(language).render(StateText.ROBOT_RUNS(step=step))
    said = words_of(language).render(step)
    assert said in whole and not whole.startswith("the robot")


def test_only_languages_that_there_are_can_be_chosen():
    assert (
        find_language("fr") == "fr"
        and find_language("xx") == find_language("../de") == find_language("") == ""
    )


@pytest.mark.parametrize("language", ["de", "it", "fr", "es", "zh"])
@pytest.mark.parametrize(
    "said",
    [
        InventoryText.FILES(name="workbench", version="0.2.0"),
        InventoryText.VERSION(name="python", was="3.11", has="3.12"),
        InventoryText.NEW_USER(name="Ada", has="op"),
        InventoryText.USER_GONE(name="Ada", was="op"),
        InventoryText.USER_ROLE(name="Ada", was="op", has="view"),
        InventoryText.PARTS(parts=("puck", "bolt")),
        InventoryText.CALIBRATION(),
    ],
)
def test_what_differs_since_the_start_before_has_no_english_verb_left(language, said):
    translated = words_of(language).render(said).split()
    english = {"is", "are", "now", "has", "was", "gone", "new", "of", "the", "differ", "differs"}
    assert not english & set(translated)


def test_of_nothing_the_text_is_empty(words):
    assert words.render(None) == words.render("") == ""


@pytest.mark.parametrize(
    ("language", "said"), [("de", "280\u202f689"), ("en", "280,689"), ("zh", "280,689")]
)
def test_thousands_have_no_comma_where_one_stands_before_decimals(language, said):
    assert said in words_of(language).render(StateText.SCANNED(points="280,689"))


def test_left_and_right_arms_have_names_in_each_language_and_others_their_own():
    german = words_of("de")
    assert german.render(StrategyText.ONE_ARM(arm="right")) == "nur Arm rechts"
    assert german.render(CyclePageText.PICKED(arm="Left")) == "Links entnommen"
    assert german.render(StrategyText.ONE_ARM(arm="door")) == "nur Arm door"
    assert german.render(arm_label("left")) == "Linker Arm"
    assert german.render(arm_label("door")) == "Arm Door"
    assert IN_ENGLISH.render(StrategyText.ONE_ARM(arm="right")) == "right arm only"
    of_file = next(text for text in CellText if "{arm}" in text.template)
    assert "left" in german.render(of_file(**dict.fromkeys(of_file.places, "left")))
