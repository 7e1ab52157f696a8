"""Folders as a backup has them: tasks, signals, lists of modules; and folders that are none."""

import pytest
from rapid_checks import checked, module, unknown, unreadable, written, wrong

from workbench.formats.rapid.backups.cfg import instances, read_configuration
from workbench.formats.rapid.check import check
from workbench.model.errors import FileError

SYS = """SYS:CFG_1.0:6:1::
#
CAB_TASKS:

      -Name "T_ROB1" -Type "NORMAL" -MotionTask

      -Name "T_BACK" -Type "SEMISTATIC" -Entry "watch"
#
CAB_TASK_MODULES:

      -File "HOME:/user.sys" -ModName "user" -AllTask

      -File "HOME:/lib/tools.sys" -ModName "tools"\\
      -Task "T_ROB1"
"""
EIO = """EIO:CFG_1.0:6:1::
#
EIO_SIGNAL:

      -Name "diPart" -SignalType "DI" -Device "D652" -DeviceMap "0"

      -Name "doGrip" -SignalType "DO" -Device "D652"\\
      -DeviceMap "1" -Default 1

      -Name "goJob" -SignalType "GO"
"""
MOC = 'MOC:CFG_1.0:6:1::\n#\nMECHANICAL_UNIT:\n\n      -name "STN_7" -use_run_enable "x"\n'
LISTED = (
    ">>TASK1: (T_ROB1,Cell,)\r\nPROGMOD\\Main.mod @ \r\nSYSMOD\\user.sys @ HIDDEN\r\n\r\n"
    ">>TASK2: (T_BACK,,)\r\nPROGMOD\\Watch.mod @ \r\n"
)


WATCH = "MODULE Watch\nPERS num shared;\nPROC watch()\nENDPROC\nENDMODULE\n"
MAIN, USER = "RAPID/TASK1/PROGMOD/Main.mod", "RAPID/TASK1/SYSMOD/user.sys"


def backup():
    main = "WaitDI diPart,1;\nSetDO doGrip,1;\nSetGO goJob,5;\nActUnit STN_7;\nuse_tool;\n"
    main += "shared:=2;\nIF TaskIsActive(T_BACKId) RETURN;"
    return {
        MAIN: module(main, "PERS num shared:=0;", "Main"),
        USER: "MODULE user(SYSMODULE)\nVAR num reg1:=0;\nENDMODULE\n",
        "RAPID/TASK2/PROGMOD/Watch.mod": WATCH,
        "HOME/user.sys": "MODULE user(SYSMODULE)\nVAR num reg1:=0;\nENDMODULE\n",
        "HOME/lib/tools.sys": "MODULE tools\nPROC use_tool()\nENDPROC\nENDMODULE\n",
        "HOME/old/tools.sys": "MODULE tools\nhalf of a module, long forgotten",
        "SYSPAR/SYS.cfg": SYS, "SYSPAR/EIO.cfg": EIO, "SYSPAR/MOC.cfg": MOC,
        "BACKINFO/backinfo.txt": LISTED,
    }  # fmt: skip


def test_a_backup_without_mistakes_has_none(tmp_path):
    found = checked(tmp_path, backup())
    assert [one for one in found.problems if one.kind != "not executed"] == []
    assert found.tasks == [
        ("T_ROB1", [MAIN, USER, "HOME/lib/tools.sys"]),
        ("T_BACK", ["RAPID/TASK2/PROGMOD/Watch.mod", "HOME/user.sys"]),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("path", "text", "says"),
    [
        ("SYSPAR/EIO.cfg", EIO.replace('"DI"', '"DO"'),
         "a signaldo stands where a signaldi is needed"),
        ("RAPID/TASK2/PROGMOD/Watch.mod", WATCH.replace("num", "bool"),
         "the PERS shared has another type or size in another task"),
        ("HOME/lib/tools.sys", "MODULE tools\nPROC use_tool(num x)\nENDPROC\nENDMODULE\n",
         "use_tool misses x"),
    ],
)  # fmt: skip
def test_mistakes_between_the_files_of_a_backup_are_told(tmp_path, path, text, says):
    assert [what for _, what in wrong(checked(tmp_path, {**backup(), path: text}))] == [says]


def test_names_that_only_another_task_has_are_told_with_its_module(tmp_path):
    files = backup()
    files["RAPID/TASK2/PROGMOD/Watch.mod"] = (
        "MODULE Watch\nPROC watch()\nuse_tool;\nSetDO doNone,1;\nENDPROC\nENDMODULE\n"
    )
    found = checked(tmp_path, files)
    assert unknown(found) == {"doNone": ("a signaldo", 1), "use_tool": ("a procedure", 1)}
    assert {one.name: list(one.elsewhere) for one in found.names("unknown")} == {
        "doNone": [], "use_tool": ["HOME/lib/tools.sys"],
    }  # fmt: skip


