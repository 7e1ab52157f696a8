"""`workbench rapid check`: what is wrong with modules, with line and column."""

from rapid_bench import problems
from wires import FOLDER

from workbench.formats.rapid.check import check_modules


def test_nothing_speaks_against_the_shipped_modules():
    assert check_modules([FOLDER]) == []


def test_each_kind_of_mistake_is_told_where_it_is():
    body = 'a{4}:=1;\nIF a{1}="x" RETURN;\nnobody 3;\nRETURN;\nTPWrite "x";'
    rest = "VAR num a{3};"
    assert problems(body, rest) == [
        (4, 2, "index 4 is outside 1 to 3"),
        (5, 8, "num = string is no expression"),
        (6, 1, "nobody is not declared or not known here"),
        (8, 1, "this is never reached"),
    ]


def test_files_that_are_no_rapid_are_told(tmp_path):
    path = tmp_path / "x.mod"
    path.write_text("MODULE x\nPROC main()\nx:=;\nENDPROC\nENDMODULE\n")
    assert [str(one) for one in check_modules([path])] == ["x.mod:3:4: ';' cannot stand here"]


def test_what_is_not_executed_here_is_named(tmp_path):
    path = tmp_path / "server.mod"
    path.write_text(
        "%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\nMODULE SERVER\nVAR num ok;\nPROC main()\n"
        "    ConfL \\Off;\n    WHILE TRUE DO\n        TEST ok\n            CASE 0: !Ping\n"
        "                IF ok = 0 THEN\n                    ok := 1;\n                ENDIF\n"
        "        ENDTEST\n    ENDWHILE\nENDPROC\nENDMODULE\n"
    )
    found = [str(one) for one in check_modules([path])]
    assert found == ["server.mod:8:5: ConfL is not declared or not known here"]
