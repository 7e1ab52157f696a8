"""`workbench rapid check`: what is wrong with modules, with line and column."""

import pytest
from rapid_bench import Tasks, problems, written
from wires import FOLDER

from workbench.formats.rapid.check import check


def test_nothing_speaks_against_the_shipped_modules():
    assert check([FOLDER]).problems == []


def test_each_kind_of_mistake_is_told_where_it_is():
    body = 'a{4}:=1;\nIF a{1}="x" RETURN;\nnobody 3;\nRETURN;\nTPWrite "x";'
    rest = "VAR num a{3};"
    assert problems(body, rest) == [
        (4, 2, "index 4 is outside 1 to 3"),
        (5, 8, "num = string is no expression"),
        (6, 1, "nobody is not known here"),
        (8, 1, "this is never reached"),
    ]


def test_files_that_are_no_rapid_are_told(tmp_path):
    path = tmp_path / "x.mod"
    path.write_text("MODULE x\nPROC main()\nx:=;\nENDPROC\nENDMODULE\n")
    assert [str(one) for one in check([path]).problems] == ["x.mod:3:4: ';' cannot stand here"]


def test_what_is_not_executed_here_is_named(tmp_path):
    path = tmp_path / "server.mod"
    path.write_text(
        "%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\nMODULE SERVER\nVAR num ok;\nPROC main()\n"
        "    ConfL \\Off;\n    WHILE TRUE DO\n        TEST ok\n            CASE 0: !Ping\n"
        "                IF ok = 0 THEN\n                    ok := 1;\n                ENDIF\n"
        "        ENDTEST\n    ENDWHILE\nENDPROC\nENDMODULE\n"
    )
    found = [str(one) for one in check([path]).problems]
    assert found == ["server.mod:8:5: ConfL is not executed here"]


def test_a_task_needs_a_main_without_parameters(tmp_path):
    path = tmp_path / "x.mod"
    for head, says in [
        ("PROC other()", "x.mod:1:1: no module of the task has a PROC main"),
        ("LOCAL PROC main()", "x.mod:1:1: no module of the task has a PROC main"),
        ("PROC main(num x)", "x.mod:2:1: main cannot have parameters"),
    ]:
        path.write_text(f"MODULE x\n{head}\nENDPROC\nENDMODULE\n")
        assert [str(one) for one in check([path]).problems] == [says]


@pytest.mark.parametrize(
    ("rest", "says"),
    [
        ("ALIAS num num;\nVAR num x;", "the type num is declared already"),
        ("ALIAS b a;\nALIAS a b;", "the type b contains itself"),
        ("RECORD r\nr inner;\nENDRECORD\nVAR r x;", "the type r contains itself"),
        ("RECORD a\nb x;\nENDRECORD\nRECORD b\na x;\nENDRECORD", "the type b contains itself"),
        ("VAR num x:=1E999;", "1e999 is larger than a num can be"),
        (f"VAR num x:=0x{'F' * 300};", f"0x{'f' * 300} is larger than a num can be"),
        (f"VAR num x:=0x{'F' * 40};", f"0x{'f' * 40} is larger than a num can be"),
    ],
)
def test_types_and_numbers_that_cannot_be_are_told(rest, says):
    assert says in [what for _, _, what in problems("", rest)]


def doubled(times: int) -> str:
    """Records, each of two of the one before: the last one of 2 to the power of `times`."""
    first = "RECORD r0\nnum a;\nENDRECORD\n"
    return first + "".join(
        f"RECORD r{k}\nr{k - 1} a;\nr{k - 1} b;\nENDRECORD\n" for k in range(1, times + 1)
    )


