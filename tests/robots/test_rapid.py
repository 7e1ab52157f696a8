"""The shipped RAPID modules: readable, whole, of one mind with the simulated controller."""

import re

import pytest
from rapid_reader import RapidError, read, strings_of, unknown_names

from workbench.devices.abb_simulated import serving as abb_serving
from workbench.devices.abb_socket import frames as abb_frames
from workbench.devices.abb_socket import program as abb_program
from workbench.devices.abb_socket import sending as abb_sending
from workbench.devices.abb_socket.states import NEXT
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.plugins.robot_link import USUAL

FOLDER = find("robots", "yumi") / "rapid"
README = (FOLDER / "README.md").read_text(encoding="utf-8")
MODULES = {path.stem: read(path.read_text(encoding="ascii")) for path in FOLDER.glob("*.mod")}
TASKS = {
    task: re.findall(r"`(\w+)`", modules)
    for task, modules in re.findall(r"\| `(T_\w+)` \|.*\| (.+) \|", README)
    if "Wb" in modules
}
SIGNALS = set(re.findall(r"\| `(do\w+)` \|", README))

INSTRUCTIONS = {
    "ClearPath", "ClkReset", "ClkStart", "ClkStop", "GripLoad", "Hand_GripInward",
    "Hand_Initialize", "Hand_MoveTo", "MoveAbsJ", "SocketAccept", "SocketBind", "SocketClose",
    "SocketCreate", "SocketListen", "SocketReceive", "SocketSend", "Stop", "StopMove",
    "StopMoveReset", "SyncMoveOff", "SyncMoveOn", "SyncMoveUndo", "TPReadFK", "TPWrite",
    "WaitSyncTask", "WaitTime", "WaitUntil",
}  # fmt: skip
FUNCTIONS = {
    "Abs", "BitXOr", "ByteToStr", "CalcRobT", "CJointT", "ClkRead", "Distance", "DOutput",
    "Hand_GetActualPos", "Hand_IsCalibrated", "NumToStr", "SocketPeek", "StrFind", "StrLen",
    "StrPart", "StrToByte", "StrToVal",
}  # fmt: skip
PREDEFINED = {
    "ERRNO",
    "ERR_SOCK_TIMEOUT",
    "ERR_WAITSYNCTASK",
    "STR_DIGIT",
    "WAIT_MAX",
    "fine",
    "load0",
    "stEmpty",
    "tool0",
    "z0",
}


def low(names):
    return {name.lower() for name in names}


def numbers(module, name):
    return [
        float(token.text)
        for token in MODULES[module].data[name.lower()][2]
        if token.kind == "number"
    ]


def test_each_task_has_its_modules_and_each_arm_one_task():
    assert set(TASKS) == {"T_LINK", "T_ROB_R", "T_ROB_L"}
    assert {name for names in TASKS.values() for name in names} == set(MODULES)
    mains = {
        task: [n for n in names if "main" in MODULES[n].routines] for task, names in TASKS.items()
    }
    assert mains == {"T_LINK": ["WbLink"], "T_ROB_R": ["WbRight"], "T_ROB_L": ["WbLeft"]}
    told = strings_of(MODULES["WbShared"].data["wb_both"][2])
    assert told == ["T_ROB_R", "T_ROB_L"]
    assert (numbers("WbRight", "my_arm"), numbers("WbLeft", "my_arm")) == ([1], [2])


@pytest.mark.parametrize("task", TASKS)
def test_every_name_of_a_task_is_declared(task):
    modules = [MODULES[name] for name in TASKS[task]]
    data = low(PREDEFINED | SIGNALS)
    assert list(unknown_names(modules, low(INSTRUCTIONS), low(FUNCTIONS), data)) == []


def test_what_tasks_share_is_shared():
    """Only persistents are; a variable in a module of several tasks is one in each."""
    kinds = {kind for kind, _, _ in MODULES["WbShared"].data.values()}
    assert kinds == {"const", "pers"}
    assert {
        kind for name, (kind, type_, _) in MODULES["WbMove"].data.items() if type_ == "syncident"
    } == {"var"}


def test_nothing_moves_from_the_task_of_the_link():
    called = {
        name for routine in MODULES["WbLink"].routines.values() for name, _, _ in routine.calls
    }
    assert not called & low({"MoveAbsJ", "SyncMoveOn", "Hand_MoveTo", "Hand_GripInward"})
    assert "stopmove" in called
    moving = {
        name for routine in MODULES["WbMove"].routines.values() for name, _, _ in routine.calls
    }
    assert low({"MoveAbsJ", "SyncMoveOn", "SyncMoveOff", "SyncMoveUndo", "WaitSyncTask"}) <= moving


def body_of(module, routine):
    text = (FOLDER / f"{module}.mod").read_text()
    return re.search(rf"PROC {routine}\(.*?ENDPROC", text, re.DOTALL)[0]


