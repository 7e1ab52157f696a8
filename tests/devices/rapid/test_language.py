"""RAPID as it is executed: values, control, errors, routines."""

import binascii

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rapid_bench import problems, written

from workbench.formats.rapid.problems import BadModule
from workbench.formats.rapid.syntax.grammar import parse
from workbench.formats.rapid.texts import number_text
from workbench.formats.rapid.values import single

numbers = st.floats(-1e6, 1e6, allow_nan=False, width=32)


def value(expression, rest=""):
    (text,) = written(f"TPWrite NumToStr({expression},6);", rest)
    return float(text)


@settings(max_examples=60, deadline=None)
@given(st.lists(numbers, min_size=2, max_size=5), st.lists(st.sampled_from("+-*/"), min_size=4))
def test_numbers_are_those_of_single_precision(values, signs):
    """NumPy is the judge: the same operations, one after the other, in float32."""
    found = np.float32(values[0])
    text = f"{values[0]!r}" if values[0] >= 0 else f"(0-{-values[0]!r})"
    with np.errstate(all="ignore"):
        for sign, other in zip(signs, values[1:], strict=False):
            other_ = np.float32(other)
            ways = {"+": found + other_, "-": found - other_, "*": found * other_}
            found = ways[sign] if sign in ways else found / (other_ if other_ else np.float32(1))
            other = (other_ or 1.0) if sign == "/" else other_
            text = f"({text}){sign}({float(other)!r})".replace("(-", "(0-")
    if not np.isfinite(found):
        return
    (told,) = written(f"TPWrite NumToStr({text},6\\Exp);")
    assert float(told) == pytest.approx(float(found), rel=1e-6, abs=1e-30)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("7 DIV 2", 3), ("-7 DIV 2", -3), ("7 MOD 3", 1), ("(0-7) MOD 3", -1), ("2+3*4", 14),
        ("-2*3", -6), ("0x1F", 31), ("0b101", 5), ("1.5E2", 150), ("16777217", 16777216),
        ("BitXOr(255,16)", 239), ("BitLSh(129,1)", 2), ("StrToByte(\"FF\"\\Hex)", 255),
        ("StrLen(\"a\"\"b\\\\c\\0A\")", 6), ("StrFind(\"abc\",1,\"xc\")", 3),
        ("StrFind(\"  ab\",1,\" \"\\NotInSet)", 3), ("StrFind(\"abc\",4,\"a\")", 4),
        ("StrMatch(\"abcabc\",2,\"bc\")", 2), ("Round(2.345\\Dec:=2)", 2.35), ("Trunc(-2.7)", -2),
        ("ATan2(1,1)", 45), ("Distance([0,0,0],[3,4,0])", 5), ("Abs(-3)", 3), ("Pow(2,10)", 1024),
        ("Sqrt(2)", 1.414214), ("Min(2,3)", 2), ("Dim(grid,2)", 3), ("grid{2,3}", 6),
    ],
)  # fmt: skip
def test_expressions_have_their_values(expression, expected):
    rest = "VAR num grid{2,3}:=[[1,2,3],[4,5,6]];"
    assert value(expression, rest) == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        ("NOT FALSE AND FALSE", True),
        ("TRUE OR NOT TRUE", True),
        ("TRUE AND NOT FALSE", True),
        ("TRUE XOR TRUE", False),
        ("1+1=2 AND 2<3", True),
        ('"a"<>"b"', True),
        ("[1,2,3]=p", True),
    ],
)
def test_not_binds_as_weakly_as_or(condition, expected):
    body = f'IF {condition.replace("[1,2,3]=p", "p=[1,2,3]")} THEN TPWrite "yes"; ENDIF'
    assert (written(body, "CONST pos p:=[1,2,3];") == ["yes"]) is expected


