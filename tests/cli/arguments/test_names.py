"""Choices that are repeated for a quick `--help` are those that the program knows."""

import typing

from workbench.cli.arguments import names
from workbench.model.cell import ORDER_NAMES


def test_the_choices_are_the_same():
    assert typing.get_args(names.OrderName) == ORDER_NAMES
