"""A controller whose reports by EGM cannot be, over UDP: the motion ends, and says why."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from egm_scenes import PATIENT, twin_of
from relays import between_datagrams
from waiting import wait_until

from workbench.devices.abb_egm import wire
from workbench.devices.abb_egm.link import AbbEgm
from workbench.devices.abb_egm.twin import free_ports
from workbench.model.errors import JobCancelled, LinkError
from workbench.plugins.robot_link import send, states

pytest.importorskip(
    "google.protobuf", reason="protobuf is not installed: pip install 'workbench[egm]'"
)


@contextmanager
def spoilt_twin(cell, spoil, speed=100.0, ports="port", **given):
    """The twin, and the cell with its controller behind somebody who changes reports.

    `spoil(twin, k, told)` gives the reports, or bytes, that come in place of one of arm `k`.
    """
    with twin_of(cell, speed=speed, **given) as (twin, there):
        here = free_ports("127.0.0.1", len(cell.arms))

        def changed(k, data):
            told = wire.read_feedback(data, len(cell.arms[k].joints))
            made = spoil(twin, k, told)
            return [one if isinstance(one, bytes) else wire.feedback_bytes(one) for one in made]

        at = getattr(there.controller, ports)
        with between_datagrams(at, here, len(cell.arms), changed):
            yield twin, replace(there, controller=replace(there.controller, **{ports: here}))


def with_axis(told, degrees):
    axes = np.array(told.axes)
    axes[2] = np.deg2rad(degrees)
    return replace(told, axes=axes)


class InLeg:
    """Spoils reports of the arm that moves: the `into`-th after a leg began, or from there on.

    `how(told)` gives what comes in place of it.  `held`: it comes with the next one, at once.
    """

    def __init__(self, how, leg=1, into=20, held=False, on=False):
        self._how, self._leg, self._into, self._held, self._on = how, leg, into, held, on
        self._back, self.count = [], 0

    def __call__(self, twin, k, told):
        if twin.arms[k].leg < self._leg:
            return [told]
        self.count += 1
        made = [told]
        if self.count == self._into or (self._on and self.count > self._into):
            made = self._how(told)
        if self.count == self._into and self._held:
            self._back = list(made)
            return []
        made, self._back = [*self._back, *made], []
        return made


IMPOSSIBLE = [1e308, -1e308, 1e306, 400.0, -200.0]
"""[deg] Of an axis that goes from -123.5 to 80 degrees, or so."""


def fault_of(cell, plan, approval, spoil, says, **given):
    """Send a plan while reports are spoilt; it ends by a fault, no leg was told to be done."""
    kinds = []
    with spoilt_twin(cell, spoil, **given) as (_, there), pytest.raises(LinkError, match=says):
        for receipt in send(plan, approval, there, patience=PATIENT):
            kinds.append(receipt.kind)
    assert set(kinds) <= {"order"}


@pytest.mark.parametrize("degrees", IMPOSSIBLE)
@pytest.mark.parametrize("held", [False, True], ids=["alone", "with a good one behind it"])
def test_a_joint_that_is_reported_where_it_cannot_be_ends_the_motion(planned, degrees, held):
    spoil = InLeg(lambda told: [with_axis(told, degrees)], held=held)
    fault_of(*planned, spoil, r"reports \S+ at \S+ degrees; it goes from")