def test_the_check_sum_of_the_link_is_the_usual_one():
    text = "0001 hello abb-socket/2"
    source = "VAR num high:=255; VAR num low:=255; VAR num h; VAR num l; VAR bool carry; VAR num i;"
    body = f"""
        FOR k FROM 1 TO StrLen("{text}") DO
            high:=BitXOr(high,StrToByte(StrPart("{text}",k,1)\\Char));
            FOR bit FROM 1 TO 8 DO
                carry:=high>=128;
                high:=(high*2) MOD 256;
                IF low>=128 high:=high+1;
                low:=(low*2) MOD 256;
                IF carry THEN
                    high:=BitXOr(high,16);
                    low:=BitXOr(low,33);
                ENDIF
            ENDFOR
        ENDFOR
        TPWrite ByteToStr(high\\Hex)+ByteToStr(low\\Hex);"""
    assert written(body, source) == [f"{binascii.crc_hqx(text.encode(), 0xFFFF):04X}"]


def test_records_and_arrays_are_copied_and_their_parts_written():
    body = """
        a:=[[1,2,3],[4,5,6]];
        b:=a;
        b{2}.y:=9;
        j.robax.rax_3:=7;
        TPWrite NumToStr(a{2}.y,0)+NumToStr(b{2}.y,0)+NumToStr(j.robax.rax_3,0);
        change a{1}.x;
        take a{1}.x;
        TPWrite NumToStr(a{1}.x,0);
        fill row;
        TPWrite NumToStr(row{1},0);"""
    rest = """VAR pos a{2}; VAR pos b{2}; VAR jointtarget j; CONST num row{2}:=[1,2];
        PROC fill(num all{*})
            all{1}:=9;
        ENDPROC
        PROC change(INOUT num where)
            where:=where+10;
        ENDPROC
        PROC take(num copied)
            copied:=0;
        ENDPROC"""
    assert written(body, rest) == ["597", "11", "1"]


def test_every_control_structure_goes_its_ways():
    body = """
        FOR k FROM 3 TO 1 DO TPWrite "down"\\Num:=k; ENDFOR
        FOR k FROM 1 TO 6 STEP 2 DO
            TEST k
            CASE 1,2:
                TPWrite "one";
            CASE 3:
                TPWrite "three";
            DEFAULT:
                TPWrite "other";
            ENDTEST
        ENDFOR
        WHILE n<2 DO
            n:=n+1;
            IF n=1 THEN
                TPWrite "first";
            ELSEIF n=2 THEN
                TPWrite "second";
            ELSE
                TPWrite "never";
            ENDIF
        ENDWHILE
        IF n=2 late;"""
    rest = 'VAR num n:=0;\nPROC late()\n%"la"+"ter"%;\nENDPROC\n'
    rest += 'PROC later()\nTPWrite "late";\nENDPROC'
    assert written(body, rest) == [
        "down3", "down2", "down1", "one", "three", "other", "first", "second", "late",
    ]  # fmt: skip


def test_goto_goes_to_its_label_in_the_same_block_or_around_it():
    body = """
        again:
        n:=n+1;
        TPWrite "turn"\\Num:=n;
        WHILE TRUE DO
            FOR k FROM 1 TO 3 DO
                IF k=2 GOTO out;
                TPWrite "k"\\Num:=k;
            ENDFOR
        ENDWHILE
        out:
        IF n<2 THEN
            GOTO again;
        ENDIF
        GOTO done;
        TPWrite "never";
        done:
        TPWrite "end";"""
    assert written(body, "VAR num n:=0;") == ["turn1", "k1", "turn2", "k1", "end"]


def test_a_goto_without_a_label_or_into_a_block_is_told():
    body = "GOTO inside;\nGOTO nowhere;\nIF TRUE THEN\ninside:\nENDIF"
    assert problems(body) == [
        (4, 1, "GOTO into a block is not executed here"),
        (5, 1, "main has no label nowhere"),
        (5, 1, "this is never reached"),
        (6, 1, "this is never reached"),
    ]


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("p*2", "[2,4,6]"), ("2*p", "[2,4,6]"), ("p/2", "[0.5,1,1.5]"), ("-p", "[-1,-2,-3]"),
        ("p+q", "[1,2,4]"), ("p*q", "[2,-1,0]"),
    ],
)  # fmt: skip
def test_positions_are_scaled_turned_and_added(expression, expected):
    rest = "VAR pos r; CONST pos p:=[1,2,3]; CONST pos q:=[0,0,1];"
    body = f'r:={expression};\nIF r={expected} TPWrite "yes";'
    assert written(body, rest) == ["yes"]


