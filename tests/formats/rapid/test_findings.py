"""What is wrong, what is not known here, what is known and not executed: told apart."""

from pathlib import Path

import pytest
from rapid_checks import checked, left_out, module, program, unknown, written, wrong

from workbench.formats.rapid.check import check

PROGRAMS = sorted((Path(__file__).parent / "programs").glob("*.mod"))
"""Programs of our own that use what RobotWare knows; without mistakes."""


def test_the_three_findings_are_told_apart(tmp_path):
    body = "TPWrite 5;\nweld seam_3,doGun;\nSetDO doGun,1;\nAccSet 50,100;\nAccSet 100,100;"
    found = program(tmp_path, body)
    assert wrong(found) == [(4, "a num stands where a string is needed")]
    assert unknown(found) == {
        "doGun": ("a signaldo", 2), "seam_3": ("data", 1), "weld": ("a procedure", 1),
    }  # fmt: skip
    assert left_out(found) == {"AccSet": 2}


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_what_robotware_knows_is_neither_wrong_nor_unknown(path):
    found = check([path], ["doX", "diX:DI", "aiX:AI", "aoX:AO", "giX:GI", "goX:GO"])
    assert found.problems
    assert {one.kind for one in found.problems} == {"not executed"}


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ('TPWrite "a","b";', "TPWrite has no more arguments"),
        ("MoveL p,v100,fine,t;", "tool needs a PERS, t is none"),
        ("MoveL p,v100,fine,tool0\\Corner;", "MoveL has no argument \\Corner"),
        ("MoveL v100,v5,fine,tool0;", "a speeddata stands where a robtarget is needed"),
        ("MoveL p,v100\\V:=5\\T:=2,fine,tool0;", "MoveL: arguments that exclude each other"),
        ("WaitDI doX,1;", "a signaldo stands where a signaldi is needed"),
        ("doX:=1;", "a num stands where a signaldo is needed"),
        ("IF diX n:=1;", "a signaldi stands where a bool is needed"),
        ("p:=RelTool(p,0,0);", "RelTool misses dz"),
        ("n:=d;", "a dnum stands where a num is needed"),
        ("n:=n+d;", "num + dnum is no expression"),
        ("GOTO nowhere;", "main has no label nowhere"),
        ("IF n=1 IF n=2 main2;", None),
        ("p:=[[0,0,0],[1,0,0,0]];", "robtarget has 4 components, not 2"),
        ("n:=main;", "main is a routine, not data"),
        ("f;", "f is no procedure"),
        ("n:=main();", "main is no function"),
        ("c:=1;", "c cannot be assigned"),
        ("MoveL ToPoint:=p,Zone:=fine,Speed:=v5,Tool:=tool0,Zone:=z1;",
         "MoveL has no more arguments"),
    ],
)  # fmt: skip
def test_mistakes_in_what_robotware_knows_are_told(tmp_path, body, says):
    rest = (
        "VAR robtarget p; VAR tooldata t; VAR num n; VAR dnum d; CONST num c:=1;\n"
        "FUNC num f()\nRETURN 1;\nENDFUNC\nPROC main2()\nENDPROC"
    ).replace("\nFUNC", " FUNC")
    found = program(tmp_path, body, rest, ["doX", "diX:DI"])
    assert [what for _, what in wrong(found)] == ([says] if says else [])


def test_what_is_not_known_is_told_once_and_hides_nothing(tmp_path):
    body = 'robot_state:=strange(n,doA);\nx:=robot_state.at{doB}+1;\nx.y:=[1,[2,"a"]];\nn:="text";'
    found = program(tmp_path, body, "VAR weird_type x; VAR num n;")
    assert wrong(found) == [(7, "a string stands where a num is needed")]
    assert unknown(found) == {
        "robot_state": ("data", 2), "strange": ("a function", 1), "doA": ("data", 1),
        "doB": ("a num", 1), "weird_type": ("a type", 1),
    }  # fmt: skip


def test_a_name_of_robotware_may_be_declared_by_a_program(tmp_path):
    rest = (
        "RECORD listitem\nnum a;\nENDRECORD\nVAR listitem one:=[3];\n"
        "CONST speeddata v100:=[1,1,1,1];\n"
        "FUNC num Max(num a,num b,num c)\nRETURN a;\nENDFUNC"
    )
    found = program(tmp_path, "reg1:=Max(1,2,3);\nreg1:=one.a;", rest)
    assert wrong(found) == []


def test_types_and_data_may_come_in_any_order_and_belong_to_their_module(tmp_path):
    one = (
        "MODULE a\nVAR part p{count}:=[[1],[2]];\nLOCAL RECORD inner\nnum x;\nENDRECORD\n"
        "LOCAL VAR inner i:=[5];\nPROC main()\np{2}.x:=i.x;\nENDPROC\nENDMODULE\n"
    )
    other = (
        'MODULE b\nLOCAL RECORD inner\nstring s;\nENDRECORD\nLOCAL VAR inner i:=["a"];\n'
        "RECORD part\nnum x;\nENDRECORD\nCONST num count:=half*2;\nCONST num half:=1;\nENDMODULE\n"
    )
    found = checked(tmp_path, {"a.mod": one, "b.mod": other})
    assert found.problems == []


def test_data_that_need_themselves_are_told(tmp_path):
    found = program(tmp_path, "", "CONST num a:=b; CONST num b:=a;")
    assert wrong(found) == [(2, "the value of b needs itself")]


def test_a_long_row_of_data_and_types_that_need_each_other_is_read(tmp_path):
    data = "".join(f"CONST num c{k}:=c{k + 1}+1;\n" for k in range(600)) + "CONST num c600:=1;\n"
    types = "".join(f"RECORD r{k}\nr{k + 1} x;\nENDRECORD\n" for k in range(600))
    rest = f"{types}RECORD r600\nnum x;\nENDRECORD\n{data}VAR num row{{c599}};"
    found = wrong(program(tmp_path, "row{3}:=1;", rest))
    assert found[-1] == (2408, "index 3 is outside 1 to 2")
    assert all(what.endswith("is nested too deeply") for _, what in found[:-1])


def test_where_a_name_is_declared_twice_is_told(tmp_path):
    files = {"a.mod": module("", "VAR num p10;", "a"), "b.mod": "MODULE b\nVAR num p10;\nENDMODULE"}
    paths = [tmp_path / name for name in files]
    written(tmp_path, files)
    assert wrong(check(paths)) == [(2, "p10 is declared already in a.mod:2")]


def test_an_argument_that_the_interpreter_does_not_take_is_told_by_its_name(tmp_path):
    body = "MoveL p,v100,z10\\Inpos:=inpos20,tool0;\nIncr d;\nIncr n;"
    found = program(tmp_path, body, "VAR robtarget p; VAR dnum d; VAR num n;")
    assert left_out(found) == {"MoveL \\Inpos": 1, "inpos20": 1, "Incr of a dnum": 1}


def test_code_that_is_never_reached_is_no_mistake(tmp_path):
    found = program(tmp_path, 'RETURN;\nTPWrite "x";')
    assert [(one.kind, one.what) for one in found.problems] == [("remark", "this is never reached")]


def test_what_options_and_newer_robotware_bring_is_no_mistake(tmp_path):
    body = "frame:=OFrameChange(frame,p);\ns:=ReadStr(file\\RemoveCR\\Status:=s);"
    rest = "VAR wobjdata frame; VAR robtarget p; VAR string s; VAR iodev file;"
    assert wrong(program(tmp_path, body, rest)) == []
