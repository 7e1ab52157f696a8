"""What is on record from older versions is read as it was written."""

import dataclasses

import numpy as np

from workbench.app.records import forms
from workbench.app.records.forms import restore_value
from workbench.model.digest import canonical
from workbench.model.geometry import Mesh, Shape
from workbench.model.messages.message import plain
from workbench.model.plan import Proof, Violation

DIGEST = "bbcced36e5953f26a40aae20872f6f3f08e010aaf561cdde875cda1e049cdb70"
"""Of the proof below, as a version made it that called a violation a finding."""


def test_what_a_proof_objected_to_is_on_record_by_its_first_name():
    q = np.array([0.1, 0.2])
    near = Violation(
        plain("smallest clearance"), "right", "reach", 1, ("link", "bin_floor"), 0.006, q
    )
    bent = Violation(plain("is not straight"), "right", "home", 0)
    proof = Proof("plan", "cell", "scan", 3, 0.0005, 0.0058, near, (bent,))
    assert proof.digest == DIGEST
    form = canonical(proof)
    assert [one["problem"] for one in form["findings"]] == ["is not straight"]
    again = restore_value(Proof, form, read=lambda digest: b"")
    assert again.digest == DIGEST and not again.holds
    assert [str(one) for one in again.violations] == [
        "arm right leg home after waypoint 0: is not straight"
    ]


def test_a_mesh_on_record_from_before_it_had_pieces_is_one():
    tip = Mesh(np.eye(4, 3), [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]], is_convex=True)
    form = canonical(tip)
    assert "pieces" not in form
    again = restore_value(Shape, form, read=lambda digest: b"")
    assert isinstance(again, Mesh) and again.is_convex and again.pieces == ()
    assert canonical(again) == form


def test_the_fields_of_a_kind_are_read_once_however_many_values_are_on_record(monkeypatch):
    asked, fields = [], dataclasses.fields

    def counted(kind):
        asked.append(kind)
        return fields(kind)

    @dataclasses.dataclass(frozen=True)
    class Weight:
        mass: float
        name: str = "bolt"

    monkeypatch.setattr(forms.dataclasses, "fields", counted)
    read = [restore_value(Weight, {"mass": mass}, read=lambda digest: b"") for mass in range(50)]
    assert read == [Weight(mass) for mass in range(50)]
    assert asked == [Weight]