def test_orientations_are_multiplied_as_scipy_does():
    import scipy.spatial.transform as judge

    a, b = judge.Rotation.random(2, random_state=4)
    one, other = (f"[{w:.9f},{x:.9f},{y:.9f},{z:.9f}]"
                  for x, y, z, w in (a.as_quat(), b.as_quat()))  # fmt: skip
    rest = f"VAR orient r; CONST orient a:={one}; CONST orient b:={other};"
    body = "r:=a*b;\n" + "".join(f"TPWrite NumToStr(r.q{k},6);\n" for k in (1, 2, 3, 4))
    found = np.array([float(text) for text in written(body, rest)])
    x, y, z, w = (a * b).as_quat()
    assert abs(found @ [w, x, y, z]) == pytest.approx(1.0, abs=1e-5)


def test_a_dnum_is_computed_with_more_digits():
    body = 'd:=4503599627370496*2-1;\nIF d=9007199254740991 TPWrite "same";'
    body += '\nd:=-d;\nIF d<0 TPWrite "less";'
    assert written(body, "VAR dnum d;") == ["same", "less"]


def test_functions_return_optional_arguments_are_there_or_not():
    rest = """
        FUNC num f(num a \\num b | switch c)
            IF Present(b) RETURN a+b;
            IF Present(c) RETURN -a;
            RETURN g(a\\b?b);
        ENDFUNC
        FUNC num g(num a \\num b)
            IF Present(b) RETURN 0;
            RETURN a;
        ENDFUNC"""
    assert [value(f"f({args})", rest) for args in ("2", "2\\b:=3", "2\\c")] == [2, 5, -2]


def test_errors_are_retried_passed_over_returned_and_raised():
    rest = """
        VAR num tries:=0;
        VAR num zero:=0;
        PROC retried()
            TPWrite NumToStr(1/zero,1);
        ERROR
            IF ERRNO=ERR_DIVZERO THEN
                tries:=tries+1;
                IF tries=3 zero:=4;
                RETRY;
            ENDIF
        ENDPROC
        PROC passed()
            IF 1/(zero-4)>0 THEN
                TPWrite "never";
            ENDIF
            TPWrite "next";
        ERROR
            TRYNEXT;
        ENDPROC
        FUNC num returned()
            RETURN 1/(zero-4);
        ERROR
            RETURN 7;
        ENDFUNC
        PROC raised()
            deeper;
            TPWrite "never";
        ERROR
            TPWrite "taken"\\Num:=ERRNO;
        ENDPROC
        PROC deeper()
            RAISE 55;
        ERROR
            TPWrite "on its way";
            RAISE;
        ENDPROC"""
    body = 'retried;\npassed;\nTPWrite NumToStr(returned(),0);\nraised;\nTPWrite "end";'
    assert written(body, rest) == ["0.2", "next", "7", "on its way", "taken55", "end"]


