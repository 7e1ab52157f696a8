"""`workbench rapid check` as it is typed: what is printed, and the exit code."""

import json

import pytest

from workbench.cli.main import main
from workbench.formats.files.shipped import find

GOOD = (
    "MODULE m\nPROC main()\nAccSet 50,50;\nSetDO doGrip,1;\nSetDO doGrip,0;\nENDPROC\nENDMODULE\n"
)


@pytest.fixture
def ask(tmp_path, capsys):
    def ask(text, *options):
        path = tmp_path / "m.mod"
        path.write_text(text)
        code = main(["rapid", "check", str(path), *options])
        said = capsys.readouterr()
        return code, said.out, said.err

    return ask


def test_a_program_without_mistakes_ends_with_0(ask):
    code, said, complaint = ask(GOOD)
    assert (code, complaint) == (0, "")
    assert said == (
        "not known here:\n  doGrip, a signaldo: 2 uses, first in m.mod:4\n"
        "known, not executed here:\n  AccSet: 1 use, first in m.mod:3\n"
        "1 module in 1 task: 0 wrong, 1 not known here, 1 known and not executed here\n"
        "nothing is wrong with them\n"
    )


def test_a_mistake_ends_with_3_and_stands_with_file_and_line(ask):
    code, said, _ = ask(GOOD.replace("50,50", "50"))
    assert code == 3
    assert said.startswith("wrong:\n  m.mod:3:1: AccSet misses ramp\n")


def test_half_a_module_ends_with_2_and_one_sentence(ask):
    code, _, complaint = ask(GOOD[:40])
    assert code == 2
    assert complaint == (
        "workbench: m.mod:4:1: the file ends in the middle: PROC main has no ENDPROC\n"
    )


def test_json_tells_the_findings_apart(ask):
    code, said, _ = ask(GOOD.replace("50,50", "50"), "--json")
    told = json.loads(said)
    assert (code, told["ok"]) == (3, False)
    assert told["wrong"] == [
        {"module": "m.mod", "line": 3, "column": 1, "what": "AccSet misses ramp"}
    ]
    assert told["not_known"] == [
        {"name": "doGrip", "used_as": "a signaldo", "uses": 2, "module": "m.mod", "line": 4,
         "declared_in": []}
    ]  # fmt: skip
    assert [one["name"] for one in told["not_executed"]] == ["AccSet"]
    assert told["tasks"] == [{"task": "", "modules": ["m.mod"]}]


def test_signals_can_be_named(ask):
    assert "0 not known here" in ask(GOOD, "--signal", "doGrip")[1]
    code, said, _ = ask(GOOD, "--signal", "doGrip:DI")
    assert code == 3
    assert "a signaldi stands where a signaldo is needed" in said


def test_modules_beside_others_say_what_is_to_be_done(ask):
    ours = str(find("robots", "yumi") / "rapid")
    code, said, _ = ask(GOOD, "--beside", ours)
    assert code == 0
    assert "to be done:\n  Add the task T_LINK with the modules WbShared, WbLink.\n" in said
    told = json.loads(ask(GOOD, "--beside", ours, "--json")[1])
    assert len(told["beside"]["steps"]) == 6


def test_the_shipped_modules_are_right(capsys):
    assert main(["rapid", "check", str(find("robots", "yumi") / "rapid")]) == 0
    assert "0 wrong, 0 not known here, 0 known and not executed" in capsys.readouterr().out


def test_nothing_to_check_is_told(tmp_path, capsys):
    assert main(["rapid", "check"]) == 2
    assert "which modules?" in capsys.readouterr().err
    assert main(["rapid", "check", str(tmp_path)]) == 2
    assert "has no modules" in capsys.readouterr().err
