"""The foreign package `ABBRobotEGM` reads what we write, and moves our twin."""

import numpy as np
import pytest
from egm_scenes import twin_of

from workbench.devices.abb_egm import wire
from workbench.model.errors import LinkError

egm = pytest.importorskip("ABBRobotEGM", reason="pip install ABBRobotEGM")
messages = pytest.importorskip("ABBRobotEGM._egm_protobuf.egm_pb2")

AXES = np.deg2rad([1.0, -2.0, 3.0, 4.5, 5.0, 6.0, 7.0])


def test_every_field_has_the_number_and_kind_that_the_foreign_package_knows():
    for name, fields in wire.FIELDS.items():
        theirs = messages.DESCRIPTOR.message_types_by_name[name].fields_by_name
        for field, (number, kind, _) in fields.items():
            assert (theirs[field].number, theirs[field].type) == (number, kind), (name, field)


def test_a_reference_is_read_by_the_foreign_package():
    data = wire.reference_bytes(wire.Reference(7, AXES, (1.0, 2.0)), 4004)
    read = messages.EgmSensor.FromString(data)
    assert (read.header.seqno, read.header.tm) == (7, 4004)
    assert read.header.mtype == messages.EgmHeader.MessageType.Value("MSGTYPE_CORRECTION")
    assert list(read.planned.joints.joints) == pytest.approx([1, -2, 3, 4.5, 5, 6])
    assert list(read.planned.externalJoints.joints) == pytest.approx([7]), "axis 7 is external"
    assert list(read.RAPIDtoRobot.dnum) == [1.0, 2.0]


def test_a_report_of_the_foreign_package_is_read_with_all_that_we_do_not_need():
    one = messages.EgmRobot()
    one.header.seqno, one.header.tm = 4_294_967_295, 12
    one.feedBack.joints.joints.extend([1, -2, 3, 4.5, 5, 6])
    one.feedBack.externalJoints.joints.extend([7])
    one.feedBack.cartesian.pos.x, one.feedBack.cartesian.pos.y = 1.0, 2.0
    one.feedBack.cartesian.pos.z = 3.0
    one.testSignals.signals.extend([1.0, 2.0])
    one.motorState.state, one.mciState.state, one.rapidExecState.state = 1, 3, 2
    one.mciConvergenceMet, one.utilizationRate = True, 12.0
    one.RAPIDfromRobot.dnum.extend([1.0, 5.0, 2.0])
    told = wire.read_feedback(one.SerializeToString(), 7)
    assert told.number == 4_294_967_295 and told.at == 12 and told.fault == ""
    assert (
        told.axes == pytest.approx(AXES)
        and told.rapid_values == (1.0, 5.0, 2.0)
        and told.is_converged
    )
    one.motorState.state = 2
    assert wire.read_feedback(one.SerializeToString(), 7).fault == "the motors are off"


@pytest.mark.parametrize("spoilt", ["short", "axes", "nan", "noise", "empty"])
def test_a_report_that_makes_no_sense_is_refused(spoilt):
    good = wire.Feedback(1, 4, AXES, 1, 3, 2, True, (1.0, 0.0, 0.0))
    bad = {
        "short": wire.feedback_bytes(good)[:-5],
        "axes": wire.feedback_bytes(wire.Feedback(1, 4, AXES[:6], 1, 3, 2, True, ())),
        "nan": wire.feedback_bytes(wire.Feedback(1, 4, AXES * np.nan, 1, 3, 2, True, ())),
        "noise": np.random.default_rng(1).bytes(200),
        "empty": b"",
    }[spoilt]
    with pytest.raises(LinkError):
        wire.read_feedback(bad, 7)


def test_the_foreign_sensor_moves_the_twin_and_gives_its_module_orders(planned):
    cell, _, _ = planned
    with twin_of(cell, speed=4.0) as (twin, _), egm.EGM(port=twin.port) as sensor:
        heard, state = sensor.receive_from_robot(5.0)
        assert heard and state.motors_on and state.rapid_running and state.mci_state == 3
        start = np.deg2rad([*state.joint_angles, *state.external_axes])
        assert start == pytest.approx(cell.arms[0].to_axes(cell.arms[0].home))
        goal = np.rad2deg(start) + [1, 0, 0, 0, 0, -1, 2]
        for _ in range(150):
            heard, state = sensor.receive_from_robot(5.0)
            assert heard
            orders = [wire.VERSION, 99.0, 1.0, wire.BEGIN, 0.0, 0.0]
            assert sensor.send_to_robot(
                goal[:6], external_joints=goal[6:], rapid_to_robot=np.array(orders)
            )
        reached = [*state.joint_angles, *state.external_axes]
        assert reached == pytest.approx(goal, abs=0.05) and state.mci_convergence_met
        assert list(state.rapid_from_robot) == [wire.VERSION, 99.0, 1.0, 0.0], "none is refused"
        assert twin.arms[0].orders == [tuple(orders)], "said many times, done once"
