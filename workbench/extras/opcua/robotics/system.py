"""The one motion device system of a server: its nodes, made from the types, and their values."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from asyncua import ua

from workbench.app.core.state import State
from workbench.app.runtime.live import Live
from workbench.extras.opcua.robotics.di_types import DEVICE_SET
from workbench.extras.opcua.robotics.readings import (
    CONTROLLER,
    SAFETY,
    TASK,
    UNKNOWN,
    Path,
    Reading,
    axis_names,
    names,
    readings,
    train_names,
)
from workbench.extras.opcua.robotics.space import NodeSpace, variable
from workbench.extras.opcua.robotics.tables import Ref, TypeMember
from workbench.model.cell import Cell

SYSTEM = "MotionDeviceSystem"
OWN = "own"
"""Prefix of the namespace that nodes of the cell are in."""

SYSTEM_TYPE: Ref = ("rob", 1002)


class System:
    """A MotionDeviceSystem in the DeviceSet.

    Lifetime: empty until `write_changes`, which makes the nodes anew where the arms are other ones.

    Concurrency: used by the event loop of the server alone.
    """

    def __init__(self, space: NodeSpace) -> None:
        """A system in a space whose prefix `own` is that of the cell's namespace."""
        self._space = space
        self._shape: Any = None
        # Of what a type leaves open a system has what is known.
        self._optional: frozenset[Path] = frozenset()
        self._names: Mapping[Path, Sequence[str]] = {}
        self._nodes: dict[Path, ua.NodeId] = {}
        self._variables: set[Path] = set()
        self._told: dict[Path, Reading] = {}

    async def write_changes(self, state: State, live: Live) -> None:
        """Write what has changed."""
        shape, known = _shape(state.cell), readings(state, live)
        if shape != self._shape:
            self._optional = frozenset(known)
            await self._remake(state.cell)
            self._shape = shape
        for path in self._variables:
            reading = known.get(path, UNKNOWN)
            if self._told.get(path) != reading:
                value = ua.DataValue(
                    ua.Variant(reading.value, reading.kind),
                    ua.StatusCode(ua.UInt32(reading.status)),
                )
                await self._space.server.write_attribute_value(self._nodes[path], value)
                self._told[path] = reading

    async def _remake(self, cell: Cell) -> None:
        items: list[ua.DeleteNodesItem] = []
        for path, node in self._nodes.items():
            item = ua.DeleteNodesItem()
            # All but the system itself are known to one another alone, and go together.
            item.NodeId, item.DeleteTargetReferences = node, not path
            items.append(item)
        if items:
            await self._space.server.iserver.isession.delete_nodes(ua.DeleteNodesParameters(items))
        self._nodes, self._variables, self._told = {}, set(), {}
        self._names = names(cell)
        above = self._space.id_of(("di", DEVICE_SET))
        await self._add_object(above, "HasComponent", (), (OWN, SYSTEM), SYSTEM_TYPE, ())
        await self._refer(cell)

    async def _add_object(
        self,
        above: ua.NodeId,
        reference: str,
        path: Path,
        called: tuple[str, str],
        kind: Ref,
        declared: Sequence[TypeMember],
    ) -> None:
        """Add an object of a kind, with what the kind and its declaration say that it has."""
        node = await self._add(above, reference, path, called, ua.ObjectAttributes(), kind)
        for member in self._members(kind, declared):
            if member.is_placeholder:
                # The others stand for references between what is somewhere else (`_refer`).
                if member.reference == "HasComponent":
                    for name in self._fillings(path, member):
                        await self._add_object(
                            node, "HasComponent", (*path, name), (OWN, name), member.kind, ()
                        )
            elif member.rule == "M" or (*path, member.name) in self._optional:
                await self._add_member(node, path, member)

    async def _add_member(self, above: ua.NodeId, path: Path, member: TypeMember) -> None:
        own, called = (*path, member.name), (member.prefix, member.name)
        if not member.data_type:
            await self._add_object(
                above, member.reference, own, called, member.kind, member.members
            )
            return
        attributes = variable(self._space, member.data_type)
        node = await self._add(above, member.reference, own, called, attributes, member.kind)
        self._variables.add(own)
        for inner in member.members:
            if inner.rule == "M":
                await self._add_member(node, own, inner)

    async def _add(
        self,
        above: ua.NodeId,
        reference: str,
        path: Path,
        called: tuple[str, str],
        attributes: Any,
        kind: Ref,
    ) -> ua.NodeId:
        identifier = ua.String("/".join((SYSTEM, *path)))
        node = ua.NodeId(identifier, ua.Int16(self._space.indices[OWN]))
        of_kind = self._space.id_of(kind)
        self._nodes[path] = await self._space.add(
            above, reference, node, called, attributes, of_kind
        )
        return node

    def _members(self, kind: Ref, declared: Sequence[TypeMember]) -> Iterator[TypeMember]:
        """What objects of a kind have: the most derived declaration of each name."""
        seen: set[str] = set()
        of_kinds = list(declared)
        while kind in self._space.types:
            of_kinds += self._space.types[kind].members
            kind = self._space.types[kind].above
        for member in of_kinds:
            if member.name not in seen:
                seen.add(member.name)
                yield member

    def _fillings(self, path: Path, member: TypeMember) -> Sequence[str]:
        return self._names.get(path, ()) if member.rule == "MP" else ()

    async def _refer(self, cell: Cell) -> None:
        """Say which controller controls which arm, and what moves which axis."""
        controller: Path = ("Controllers", CONTROLLER)
        task: Path = (*controller, "TaskControls", TASK)
        said = [(controller, "HasSafetyStates", ("SafetyStates", SAFETY))]
        for arm in cell.arms:
            own: Path = ("MotionDevices", arm.name)
            said += [(controller, "Controls", own), (task, "Controls", own)]
            for axis, train in zip(axis_names(arm), train_names(arm), strict=True):
                axis_path, train_path = (*own, "Axes", axis), (*own, "PowerTrains", train)
                said += [(train_path, "Moves", axis_path), (axis_path, "Requires", train_path)]
        for source, reference, target in said:
            await self._space.refer(self._nodes[source], reference, self._nodes[target])


def _shape(cell: Cell) -> Any:
    """What the nodes depend on."""
    arms = tuple((arm.name, arm.joints, arm.axis_order) for arm in cell.arms)
    return arms
