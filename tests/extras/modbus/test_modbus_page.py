"""The lists of the Modbus server in the documents are those of the code."""

import re
from pathlib import Path

from workbench.extras.modbus.jobs import JOBS, Answer, Error
from workbench.extras.modbus.registers import PHASES, Register

PAGE = (Path(__file__).parents[3] / "docs" / "modbus.md").read_text(encoding="utf-8")


def meaning(register: Register) -> str:
    (said,) = re.findall(rf"^- {register.value} `{register.name}`: (.+)$", PAGE, re.MULTILINE)
    return said


def test_every_register_stands_there_and_no_other():
    stands = re.findall(r"^- (\d+) `(\w+)`: .", PAGE, re.MULTILINE)
    assert stands == [(str(register.value), register.name) for register in Register]


def test_every_command_stands_there_and_no_other():
    lists = PAGE.partition("## Commands")[2].partition("## Registers")[0]
    stands = re.findall(r"^- ([\d, ]+): .", lists, re.MULTILINE)
    assert [int(number) for row in stands for number in row.split(",")] == list(JOBS)


def test_every_number_of_a_list_stands_at_its_register():
    for register, count in (
        (Register.ANSWER, len(Answer)),
        (Register.ERROR, len(Error)),
        (Register.PHASE, len(PHASES)),
    ):
        assert re.findall(r"\b(\d+) ", meaning(register)) == [str(k) for k in range(count)]
    for number, phase in enumerate(PHASES):
        assert f"{number} {phase}" in meaning(Register.PHASE)
