"""The types of the tables as nodes of a server, under the NodeIds that the standards gave them."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from asyncua import ua
from asyncua.server.server import Server
from asyncua.ua.object_ids import ObjectIds

from workbench.extras.opcua.robotics.di_types import DEVICE_SET
from workbench.extras.opcua.robotics.robotics_types import ENUMERATIONS, REFERENCES
from workbench.extras.opcua.robotics.tables import URIS, NodeType, Ref, TypeMember, types

RULES = {"M": 78, "O": 80, "OP": 11508, "MP": 11510}
"""Objects of OPC UA itself that are the modelling rules (OPC 10000-3, 6.4.4)."""

METADATA = {
    "di": (15001, "1.05.0", datetime(2025, 11, 15, tzinfo=UTC)),
    "rob": (15011, "1.02", datetime(2025, 9, 8, tzinfo=UTC)),
}
"""By prefix: number of the object about the namespace, its version and the day that it came out."""

METADATA_OWN: dict[str, tuple[int, ...]] = {
    "di": (15002, 15003, 15004, 15005, 15006, 15007, 15008),
    "rob": (15034, 15064, 15091, 15114, 15145, 15173, 15209),
}
"""Numbers of what `_metadata` says of it, in that order."""


@dataclass(frozen=True, slots=True)
class NodeSpace:
    """A server to which nodes are added; `indices` are those of namespaces, by prefix."""

    server: Server
    indices: dict[str, int]
    types: dict[Ref, NodeType]

    def id_of(self, ref: Ref) -> ua.NodeId:
        """The NodeId of a node of a standard."""
        return ua.NodeId(ua.Int32(ref[1]), ua.Int16(self.indices[ref[0]]))

    def reference(self, name: str) -> ua.NodeId:
        """The NodeId of a type of references."""
        for number, (known, *_) in REFERENCES.items():
            if known == name:
                return self.id_of(("rob", number))
        return ua.NodeId(ua.Int32(getattr(ObjectIds, name)))

    def data_type(self, name: str) -> ua.NodeId:
        """The NodeId of a data type, by its name or as the tables have it."""
        if ":" in name:
            return ua.NodeId(ua.Int32(int(name.partition(":")[2])))
        for number, (known, *_) in ENUMERATIONS.items():
            if known == name:
                return self.id_of(("rob", number))
        return ua.NodeId(ua.Int32(getattr(ObjectIds, name)))

    async def add(
        self,
        above: ua.NodeId,
        reference: str,
        node: ua.NodeId,
        called: tuple[str, str],
        attributes: Any,
        kind: ua.NodeId | None = None,
    ) -> ua.NodeId:
        """Add a node.

        Args:
            above: the node that the reference goes out from.
            reference: name of its type.
            node: the NodeId of the new one.
            called: prefix of the namespace of its name, and the name.
            attributes: of asyncua, which tell what class of node it is.
            kind: its type definition, if it has one.
        """
        attributes.DisplayName = ua.LocalizedText(called[1])
        item = ua.AddNodesItem()
        item.ParentNodeId, item.ReferenceTypeId = above, self.reference(reference)
        item.RequestedNewNodeId = node
        item.BrowseName = ua.QualifiedName(called[1], ua.UInt16(self.indices[called[0]]))
        item.NodeClass = CLASSES[type(attributes)]
        item.NodeAttributes = attributes
        item.TypeDefinition = kind or ua.NodeId()
        (result,) = await self.server.iserver.isession.add_nodes([item])
        result.StatusCode.check()
        return node

    async def refer(self, source: ua.NodeId, reference: str, target: ua.NodeId) -> None:
        """Add a reference between two nodes, seen from both."""
        items: list[ua.AddReferencesItem] = []
        for start, end, is_forward in ((source, target, True), (target, source, False)):
            item = ua.AddReferencesItem()
            item.SourceNodeId, item.TargetNodeId, item.IsForward = start, end, is_forward
            item.ReferenceTypeId = self.reference(reference)
            item.TargetNodeClass = ua.NodeClass.Unspecified
            items.append(item)
        for status in await self.server.iserver.isession.add_references(items):
            status.check()


CLASSES = {
    ua.ObjectAttributes: ua.NodeClass.Object,
    ua.VariableAttributes: ua.NodeClass.Variable,
    ua.ObjectTypeAttributes: ua.NodeClass.ObjectType,
    ua.DataTypeAttributes: ua.NodeClass.DataType,
    ua.ReferenceTypeAttributes: ua.NodeClass.ReferenceType,
}


async def standard_space(server: Server, indices: dict[str, int]) -> NodeSpace:
    """Add the namespaces and their types to a server that has begun.

    Args:
        server: gets the nodes.
        indices: those of further namespaces that names may be of, by prefix.
    """
    own = {prefix: await server.register_namespace(uri) for prefix, uri in URIS.items()}
    space = NodeSpace(server, {"ua": 0, **own, **indices}, types())
    for number, (name, inverse, above) in REFERENCES.items():
        attributes = ua.ReferenceTypeAttributes()
        attributes.IsAbstract, attributes.Symmetric = False, name == inverse
        attributes.InverseName = ua.LocalizedText(inverse)
        node, base = space.id_of(("rob", number)), space.id_of(("ua", above))
        await space.add(base, "HasSubtype", node, ("rob", name), attributes)
    for number, (name, strings, words) in ENUMERATIONS.items():
        node, base = space.id_of(("rob", number)), ua.NodeId(ua.Int32(ObjectIds.Enumeration))
        await space.add(base, "HasSubtype", node, ("rob", name), ua.DataTypeAttributes())
        texts = variable(space, "LocalizedText", [ua.LocalizedText(word) for word in words])
        await _property(space, node, strings, "EnumStrings", texts)
    # All first, then what they have: members are of types that may stand further below.
    for node_type in space.types.values():
        attributes = ua.ObjectTypeAttributes()
        attributes.IsAbstract = node_type.is_abstract
        called = node_type.ref[0], node_type.name
        await space.add(
            space.id_of(node_type.above),
            "HasSubtype",
            space.id_of(node_type.ref),
            called,
            attributes,
        )
    for node_type in space.types.values():
        await _add_members(space, space.id_of(node_type.ref), node_type.ref[0], node_type.members)
        for interface in node_type.interfaces:
            await space.refer(space.id_of(node_type.ref), "HasInterface", space.id_of(interface))
    await space.add(
        ua.NodeId(ua.Int32(ObjectIds.ObjectsFolder)),
        "Organizes",
        space.id_of(("di", DEVICE_SET)),
        ("di", "DeviceSet"),
        ua.ObjectAttributes(),
        space.id_of(("ua", 58)),
    )
    for prefix in URIS:
        await _metadata(space, prefix)
    return space


def variable(space: NodeSpace, data_type: str, value: Any = None) -> ua.VariableAttributes:
    """Attributes of a variable that clients read; without a value it has none yet."""
    attributes = ua.VariableAttributes()
    attributes.DataType = space.data_type(data_type)
    is_array = isinstance(value, list)
    attributes.ValueRank = ua.Int32(1 if is_array else -1)
    attributes.ArrayDimensions = [ua.UInt32(0)] if is_array else []
    attributes.Value = value if isinstance(value, ua.Variant) else ua.Variant(value)
    reading = ua.Byte(ua.AccessLevel.CurrentRead.mask)
    attributes.AccessLevel = attributes.UserAccessLevel = reading
    return attributes


async def _add_members(
    space: NodeSpace, above: ua.NodeId, prefix: str, members: Sequence[TypeMember]
) -> None:
    """What a type has, as declarations; numbers are of the namespace `prefix`."""
    for member in members:
        node = space.id_of((prefix, member.number))
        attributes: Any = ua.ObjectAttributes()
        if member.data_type:
            attributes = variable(space, member.data_type)
        kind = space.id_of(member.kind)
        await space.add(
            above, member.reference, node, (member.prefix, member.name), attributes, kind
        )
        await space.refer(node, "HasModellingRule", space.id_of(("ua", RULES[member.rule])))
        await _add_members(space, node, prefix, member.members)


async def _metadata(space: NodeSpace, prefix: str) -> None:
    """Say in Server/Namespaces what the namespace is, and that not all of it is here."""
    number, version, published = METADATA[prefix]
    node = space.id_of((prefix, number))
    above = ua.NodeId(ua.Int32(ObjectIds.Server_Namespaces))
    kind = ua.NodeId(ua.Int32(ObjectIds.NamespaceMetadataType))
    await space.add(
        above, "HasComponent", node, (prefix, URIS[prefix]), ua.ObjectAttributes(), kind
    )
    numeric = ua.Variant([ua.IdType.Numeric], ua.VariantType.Int32)
    said: tuple[tuple[str, str, Any], ...] = (
        ("NamespaceUri", "String", URIS[prefix]),
        ("NamespaceVersion", "String", version),
        ("NamespacePublicationDate", "DateTime", published),
        ("IsNamespaceSubset", "Boolean", True),
        ("StaticNodeIdTypes", "IdType", numeric),
        ("StaticNumericNodeIdRange", "NumericRange", ["1:2147483647"]),
        ("StaticStringNodeIdPattern", "String", ""),
    )
    for own, (name, data_type, value) in zip(METADATA_OWN[prefix], said, strict=True):
        attributes = variable(space, data_type, value)
        if name == "StaticNodeIdTypes":
            attributes.ValueRank, attributes.ArrayDimensions = ua.Int32(1), [ua.UInt32(0)]
        await _property(space, node, own, name, attributes, prefix)


async def _property(
    space: NodeSpace,
    above: ua.NodeId,
    number: int,
    name: str,
    attributes: ua.VariableAttributes,
    prefix: str = "rob",
) -> None:
    node, kind = space.id_of((prefix, number)), space.id_of(("ua", 68))
    await space.add(above, "HasProperty", node, ("ua", name), attributes, kind)
