"""A simulated controller for as long as it is needed, in a process of its own."""

import json
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from workbench.model.cell import Controller
from workbench.model.errors import LinkError

ENDS_WITHIN = 5.0
"""How long [s] a controller may take to end."""

HOME_AFTER = 3.0
"""[s] After a stop the simulated arms go home by themselves: nobody is there to send them."""


@contextmanager
def simulated_controller(
    cell: str, controller: Controller, *, speed: float = 1.0, rapid: Path | None = None
) -> Generator[Controller]:
    """Run `workbench controller` on free ports of this machine for as long as the block runs.

    It also ends when this process does, however that comes: its standard input is a pipe that
    only this process holds.

    Args:
        cell: name or path, as typed.
        controller: the cell's; it says how this one is spoken to.
        speed: 1 is real time.
        rapid: a folder of RAPID modules that run in its place.

    Raises:
        LinkError: it did not start.
    """
    command = [sys.executable, "-m", "workbench", "controller", "--cell", cell, "--port", "0"]
    command += ["--speed", str(speed), "--home-after", str(HOME_AFTER), "--until-eof", "--json"]
    command += [] if rapid is None else ["--rapid", str(rapid)]
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        # Ctrl-C in a terminal is for the process that owns the controller.
        start_new_session=True,
    ) as process:
        if process.stdin is None or process.stdout is None:
            raise LinkError("the simulated controller has no pipes")
        try:
            yield _at(controller, process.stdout.readline())
        finally:
            process.stdin.close()
            try:
                process.wait(ENDS_WITHIN)
            except subprocess.TimeoutExpired:
                process.kill()


def _at(controller: Controller, line: bytes) -> Controller:
    try:
        ports = json.loads(line)
        return replace(
            controller,
            host=ports["host"],
            port=ports["port"],
            state_port=ports["state_port"],
            is_simulated=True,
        )
    except (ValueError, KeyError) as error:
        raise LinkError(
            "the simulated controller did not start; `workbench controller` tells why"
        ) from error
