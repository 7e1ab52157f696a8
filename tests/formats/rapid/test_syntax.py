"""RAPID as files bring it: encodings, headers, placeholders, and text that is cut off or wrong."""

import pytest
from rapid_checks import checked, left_out, module, program, unreadable, wrong

from workbench.formats.rapid.check import check

HALF = "the file ends in the middle"
UMLAUTS = 'TPWrite "Prüfung läuft";\n! größer\ngröße:=3;'


@pytest.mark.parametrize(
    "encode",
    [
        lambda text: text.encode("latin-1"),
        lambda text: text.encode("cp1252"),
        lambda text: text.encode("utf-8"),
        lambda text: text.encode("utf-8-sig"),
        lambda text: text.encode("utf-16"),
        lambda text: text.replace("\n", "\r\n").encode("latin-1"),
        lambda text: text.replace("\n", "\r").encode("latin-1"),
        lambda text: text.encode("latin-1") + b"\x1a",
        lambda text: text.replace("Prüfung", "\u201equer\u201c \x81").encode("cp1252", "replace"),
    ],
    ids=["latin-1", "cp1252", "utf-8", "bom", "utf-16", "crlf", "cr", "ctrl-z", "undefined code"],
)
def test_text_in_every_encoding_is_read(tmp_path, encode):
    data = encode(module(UMLAUTS, "VAR num größe;"))
    assert checked(tmp_path, {"m.mod": data}).problems == []


def test_the_file_of_an_old_controller_holds_a_whole_program(tmp_path):
    head = "%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\n\n"
    other = "MODULE data(SYSMODULE,NOSTEPIN,VIEWONLY)\n  PERS num counter:=0;\nENDMODULE\n"
    found = checked(tmp_path, {"CELL.PRG": head + module("Incr counter;") + other})
    assert found.problems == []
    assert found.tasks == [(tmp_path.name, ["CELL.PRG", "CELL.PRG"])]


def test_placeholders_are_read_and_told(tmp_path):
    body = "<SMT>\nx:=<EXP>;\nIF <EXP> THEN\n<SMT>;\nENDIF\nTEST x\n<CSE>\nENDTEST\n<VAR>:=1;"
    found = program(
        tmp_path, body, "VAR num x;\n<DDN>\n<RDN>\nPROC p(<PAR>)\n<DDN>\n<SMT>\nENDPROC"
    )
    assert wrong(found) == []
    assert left_out(found) == {"<SMT>": 3, "<EXP>": 2, "<DDN>": 2, "<RDN>": 1, "<VAR>": 1}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "the file is empty"),
        ("hello\n", "m.mod:1:1: the file does not begin with MODULE"),
        ("MODULE m\nVAR num x;\n", f"m.mod:3:1: {HALF}: MODULE m has no ENDMODULE"),
        ("MODULE m\nPROC main()\nx:=1;", f"m.mod:3:1: {HALF}: PROC main has no ENDPROC"),
        ("MODULE m\nPROC main()\nx:=", f"m.mod:3:1: {HALF}: PROC main has no ENDPROC"),
        ("version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a pointer of git-lfs"),
        (b"\xfc\x30\x1d\xe1\x0a\x01\x80\x02\x0e\x39" * 30, "an encoded module"),
    ],
)  # fmt: skip
def test_a_file_that_cannot_be_read_is_told_in_one_sentence(tmp_path, text, says):
    (told,) = unreadable(checked(tmp_path, {"m.mod": text}))
    assert told.startswith("m.mod:")
    assert says in told


def test_each_mistake_of_syntax_is_found_in_one_reading(tmp_path):
    body = (
        'x:=f(1;\nx:=2\nIF x:=3 THEN\nx:=4;\nENDIF\nVAR num y;\nmain();\nTPWrite "abc;\n'
        "TPWrite 5;\nENDFOR\nWHILE TRUE DO\nx:=6;"
    )
    found = program(tmp_path, body, "VAR num x;")
    assert wrong(found) == [
        (4, "';' cannot stand here; expected was ',' or ')'"),
        (5, "a ';' is missing behind '2'"),
        (6, "':=' cannot stand here; expected was THEN or a statement"),
        (9, "'VAR' cannot stand here"),
        (10, "')' cannot stand here"),
        (11, "a string has no end in its line"),
        (12, "a num stands where a string is needed"),
        (13, "'ENDFOR' has nothing to end"),
        (16, "ENDWHILE of line 14 is missing before 'ENDPROC'"),
    ]


def test_words_behind_the_last_module_are_told(tmp_path):
    found = checked(tmp_path, {"m.mod": module("") + "\nMODULE n\nENDMODULE\nend of file\n"})
    assert wrong(found) == [(10, "only a MODULE can stand behind ENDMODULE")]


def test_a_routine_without_its_end_does_not_hide_the_next_one(tmp_path):
    text = "MODULE m\nPROC main()\nother;\n\nPROC other()\nENDPROC\nENDMODULE\n"
    found = checked(tmp_path, {"m.mod": text})
    assert wrong(found) == [(5, "ENDPROC of main (line 2) is missing before 'PROC'")]


@pytest.mark.parametrize("cut", range(0, 400, 7))
def test_a_module_that_is_cut_off_anywhere_is_told_and_never_fails(tmp_path, cut):
    body = "FOR k FROM 1 TO 3 DO\nTEST k\nCASE 1:\nx{k}:=f(1\\a:=[1,2]);\n"
    body += 'DEFAULT:\n%"p"%;\nENDTEST\nENDFOR'
    text = module(
        body, "VAR num x{3}:=[1,2,3];\nFUNC num f(num a\\num b|switch c)\nRETURN -a;\nENDFUNC"
    )
    (told,) = unreadable(checked(tmp_path, {"m.mod": text[: min(cut, len(text) - 12)]}))
    assert told.startswith("m.mod:")


def test_all_modules_of_a_call_are_told_even_when_one_cannot_be_read(tmp_path):
    good, half = tmp_path / "a.mod", tmp_path / "b.mod"
    good.write_text(module("TPWrite 5;"))
    half.write_text("MODULE b\nPROC x()\n")
    found = check([good, half])
    assert len(unreadable(found)) == len(wrong(found)) == 1