@pytest.mark.parametrize(
    ("rest", "says"),
    [
        ("VAR num x{100000,100000};", "x has more than 200,000 values"),
        (f"{doubled(12)}VAR r12 x{{50}};", "x has more than 200,000 values"),
        (f"{doubled(40)}VAR r40 x;", "r14 has more than 10,000 components in all"),
    ],
)
def test_data_that_no_controller_has_memory_for_are_told(rest, says):
    found = [what for _, _, what in problems("VAR num y{1000000,1000};", rest)]
    assert says in found
    assert "y has more than 200,000 values" in found


def test_large_arrays_of_large_records_are_allowed():
    assert problems("", f"VAR num x{{200000}};\n{doubled(10)}VAR r10 y{{190}};") == []


@pytest.mark.parametrize(
    ("expression", "says"),
    [
        ("1/0", "ERR_DIVZERO"),
        ("1 MOD 0", "ERR_DIVZERO"),
        ("1.5 DIV 1", "DIV of 1.5 and 1: both must be whole numbers"),
        ("1E38*1E38", "ERR_NUM_OVERFLOW"),
    ],
)
def test_a_constant_that_cannot_be_computed_is_told_wherever_it_stands(expression, says):
    for body, rest in [
        ("", f"VAR num a{{{expression}}};"),
        ("", f"CONST num a:={expression};"),
        (f"b{{{expression}}}:=1;", "VAR num b{2};"),
    ]:
        assert [what for _, _, what in problems(body, rest)] == [says]


@pytest.mark.parametrize(
    "deep",
    [
        "x:=" + "+".join(["1"] * 1500) + ";",
        "flag:=" + "NOT " * 1500 + "TRUE;",
        "x:=" + "a{" * 1500 + "1" + "}" * 1500 + ";",
        "IF flag THEN\n" * 1500 + "ENDIF\n" * 1500,
        "IF flag " * 1500 + "x:=1;",
    ],
    ids=["sum", "not", "index", "if", "compact if"],
)
def test_what_is_nested_too_deeply_is_told_where(tmp_path, deep):
    path = tmp_path / "x.mod"
    path.write_text(
        f"MODULE x\nVAR num x;VAR num a{{2}};VAR bool flag;\nPROC main()\n{deep}\n"
        "ENDPROC\nENDMODULE\n"
    )
    (found,) = check([path]).problems
    assert found.what == "is nested too deeply"
    assert found.line >= 4


@pytest.mark.parametrize(
    "deep",
    [
        "x:=" + "+".join(["1"] * 90) + ";",
        "flag:=" + "NOT " * 90 + "TRUE;",
        "x:=" + "a{" * 45 + "1" + "}" * 45 + ";",
        "x:=" + "Abs(" * 45 + "1" + ")" * 45 + ";",
        "IF flag THEN\n" * 45 + "x:=1;\n" + "ENDIF\n" * 45,
    ],
    ids=["sum", "not", "index", "function", "if"],
)
def test_what_is_nested_almost_as_deeply_runs(deep):
    assert written(deep, "VAR num x;VAR num a{2}:=[1,1];VAR bool flag:=TRUE;") == []


def test_dim_has_an_array_and_a_number():
    assert problems("x:=Dim(a);\nx:=Dim(x,1);", "VAR num x; VAR num a{2};") == [
        (4, 4, "this is not how many arguments dim has"),
        (5, 4, "dim wants an array"),
    ]


@pytest.mark.parametrize("second", ["PERS bool x;", "PERS num x{2};", "PERS num x{3,3};"])
def test_a_persistent_is_the_same_in_all_tasks(second):
    own = "CONST num size:=3;"
    main = "PROC main()\nENDPROC\nENDMODULE"
    first = f"MODULE a\nPERS num x{{size}};\n{own}\n{main}"
    good = Tasks({"A": [first], "B": [first]})
    assert not good.tasks["B"].loaded.problems
    bad = Tasks({"A": [first], "B": [f"MODULE b\n{second}\n{main}"]})
    assert [one.what for one in bad.tasks["B"].loaded.problems] == [
        "the PERS x has another type or size in another task"
    ]
