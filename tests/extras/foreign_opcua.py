"""A client of another make for OPC UA, node-opcua, and the official tables of the types (npm)."""

import json
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest
from waiting import PATIENCE

SCRIPT = Path(__file__).with_name("foreign_client.js")
PACKAGES = ("node-opcua-client", "node-opcua-nodesets")
XML = "{http://opcfoundation.org/UA/2011/03/UANodeSet.xsd}"
UA, ROBOTICS = "http://opcfoundation.org/UA/", "http://opcfoundation.org/UA/Robotics/"


@cache
def modules() -> Path:
    """Where npm has the packages; skips the test where they are not."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        pytest.skip("node is not installed")
    here = Path(__file__).parents[2] / "node_modules"
    asked = subprocess.run(["npm", "root", "-g"], capture_output=True, text=True, check=True)
    for folder in (here, Path(asked.stdout.strip())):
        if all((folder / name).is_dir() for name in PACKAGES):
            return folder
    pytest.skip(f"not installed: npm install -g {' '.join(PACKAGES)}")


def begin(url: str, *tasks, **about) -> subprocess.Popen[str]:
    """A client that begins with these tasks."""
    told = json.dumps({"url": url, "tasks": tasks, **about})
    folder = modules()
    return subprocess.Popen(
        ["node", str(SCRIPT), told],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"NODE_PATH": str(folder)},
    )


def answer(client: subprocess.Popen[str]):
    """What a client says at its end."""
    said, log = client.communicate(timeout=3 * PATIENCE)
    assert "@@" in said, log
    return json.loads(said.rpartition("@@")[2])


def foreign(url: str, *tasks, **about):
    """Run a client to its end."""
    return answer(begin(url, *tasks, **about))


class Official:
    """The nodes of official NodeSets, by `namespace|number`."""

    def __init__(self):
        self.nodes: dict[str, ElementTree.Element] = {}
        self._spaces: dict[int, list[str]] = {}
        self._names: dict[int, dict[str, str]] = {}
        for name in ("Opc.Ua.Di.NodeSet2.xml", "Opc.Ua.Robotics.NodeSet2.xml"):
            folder = modules() / "node-opcua-nodesets" / "nodesets"
            root = ElementTree.parse(folder / name).getroot()
            spaces = [UA, *(uri.text for uri in root.find(f"{XML}NamespaceUris"))]
            aliases = {one.get("Alias"): one.text for one in root.iter(f"{XML}Alias")}
            for node in root:
                if node.get("NodeId"):
                    self._spaces[id(node)], self._names[id(node)] = spaces, aliases
                    self.nodes[self.key(node, node.get("NodeId"))] = node

    def key(self, of: ElementTree.Element, text: str) -> str:
        """A NodeId as its file has it, as `namespace|number`."""
        text = self._names[id(of)].get(text, text)
        space, _, number = text.rpartition("i=")
        return f"{self._spaces[id(of)][int(space[3:-1] or 0) if space else 0]}|{number}"

    def name(self, of: ElementTree.Element) -> str:
        space, _, name = of.get("BrowseName").rpartition(":")
        return f"{self._spaces[id(of)][int(space or 0)]}|{name}"

    def references(self, of: ElementTree.Element, *kinds: str) -> list[str]:
        """Where the references of these kinds go, forwards; of HasSubtype: backwards."""
        return [
            self.key(of, one.text)
            for one in of.iter(f"{XML}Reference")
            if one.get("ReferenceType") in kinds
            and (one.get("IsForward") != "false") == ("HasSubtype" not in kinds)
        ]

    def kind(self, of: ElementTree.Element) -> str:
        return self.references(of, "HasTypeDefinition")[0]

    def declared(self, type_key: str, rule: int) -> list[ElementTree.Element]:
        """Members of a type and of those above it that have a modelling rule, by its number."""
        found = {}
        while type_key in self.nodes:
            node = self.nodes[type_key]
            for one in self.members(node, rule):
                found.setdefault(self.name(one), one)
            (type_key,) = self.references(node, "HasSubtype")
        return list(found.values())

    def members(self, node: ElementTree.Element, rule: int) -> list[ElementTree.Element]:
        there = self.references(node, "HasComponent", "HasProperty")
        return [
            self.nodes[key]
            for key in there
            if key in self.nodes
            and self.references(self.nodes[key], "HasModellingRule") == [f"{UA}|{rule}"]
        ]
