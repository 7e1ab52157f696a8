"""What the simulated robot does by itself."""

import socket
import time

import numpy as np
import pytest
from patient import in_threads
from waiting import PATIENCE, wait_until

from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.devices.abb_simulated.serve_program import ProgramClient
from workbench.devices.abb_socket.messages import REQUEST
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import LinkError
from workbench.plugins.robot_link import LinkPatience, Simulation


@pytest.fixture
def left_away():
    """Starts a controller whose right arm was left away from home, with a fault; its end."""

    def start(**how) -> SimulatedController:
        controller = SimulatedController(read_cell("yumi"), Simulation(speed=50.0, **how))
        home = np.asarray(controller._body.cell.arm("right").home)
        controller._body.put({"right": home + 0.5}, "")
        controller._body.halt("stopped by the client")
        return started(controller)

    with in_threads() as started:
        yield start


def test_arms_that_were_left_go_home_and_the_fault_is_over(left_away):
    controller = left_away(home_after=0.2)
    wait_until(controller._body.is_home)
    home = np.asarray(controller._body.cell.arm("right").home)
    state = controller.state()
    assert np.allclose(state["joints"]["right"], home)
    assert (state["fault"], state["moving"]) == ("", "")


def test_unless_it_is_asked_for_they_stay_like_a_real_one(left_away):
    controller = left_away()
    time.sleep(0.3)
    assert not controller._body.is_home()
    assert controller.state()["fault"] == "stopped by the client"


class Reset:
    """The connection of a client that has left with reports unread."""

    def recv(self, count):
        raise ConnectionResetError(104, "Connection reset by peer")


def test_a_client_that_resets_the_connection_has_left_and_is_no_fault_after_its_plan():
    client = object.__new__(ProgramClient)
    client._client, client._motion = Reset(), None
    assert not client._hear()
    client._motion = object()
    with pytest.raises(LinkError):
        client._hear()


def test_of_several_faults_the_first_is_told(left_away):
    body = left_away()._body
    body.halt("the connection was reset")
    assert body.state()["fault"] == "stopped by the client"
    body.halt("")
    assert body.state()["fault"] == ""


def test_a_client_that_never_says_anything_leaves_the_port_to_the_next():
    patience = LinkPatience(answer=0.2)
    with in_threads() as started:
        controller = started(
            SimulatedController(read_cell("yumi"), Simulation(speed=50.0), patience=patience)
        )
        address = ("127.0.0.1", controller.port)
        with socket.create_connection(address, PATIENCE) as silent:
            assert silent.recv(len(REQUEST)) == REQUEST
            assert silent.recv(1) == b"", "the controller closes the connection"
            with socket.create_connection(address, PATIENCE) as next_one:
                assert next_one.recv(len(REQUEST)) == REQUEST
