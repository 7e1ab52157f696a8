"""OPC UA for Robotics as a client of another make finds it, held against the official NodeSets."""

import dataclasses
import math
import time

import pytest
from foreign_opcua import ROBOTICS, UA, Official, answer, begin, foreign
from patient import PATIENT, in_threads
from prepared_bench import Canned
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StopSending
from workbench.app.core.people import Person, Role
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.robot_link import LinkRunner
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.extras.opcua.admission import OpcUaOptions
from workbench.extras.opcua.robotics.tables import types
from workbench.extras.opcua.server import OpcUa
from workbench.journal.journal import Journal
from workbench.plugins.robot_link import Simulation

SYSTEM = "ns=2;s=MotionDeviceSystem"
KINDS = (1002, 1003, 1004, 16601, 16794, 1019, 1013, 1011, 18175)
MANDATORY, PLACEHOLDER = 78, 11510
OBJECT, VARIABLE = 1, 2


class Linked(Canned):
    """Canned results, and a link to a controller that moves."""

    def __init__(self, results, do):
        super().__init__(results, do)
        self._link = LinkRunner(results.cell, do, time.time, self._show, patience=PATIENT)

    def _show(self, **about):
        self.live = dataclasses.replace(self.live, **about)

    def _answer(self, effect):
        match effect:
            case Send(plan=plan, approval=approval):
                self._link.send(plan, approval)
            case StopSending():
                self._link.stop()
            case _:
                super()._answer(effect)

    def close(self):
        self._link.close()
        super().close()


@pytest.fixture(scope="module")
def moving(results, tmp_path_factory):
    """A bench whose robot is a simulated controller, and the address of its OPC UA."""
    session = tmp_path_factory.mktemp("robotics") / "session"
    with in_threads() as started:
        simulated = started(
            SimulatedController(results.cell, Simulation(speed=4), patience=PATIENT)
        )
        ports = {"port": simulated.port, "state_port": simulated.state_port}
        controller = dataclasses.replace(results.cell.controller, host="127.0.0.1", **ports)
        cell = dataclasses.replace(results.cell, controller=controller)
        here = dataclasses.replace(results, cell=cell)
        bench = Bench(cell, Journal(session), effects=lambda cell, do, now: Linked(here, do))
        server = OpcUa(bench, OpcUaOptions(0, Person("plc", Role.OPERATOR)))
        yield bench, server.url
        server.close()
        bench.close()


@pytest.fixture(scope="module")
def official():
    return Official()


def approved(bench) -> str:
    """The digest of a plan that may go out."""
    for command in (TakeScan(), FindParts(), MakePlan()):
        bench.do(command, "ada")
        bench.wait(lambda state: state.job is None, PATIENCE)
    digest = bench.state.plan.digest
    bench.do(WatchPlan(digest), "ada")
    bench.do(Approve(digest), "ada")
    return digest


def test_nothing_mandatory_is_missing_and_axes_are_followed_as_they_move(moving, official):
    bench, url = moving
    wait_until(lambda: bench.live.joints)
    digest = approved(bench)
    place = next(k for k, joint in enumerate(bench.state.cell.arms[0].axis_order) if joint == 0)
    arm = bench.state.cell.arms[0].name
    axis = f"{SYSTEM}/MotionDevices/{arm}/Axes/Axis{place + 1}/ParameterSet/ActualPosition"
    watching = begin(url, {"what": "changes", "node": axis, "count": 5})
    assert "listening" in iter_until(watching.stderr, "listening")
    bench.do(SendPlan(digest), "ada")
    seen = answer(watching)["answers"][0]
    assert {one["status"] for one in seen} == {"Good"}
    assert len({one["value"] for one in seen}) == 5
    bench.wait(lambda state: state.phase is not Phase.SENDING, 3 * PATIENCE)
    assert bench.state.fault == ""
    (nodes,) = foreign(url, {"what": "tree", "node": SYSTEM})["answers"]
    tree = {tuple(one["path"]): one for one in nodes}
    assert tree[()]["type"] == f"{ROBOTICS}|1002"
    kinds = {one["type"] for one in tree.values() if one["type"].startswith(ROBOTICS)}
    assert kinds == {f"{ROBOTICS}|{number}" for number in KINDS}
    missing = [one for node in tree.values() for one in lacking(official, tree, node)]
    assert missing == []
    check_values(bench, tree)


def iter_until(stream, word) -> str:
    for line in stream:
        if word in line:
            return line
    return ""


