"""Our modules beside a customer's program."""

import pytest
from rapid_checks import module, written

from workbench.formats.files.shipped import find
from workbench.formats.rapid.merging import merge

OURS = find("robots", "yumi") / "rapid"
TASKS = '      -Name "T_ROB_R" -Entry "main"\n\n      -Name "T_ROB_L"\n'
SYS = f"SYS:CFG_1.0:6:1::\n#\nCAB_TASKS:\n\n{TASKS}"
EIO = 'EIO:CFG_1.0:6:1::\n#\nEIO_SIGNAL:\n\n      -Name "doWbEmergency" -SignalType "DO"\n'
BACKINFO = ">>TASK1: (T_ROB_R,,)\nPROGMOD/Pick.mod @\n\n>>TASK2: (T_ROB_L,,)\nPROGMOD/Pick.mod @\n"


@pytest.fixture
def backup(tmp_path):
    rest = "PERS num wb_order:=0;\nPERS bool wb_steps;\nVAR num wb_turn;"
    files = {
        "RAPID/TASK1/PROGMOD/Pick.mod": module("", rest, "Pick"),
        "RAPID/TASK2/PROGMOD/Pick.mod": "MODULE Pick\nENDMODULE\n",
        "SYSPAR/SYS.cfg": SYS,
        "SYSPAR/EIO.cfg": EIO,
        "BACKINFO/backinfo.txt": BACKINFO,
    }
    return written(tmp_path, files)


def test_what_has_to_be_done_is_said_in_sentences(backup):
    assert merge([backup], OURS).steps == [
        "Add the task T_LINK with the modules WbShared, WbLink.",
        "Load the modules WbShared, WbMove, WbRight into the task T_ROB_R.",
        "Leave PROC main out of WbRight.",
        "Call wb_obey from PROC main of RAPID/TASK1/PROGMOD/Pick.mod in the task T_ROB_R.",
        "Load the modules WbShared, WbMove, WbLeft into the task T_ROB_L.",
        "Call wb_obey from PROC main in the task T_ROB_L.",
        "Configure the digital output doWbRightRuns as system output Task Executing T_ROB_R.",
        "Configure the digital output doWbLeftRuns as system output Task Executing T_ROB_L.",
    ]


def test_names_that_clash_and_data_that_both_use_are_told(backup):
    found = merge([backup], OURS)
    where = "RAPID/TASK1/PROGMOD/Pick.mod"
    assert [(one.module, one.what) for one in found.clashes] == [
        ("WbShared.mod", f"wb_order is declared in {where}, too"),
        ("WbShared.mod", f"wb_steps is declared in {where}, too"),
        ("WbMove.mod", f"wb_turn is declared in {where}, too"),
        ("WbShared.mod", f"PERS wb_steps is a num, and a bool in {where}"),
    ]
    assert found.shared == [f"PERS num wb_order, in WbShared.mod and {where}"]


def test_modules_beside_modules_that_we_ship(tmp_path):
    found = merge([OURS], find("robots", "yumi") / "rapid_egm")
    assert {one.what for one in found.clashes} == {
        f"{name} is declared in {module}.mod, too"
        for name, module in [("my_name", "WbRight"), ("my_name", "WbLeft"), ("wb_obey", "WbMove"),
                             ("wb_slow", "WbMove"), ("wb_force", "WbMove"), ("wb_grip", "WbShared"),
                             ("wb_finger_speed", "WbMove"), ("wb_finger_stroke", "WbMove"),
                             ("wb_begin", "WbMove")]
    }  # fmt: skip
