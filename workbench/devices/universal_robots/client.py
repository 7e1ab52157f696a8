"""The foreign client, `ur-rtde`, in a process of its own: `python -m ... HOST SCRIPT_PORT`.

While it connects it lets no other thread of its process run, for as long as the network likes.
Lines of JSON come by standard input: {"run": text}, {"stop": true}, {"alive": n}.  Lines that go
out tell the controller's state, again and again, and the answers.  When the input ends so does
this: then nobody writes `ALIVE`, and the controller stops a program of ours.
"""

import importlib
import json
import math
import os
import select
import sys
from typing import Any

from workbench.devices.universal_robots.rtde import ALIVE, BEGUN, PROGRESS

PERIOD = 0.02
"""[s] Between two reports."""

STOP = "def workbench_stop():\n  stopj(10.0)\nend\n"
"""[rad/s2] A new program takes the place of the one that runs."""

VARIABLES = (
    "timestamp",
    "actual_q",
    "robot_mode",
    "safety_status_bits",
    "runtime_state",
    *(f"output_int_register_{register}" for register in (PROGRESS, *BEGUN)),
)


def main(host: str, script_port: int, sends: bool) -> None:
    """Connect, and go on until the input ends or the controller is gone."""
    words = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # the library prints what is no JSON

    def say(**request: Any) -> None:
        words.write(json.dumps(request) + "\n")

    try:
        _serve(host, script_port, sends, say)
    except Exception as error:  # whatever the library throws, its message is what is known
        say(problem=str(error).strip() or type(error).__name__)


def _serve(host: str, script_port: int, sends: bool, say: Any) -> None:
    receive = importlib.import_module("rtde_receive")
    robot = receive.RTDEReceiveInterface(host, 50.0, list(VARIABLES))
    board = writer = script = None
    if sends:
        board = importlib.import_module("dashboard_client").DashboardClient(host)
        board.connect(2000)
        say(remote=bool(board.isInRemoteControl()))
        writer = importlib.import_module("rtde_io").RTDEIOInterface(host)
        script = importlib.import_module("script_client").ScriptClient(host, 5, 11, script_port)
        script.connect()
    heard = b""
    while True:
        if not robot.isConnected():
            say(problem="the controller closed the link")
            return
        say(**_read_state(robot))
        if not select.select([0], [], [], PERIOD)[0]:
            continue
        data = os.read(0, 1 << 20)
        if not data:
            return
        *lines, heard = (heard + data).split(b"\n")
        for line in lines:
            asked = json.loads(line)
            if "alive" in asked and writer is not None:
                writer.setInputIntRegister(ALIVE, asked["alive"])
            if "run" in asked and script is not None:
                say(sent=bool(script.sendScriptCommand(asked["run"])))
            if "stop" in asked and script is not None and board is not None:
                try:
                    script.sendScriptCommand(STOP)
                finally:
                    board.stop()
                say(stopping=True)


def _read_state(robot: Any) -> dict[str, Any]:
    """The values of one packet: a new one may come while the library hands them out one by one."""
    while True:
        at = robot.getTimestamp()
        state = {
            "at": at,
            "q": list(robot.getActualQ()),
            "mode": robot.getRobotMode(),
            "safety": robot.getSafetyStatusBits(),
            "runtime": robot.getRuntimeState(),
            "leg": robot.getOutputIntRegister(PROGRESS),
            "begun": [robot.getOutputIntRegister(register) for register in BEGUN],
        }
        # A time that is no number equals none; whoever receives the state refuses it.
        if math.isnan(at) or robot.getTimestamp() == at:
            return state


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3] == "send")