def test_modules_that_the_backup_does_not_list_were_not_loaded(tmp_path):
    files = {**backup(), "RAPID/TASK1/PROGMOD/Older.mod": module("nonsense 1;", "", "Older")}
    found = checked(tmp_path, files)
    assert wrong(found) == [] and unknown(found) == {}
    assert [(one.module, one.what) for one in found.of("remark")] == [
        ("RAPID/TASK1/PROGMOD/Older.mod", "the backup does not list it as loaded")
    ]


def test_what_lies_beside_a_backup_is_a_program_of_its_own(tmp_path):
    files = {**backup(), "sample/Old.mod": module("TPWrite 5;", "", "Old")}
    files["HOME/other/Tool.mod"] = "MODULE Tool\nPROC grip()\nTPWrite 5;\nENDPROC\nENDMODULE\n"
    found = checked(tmp_path, files)
    assert [one.module for one in found.of("wrong")] == ["sample/Old.mod"]
    assert found.spare == ["HOME/other/Tool.mod"]


def test_two_programs_in_one_task_are_one_mistake(tmp_path):
    rest = "VAR num a;VAR num b;VAR num c;VAR num d;"
    files = {f"TASK1/PROGMOD/{name}.mod": module("", rest, name) for name in ("x", "y")}
    assert wrong(checked(tmp_path, files)) == [
        (1, "5 names are declared in TASK1/PROGMOD/x.mod, too (a, b, c, ...)")
    ]


def test_an_encoded_module_in_a_backup_is_no_mistake(tmp_path):
    files = {**backup(), "HOME/lib/tools.sys": b"\xfc\x30\x1d\xe1\x0a\x01\x80\x02\x0e\x39" * 30}
    found = checked(tmp_path, files)
    assert wrong(found) == [] and unreadable(found) == []
    assert unknown(found) == {
        "use_tool": ("a procedure", 1),
        "tools.sys": ("an encoded module: what it declares is not known here", 1),
    }


def test_only_the_programs_of_a_backup_are_enough(tmp_path):
    written(tmp_path, backup())
    for path in ("RAPID", "RAPID/TASK1", "RAPID/TASK1/PROGMOD/Main.mod"):
        found = check([tmp_path / path])
        assert set(unknown(found)) == {"use_tool"}, path


def test_files_of_several_programs_are_one_task_for_each_main(tmp_path):
    files = {
        "motion.mod": module("talk;", "VAR num speed;", "motion"),
        "server.mod": module("talk;", "VAR num speed;", "server"),
        "common.sys": "MODULE common\nPROC talk()\nENDPROC\nENDMODULE\n",
    }
    written(tmp_path, files)
    for paths in ([tmp_path], [tmp_path / name for name in files]):
        found = check(paths)
        assert found.problems == []
        assert [modules for _, modules in found.tasks] == [
            ["motion.mod", "common.sys"], ["server.mod", "common.sys"],
        ]  # fmt: skip


def test_folders_of_programs_are_checked_apart_with_what_they_share(tmp_path):
    files = {
        "left/Main.mod": module("help_me;", "VAR num x;", "Main"),
        "right/Main.mod": module("help_me;", "VAR num x;", "Main"),
        "lib/help.sys": "MODULE help\nPROC help_me()\nENDPROC\nENDMODULE\n",
    }
    found = checked(tmp_path, files)
    assert found.problems == []
    assert [modules for _, modules in found.tasks] == [
        ["left/Main.mod", "lib/help.sys"], ["right/Main.mod", "lib/help.sys"],
    ]  # fmt: skip


def test_a_list_of_a_program_that_names_what_is_not_there_is_told(tmp_path):
    rows = "".join(f"<Module>{name}</Module>\n" for name in ("m.mod", "Gone.mod"))
    text = f'<?xml version="1.0" ?>\n<Program>\n{rows}</Program>'
    found = checked(tmp_path, {"p/m.mod": module(""), "p/p.pgf": text})
    assert [str(one) for one in found.problems] == ["p/p.pgf:4:1: Gone.mod is not beside it"]


def test_a_folder_without_modules_is_told(tmp_path):
    with pytest.raises(FileError, match=r"has no modules: files that end with \.mod"):
        check([tmp_path])


def test_instances_of_a_configuration_are_read_over_several_lines():
    assert list(instances(EIO))[1] == (
        "EIO_SIGNAL",
        {"name": "doGrip", "signaltype": "DO", "device": "D652", "devicemap": "1", "default": "1"},
    )


def test_the_configuration_gives_names_their_types(tmp_path):
    written(tmp_path, {"EIO.cfg": EIO, "SYS.cfg": SYS, "MOC.cfg": MOC})
    found = read_configuration(sorted(tmp_path.iterdir()))
    assert found.names() == {
        "diPart": "signaldi", "doGrip": "signaldo", "goJob": "signalgo", "STN_7": "mecunit",
        "T_ROB1Id": "taskid", "T_BACKId": "taskid",
    }  # fmt: skip
    assert found.modules == {"user.sys": set(), "lib/tools.sys": {"T_ROB1"}}
    assert found.entries["T_BACK"] == "watch"
