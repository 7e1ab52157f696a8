"""The shipped RAPID modules, executed: every scene, and with them every statement."""

import threading

import pytest
from rapid_scenes import SCENES
from rapid_stage import Stage
from waiting import PATIENCE
from wires import Talk

NOT_EXECUTED = {
    # module, line as it stands there, after the one before it: why no run can get to it
    (
        "WbLink.mod",
        'DEFAULT:\nrefuse "this means nothing";',
    ): "every word of the table has its case",
    ("WbLink.mod", 'ELSE\nrefuse "a step without legs";'): "take_leg lets no step be left out",
    (
        "WbLink.mod",
        'IF k>=StrLen(text) THEN\ntrouble:="numbers are missing";',
    ): "a message is whole with eight stars",
    ("WbLink.mod", 'trouble:="numbers are missing";\nRETURN;'): "as the line before",
    (
        "WbLink.mod",
        'body:=digits(said_number,4)+" "+text;\n'
        "IF StrLen(body)>WB_TEXT body:=StrPart(body,1,WB_TEXT);",
    ): "nothing that is said is so long",
}
"""Statements that no scene reaches, each with its reason."""

BY_CHANCE = {
    (
        "WbMove.mod",
        "width:=2*Hand_GetActualPos();\nIF width<wb_width{my_arm} wb_width{my_arm}:=width;",
    )
}
"""A part is lost between two looks at the hand: whether one falls there, a busy machine decides."""


@pytest.fixture
def stage(cell):
    """A controller at home; the threads end with the test."""
    one = Stage(cell)
    thread = threading.Thread(target=one.one.run, daemon=True)
    thread.start()
    one.settle()
    yield one
    one.one.stop()
    thread.join(PATIENCE)
    for link in Talk.links:
        link.close()


def test_every_statement_of_the_modules_is_executed(stage):
    for scene in SCENES:
        scene(stage)
    left = sorted(stage.one.keys - stage.one.covered)
    told = {
        (module, "\n".join(text.strip() for text in stage.lines(module)[line - 2 : line]))
        for module, line, _ in left
    }
    assert told - BY_CHANCE == set(NOT_EXECUTED)