def test_arms_that_were_stopped_may_move_again_on_every_way_out():
    """Until StopMoveReset every motion waits: also after an abort of arms that stood still."""
    assert "StopMove\\" in body_of("WbLink", "handle")
    ways_out = re.split(r"RETURN;", body_of("WbLink", "stop_arms"))
    assert len(ways_out) == 2
    assert all("StopMoveReset" in way for way in ways_out)


def test_no_order_is_given_to_an_arm_that_would_take_it_for_done():
    """It looks for the newest order once it has come home."""
    obey = body_of("WbMove", "wb_obey")
    home, ready = obey.index("go_home_in_turn"), obey.index("wb_ready{my_arm}:=TRUE")
    assert obey.index("wb_ready{my_arm}:=FALSE") < home < obey.index("last_order:=") < ready
    for routine in ("check_run", "order"):
        assert "NOT (wb_ready{1} AND wb_ready{2})" in body_of("WbLink", routine)


def test_the_table_of_states_is_that_of_the_simulated_controller():
    rows = strings_of(MODULES["WbLink"].data["wb_row"][2])
    assert numbers("WbLink", "wb_rows") == [len(rows)]
    assert rows == [f"{state} {word} {after}" for (state, word), after in NEXT.items()]


def test_every_word_is_handled():
    text = (FOLDER / "WbLink.mod").read_text()
    body = text[text.index("PROC handle()") : text.index("PROC begin_program()")]
    handled = set(re.findall(r'CASE "(\w+)":', body))
    assert handled == {word for _, word in NEXT} - {"done", "fault", "wait"}


def test_numbers_that_both_sides_have_are_the_same():
    cell = read_cell("yumi")
    assert numbers("WbShared", "wb_most_points") == [abb_program.MOST_POINTS]
    assert numbers("WbShared", "wb_most_legs") == [abb_program.MOST_LEGS]
    assert numbers("WbLink", "wb_frame") == [abb_frames.SIZE]
    assert numbers("WbLink", "wb_text") == [abb_frames.TEXT]
    assert numbers("WbLink", "wb_silence") == [USUAL.silence]
    assert numbers("WbLink", "wb_port") == [cell.controller.port]
    assert numbers("WbLink", "wb_start_tolerance") == pytest.approx(
        [abb_serving.START_TOLERANCE * 180 / 3.141592653589793]
    )
    assert strings_of(MODULES["WbLink"].data["wb_version"][2]) == [abb_sending.VERSION]
    assert strings_of(MODULES["WbLink"].data["wb_arms"][2]) == [abb_sending.arms_of(cell)]


def test_home_is_that_of_the_cell():
    for arm in read_cell("yumi").arms:
        where = MODULES[f"Wb{arm.name.title()}"].data["my_home"][2]
        text = "".join(token.text for token in where)
        axes = [float(word) for word in re.findall(r"-?\d+(?:\.\d+)?(?:E\d)?", text)][:7]
        home = [round(float(arm.home[k]) * 180 / 3.141592653589793, 6) for k in arm.axis_order]
        assert axes == pytest.approx(home)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("ENDFOR", "", "'ERROR' is no name"),
        ("ENDIF", "", "'ENDPROC' is no name"),
        ("VAR num leg;", "VAR num step;", "'step' is no name"),
        ("leg:=leg_of(nr);", "leg:=leg_of(nr;", "not closed"),
        ("PROC run_program()", "PROC run_leg()", "declared twice"),
        ('"The "', f'"{"x" * 81}"', "more than 80"),
        ("CONST num WB_FORCE:=10;", "CONST num WB_FORCE;", "without a value"),
        ("VAR bool has_gripped", "TASK VAR bool has_gripped", "TASK stands before PERS alone"),
        ("IF my_arm=WB_RIGHT go_home;", "IF my_arm=WB_RIGHT THEN go_home;", "'ENDPROC' is no name"),
        ("go_home_in_turn;", "go_home_in_turn", "is there a ; missing"),
        ("IF share=0 RETURN fine;", "@", "is not RAPID"),
    ],
)
def test_the_reader_refuses_what_is_no_rapid(old, new, says):
    text = (FOLDER / "WbMove.mod").read_text()
    assert old in text
    with pytest.raises(RapidError, match=re.escape(says)):
        read(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("run_leg leg;", "run_leg leg,nr;", "run_leg is not called so"),
        ("judge_part;", "judge_parts;", "no procedure judge_parts"),
        ("leg_of(nr)", "leg_off(nr)", "no function leg_off"),
        ("corner:=z0;", "korner:=z0;", "korner is not declared"),
        ("wb_leg_zone", "wb_leg_zones", "wb_leg_zones is not declared"),
    ],
)
def test_the_reader_misses_what_is_not_declared(old, new, says):
    text = (FOLDER / "WbMove.mod").read_text()
    assert old in text
    modules = [MODULES["WbShared"], MODULES["WbRight"], read(text.replace(old, new, 1))]
    wrong = list(
        unknown_names(modules, low(INSTRUCTIONS), low(FUNCTIONS), low(PREDEFINED | SIGNALS))
    )
    assert any(says in one for one in wrong)