@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("n:=1/z;", "nothing handles ERR_DIVZERO"),
        ("n:=row{z};", "nothing handles ERR_OUTOFBND"),
        ("n:=row{1.5+z};", "nothing handles ERR_OUTOFBND"),
        ("b:=z+256;", "256 is no byte: whole numbers from 0 to 255"),
        ("s:=s+s;", "nothing handles ERR_STRTOOLNG"),
        ('s:=StrPart("abc",3,2);', "StrPart: 2 characters from 3 on of 3"),
        ('n:=StrToByte("x1");', "StrToByte: 'x1' is no byte"),
        ("n:=1.5 MOD 2;", "MOD of 1.5 and 2: both must be whole numbers"),
        ("n:=forgets(z);", "nothing handles ERR_FNCNORET"),
        ("EXIT;", "EXIT"),
        ("RAISE 12;", "nothing handles error 12"),
        ("absent;", "the optional argument x was not given"),
        ('%"nobody"%;', "nothing handles ERR_REFUNKPRC"),
        ("n:=9E30; n:=n*n;", "nothing handles ERR_NUM_OVERFLOW"),
        ("n:=Pow(1E30,20);", "nothing handles ERR_NUM_OVERFLOW"),
        ("n:=Pow(z-8,0.5);", "an argument makes no sense: "),
        ("s:=NumToStr(z,-1);", "an argument makes no sense: "),
        ("n:=Round(2.5\\Dec:=400);", "nothing handles ERR_NUM_OVERFLOW"),
        ("n:=Trunc(2.5\\Dec:=400);", "nothing handles ERR_NUM_OVERFLOW"),
        ("n:=Dim(row,3);", "an argument makes no sense: "),
        ("n:=kept(z);", "nothing handles ERR_FNCNORET"),
        ("FOR k FROM 1 TO 3 STEP z DO ENDFOR", "STEP 0 never ends"),
        ("again;", "routines call each other without end"),
    ],
)
def test_what_cannot_go_on_stops_the_task_and_says_why(body, says):
    rest = """VAR num n; VAR num z:=0; VAR num row{2}; VAR byte b;
        VAR string s:="0123456789012345678901234567890123456789x";
        FUNC num forgets(num k)
            IF k>0 RETURN k;
        ENDFUNC
        PROC absent(\\num x)
            TPWrite "x"\\Num:=x;
        ENDPROC
        FUNC num kept(num k)
            RETURN 1/k;
        ERROR
            TPWrite "taken";
        ENDFUNC
        PROC again()
            again;
        ENDPROC"""
    told = written(body, rest)[-1]
    assert told.startswith(says) if says.endswith(": ") else told == says


def test_both_sides_of_and_are_computed():
    """So a program that runs here runs where evaluation stops early, and where it does not."""
    rest = "VAR num row{2};\nVAR num k:=3;"
    assert written('IF k<3 AND row{k}=0 TPWrite "x";', rest) == ["nothing handles ERR_OUTOFBND"]


def test_nobody_reads_a_module_that_is_none():
    for text, says in [
        (
            "MODULE m\nPROC main()\nIF TRUE THEN\nENDPROC\nENDMODULE",
            "m:4:1: ENDIF of line 3 is missing",
        ),
        ("MODULE m\nPROC main()\nx:=;\nENDPROC\nENDMODULE", "m:3:4: ';' cannot stand here"),
        ("MODULE m\nVAR num x:=@;\nENDMODULE", "m:2:12: '@;' is no RAPID"),
        ("MODULE m\nPROC main()", "m:2:1: the file ends in the middle: PROC main"),
        (f'MODULE m\nCONST string s:="{"x" * 81}";\nENDMODULE', "m:2:17: a string of 81"),
        (f"MODULE m\nVAR num {'x' * 33};\nENDMODULE", "m:2:9: the name x"),
        ("MODULE m\nVAR num step;\nENDMODULE", "m:2:9: 'step' cannot stand here"),
    ]:
        with pytest.raises(BadModule) as refused:
            parse(text, "m")
        assert str(refused.value).startswith(says)


@given(numbers)
def test_a_single_is_what_numpy_makes_of_it(number):
    assert single(number / 3) == float(np.float32(number / 3))


def test_a_text_of_a_number_that_no_num_can_be_is_none():
    body = 'IF NOT StrToVal("1e999",x) AND NOT StrToVal("-1e39",x) TPWrite "none"\\Num:=x;'
    assert written(body, "VAR num x:=7;") == ["none7"]


def test_numbers_are_written_with_as_many_digits_as_asked_for():
    assert [number_text(2.5, 0, None), number_text(-12.346, 2, None)] == ["2", "-12.35"]


def test_a_dnum_holds_what_a_num_does_not():
    large = "281474976710655"
    rest = f"VAR dnum d:={large};\nVAR dnum e;"
    body = f'e:=d;\nIF e={large} TPWrite "same";\nIF e<d OR d<1 TPWrite "less";'
    body += '\nIF d=281474976710654 OR 281474976710655>d TPWrite "single";'
    body += "\ne:=7;\nTPWrite NumToStr(DnumToNum(e),0);"
    assert written(body, rest) == ["same", "7"]
    assert problems("e:=n;", "VAR dnum e;\nVAR num n;") == [
        (5, 4, "a num stands where a dnum is needed")
    ]