def lacking(official, tree, node, declared=None) -> list[str]:
    """What the official type of a node declares as mandatory and the node has otherwise."""
    found = []
    if declared is None:
        declared = official.declared(node.get("type", ""), MANDATORY)
        found += unfilled(official, tree, node, official.declared(node["type"], PLACEHOLDER))
    for one in declared:
        path = (*node["path"], official.name(one))
        there = tree.get(path)
        if there is None:
            found.append(f"missing: {path}")
            continue
        if there["type"] != official.kind(one):
            found.append(f"{path} is of type {there['type']}")
        is_variable = one.tag.endswith("UAVariable")
        if there["nodeClass"] != (VARIABLE if is_variable else OBJECT):
            found.append(f"{path} is of class {there['nodeClass']}")
        wanted = official.key(one, one.get("DataType", "i=24"))
        if is_variable and there["dataType"] != wanted:
            found.append(f"{path} has data type {there['dataType']}, not {wanted}")
        found += unfilled(official, tree, there, official.members(one, PLACEHOLDER))
        found += lacking(official, tree, there, official.members(one, MANDATORY))
    return found


def unfilled(official, tree, node, placeholders) -> list[str]:
    """Placeholders of which a node has nothing, though one at least is mandatory."""
    below = [one for path, one in tree.items() if path[:-1] == tuple(node["path"]) and path]
    return [
        f"nothing for {official.name(one)} in {node['path']}"
        for one in placeholders
        if not any(there.get("type") == official.kind(one) for there in below)
    ]


def check_values(bench, tree):
    """Joints are told in degrees, and what no link reports has no value."""
    flat = {"/".join(name.partition("|")[2] for name in path): one for path, one in tree.items()}
    for arm in bench.state.cell.arms:
        for place, (joint, sign) in enumerate(zip(arm.axis_order, arm.axis_signs, strict=True)):
            own = f"MotionDevices/{arm.name}/Axes/Axis{place + 1}"
            position = flat[f"{own}/ParameterSet/ActualPosition"]
            is_at = sign * bench.live.joints[arm.joints[joint]]
            assert math.isclose(position["value"], math.degrees(is_at), abs_tol=1e-6)
            unit = flat[f"{own}/ParameterSet/ActualPosition/EngineeringUnits"]["value"]
            assert (unit["unitId"], unit["displayName"]["text"]) == (17476, "°")
            assert flat[f"{own}/MotionProfile"]["value"] == 1
    for name in ("EmergencyStop", "OperationalMode", "ProtectiveStop"):
        one = flat[f"SafetyStates/SafetyState/ParameterSet/{name}"]
        assert (one["status"], one["value"]) == ("BadNotConnected", None)
    controls = [
        one["to"].rpartition("/")[2]
        for one in flat["Controllers/Controller"]["references"]
        if one["by"] == f"{ROBOTICS}|4002"
    ]
    assert controls == [arm.name for arm in bench.state.cell.arms]


def test_the_types_are_those_of_the_official_nodesets(moving, official):
    _, url = moving
    prefixes = {"di": "http://opcfoundation.org/UA/DI/", "rob": ROBOTICS}
    keys = [f"{prefixes[prefix]}|{number}" for prefix, number in types()]
    # What a type has below a placeholder repeats the type of the placeholder.
    wanted = {key: official.nodes[key] for key in keys}
    for key in keys:
        below = official.members(official.nodes[key], MANDATORY)
        while below:
            wanted |= {official.key(one, one.get("NodeId")): one for one in below}
            below = [inner for one in below for inner in official.members(one, MANDATORY)]
    spaces = [UA, "", "", prefixes["di"], ROBOTICS]
    nodes = [
        f"ns={spaces.index(key.partition('|')[0])};i={key.partition('|')[2]}" for key in wanted
    ]
    told, read = foreign(url, {"what": "namespaces"}, {"what": "read", "nodes": nodes})["answers"]
    assert (told[3], told[4], len(read) > 70) == (*spaces[3:], True)
    for (key, one), there in zip(wanted.items(), read, strict=True):
        assert there, f"{key} {one.get('BrowseName')} is missing"
        assert f"{spaces[there['space']]}|{there['name']}" == official.name(one), key
        if one.tag.endswith("UAVariable"):
            space, _, number = there["dataType"].rpartition("i=")
            found = f"{spaces[int(space[3:-1] or 0) if space else 0]}|{number}"
            assert found == official.key(one, one.get("DataType", "i=24")), key
