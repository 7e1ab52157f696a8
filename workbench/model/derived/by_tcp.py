"""A cell by the TCPs that its tools work with: the other cups of a hand stay bodies of the tool."""

from collections.abc import Mapping
from copy import copy
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import Protocol

import pinocchio as pin

from workbench.model.cell import Cell, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import put
from workbench.model.messages.cells import CellText
from workbench.model.part import Grasp
from workbench.model.plan import Plan
from workbench.model.robot import Tcp


def tcp_names(tool: Tool) -> tuple[str, ...]:
    """The names of the TCPs of a tool, first one first; of a tool that names none, one empty."""
    return tuple(tcp.name for tcp in tool.tcps) or ("",)


def has_tcp(tool: Tool, name: str) -> bool:
    """Whether a tool has a TCP of that name; empty means its first one."""
    return not name or name in tcp_names(tool)


def is_for(grasp: Grasp, tool: Tool) -> bool:
    """Whether a grasp can be used with the current TCP of a tool."""
    return grasp.tcp in ("", tool.tcp)


def is_for_another(grasp: Grasp, tool: Tool) -> bool:
    """Whether a grasp is for a TCP of the tool that is not the current one."""
    return has_tcp(tool, grasp.tcp) and not is_for(grasp, tool)


def current_tcp(tool: Tool) -> Tcp:
    """The TCP that a tool works with."""
    unnamed = Tcp("", tool.T_flange_tcp)
    return next((tcp for tcp in tool.tcps if tcp.name == tool.tcp), unnamed)


def may_touch(tool: Tool, solid: str) -> bool:
    """Whether a solid of the tool may touch the part that the tool takes with its current TCP."""
    touches = current_tcp(tool).touches
    return not touches or solid in touches


@lru_cache(maxsize=64)
def with_tcp(tool: Tool, name: str) -> Tool:
    """The tool working with one of its TCPs, the same object each time; empty: with its first one.

    Raises:
        InputError: it has no such TCP; the message lists those it has.
    """
    name = name or tcp_names(tool)[0]
    if name == tool.tcp:
        return tool
    found = next((tcp for tcp in tool.tcps if tcp.name == name), None)
    if found is None:
        known = ", ".join(filter(None, tcp_names(tool))) or "one without a name"
        raise InputError(CellText.NO_TCP(tool=tool.name, name=repr(name), known=known))
    return replace(tool, T_flange_tcp=found.T_flange_tcp, tcp=name)


def from_current_tcp(tool: Tool, name: str) -> pin.SE3:
    """The pose of one of a tool's TCPs, seen from the current one; empty: of the first one.

    Raises:
        InputError: as `with_tcp`.
    """
    return tool.T_flange_tcp.actInv(with_tcp(tool, name).T_flange_tcp)


def with_tcp_at(tool: Tool, T_flange_tcp: pin.SE3) -> Tool:
    """The tool with its current TCP somewhere else."""
    moved = tuple(
        replace(tcp, T_flange_tcp=T_flange_tcp) if tcp.name == tool.tcp else tcp
        for tcp in tool.tcps
    )
    return replace(tool, T_flange_tcp=T_flange_tcp, tcps=moved)


def with_tcps(cell: Cell, names: Mapping[str, str]) -> Cell:
    """The cell with its arms' tools working with these TCPs, the same object each time.

    It keeps the digest: it is the same cell, of which a plan states the TCPs.  Arms that are not
    named work with the first TCP of their tool.

    Raises:
        InputError: a tool has no such TCP.
    """
    tcps = tuple(names.get(arm.name, "") for arm in cell.arms)
    tools = [with_tcp(arm.tool, tcp) for arm, tcp in zip(cell.arms, tcps, strict=True)]
    if all(arm.tool is tool for arm, tool in zip(cell.arms, tools, strict=True)):
        return cell
    return _with_tcps(cell, tcps)


@lru_cache(maxsize=32)
def _with_tcps(cell: Cell, tcps: tuple[str, ...]) -> Cell:
    arms = tuple(
        replace(arm, tool=with_tcp(arm.tool, tcp)) for arm, tcp in zip(cell.arms, tcps, strict=True)
    )
    made = copy(cell)
    put(made, arms=arms)
    return made


def by_each_tcp(cell: Cell) -> tuple[Cell, ...]:
    """The cell by all TCPs of its tools, the first ones first; alone where each tool has one."""
    names = [arm.name for arm in cell.arms]
    every = product(*(tcp_names(arm.tool) for arm in cell.arms))
    return tuple(with_tcps(cell, dict(zip(names, tcps, strict=True))) for tcps in every)


class Taking(Protocol):
    """What an arm does with a TCP: a candidate, its plan, or a leg of it."""

    @property
    def arm(self) -> str:
        """Its name."""
        ...

    @property
    def tcp(self) -> str:
        """That of its tool; empty: the first one."""
        ...


def by_taking(cell: Cell, taking: Taking) -> Cell:
    """The cell with the tool of an arm working with the TCP by which that takes a part.

    Raises:
        InputError: the tool has no such TCP.
    """
    return with_tcps(cell, {taking.arm: taking.tcp})


def by_plan(cell: Cell, plan: Plan) -> Cell:
    """The cell with its tools working with the TCPs that a plan states.

    Raises:
        InputError: a tool has no such TCP.
    """
    return with_tcps(cell, {arm.arm: arm.tcp for arm in plan.arms})
