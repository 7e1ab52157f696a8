"""Several kinds of parts in one bin."""

from dataclasses import replace

import numpy as np
import pytest
from drawn_shapes import cross, ell, hex_nut
from trimesh import Trimesh

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Detection, LocalizationResult, Objection, RejectedHypothesis
from workbench.model.symmetry import Symmetry
from workbench.perception.localization import localize
from workbench.perception.localization.hypotheses import find_hypotheses
from workbench.perception.localization.kinds import merged
from workbench.perception.localization.localize import PartSearchResult
from workbench.perception.parts.part_surface import prepare
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts
from workbench.studies.localization import compare

KINDS = tuple(read_part(name) for name in ("keyed_cylinder", "bracket", "bolt"))
CYLINDER, BRACKET, BOLT = KINDS


def drawn(name: str, shape: Trimesh):
    """A part of such a shape [m], otherwise like a bracket."""
    mesh = Mesh(np.asarray(shape.vertices), np.asarray(shape.faces))
    return replace(BRACKET, name=name, mesh=mesh, symmetry=Symmetry(fold=1))


def at(x: float, y: float = 0.0):
    return pose_from_rpy((x, y, 0.0))


@pytest.fixture(scope="module")
def mixed(cell):
    return replace(cell, parts=KINDS)


@pytest.mark.parametrize("seed", [3, 5])
def test_each_kind_is_found_as_what_it_is(mixed, seed):
    truth = drop_parts(KINDS * 2, mixed.bin, seed=seed)
    scan = synthesize(mixed, truth, seed=seed)
    told = []
    found = find_parts(
        scan, mixed, seed=0, report=lambda done, _: told.append(done), cancelled=lambda: False
    ).detections
    assert told == sorted(told)
    judged, is_found = compare(KINDS, truth, found)
    assert all(one.is_right for one in judged)
    assert is_found.count(False) <= 1


def test_where_another_kind_stands_nothing_more_is_looked_for(mixed, monkeypatch):
    """All six are found at the first look: of each kind's pixels hardly any are left."""
    left = {}

    def counted(depth_map, coarse_map, surface, *rest, seed):
        left[surface.diameter, seed[1]] = np.count_nonzero(depth_map.foreground)
        return find_hypotheses(depth_map, coarse_map, surface, *rest, seed=seed)

    monkeypatch.setattr(localize, "find_hypotheses", counted)
    truth = drop_parts(KINDS * 2, mixed.bin, seed=3)
    found = find_parts(synthesize(mixed, truth, seed=3), mixed, seed=0).detections
    assert len(found) == 6
    first = {diameter: count for (diameter, number), count in left.items() if number == 0}
    assert len(first) == 3
    assert all(count < 0.05 * first[of] for (of, number), count in left.items() if number)


@pytest.mark.extensive
def test_of_many_kinds_those_that_lie_there_are_looked_for_first(mixed, monkeypatch):
    """The others are looked for in what they leave, and not found."""
    left: dict[float, int] = {}

    def counted(depth_map, coarse_map, surface, *rest, seed):
        left.setdefault(surface.diameter, np.count_nonzero(depth_map.foreground))
        return find_hypotheses(depth_map, coarse_map, surface, *rest, seed=seed)

    monkeypatch.setattr(localize, "find_hypotheses", counted)
    others = (drawn("cross", cross()), drawn("ell", ell()), drawn("nut", hex_nut()))
    truth = drop_parts(KINDS * 2, mixed.bin, seed=3)
    many = replace(mixed, parts=(*others, *KINDS))
    judged, is_found = compare(
        many.parts, truth, find_parts(synthesize(mixed, truth, seed=3), many, seed=0).detections
    )
    assert all(one.is_right for one in judged) and all(is_found)
    first = [left.get(prepare(part).diameter, 0) for part in many.parts]
    assert max(first[:3]) < 0.5 * min(first[3:])


def searched(kind, *found, gains, rejected=()):
    return PartSearchResult(LocalizationResult(found, rejected), prepare(kind), gains)


def test_where_two_kinds_share_room_the_one_stands_that_more_surface_speaks_for():
    """The bolt fits better, by its score, but explains less."""
    cylinder, bolt = Detection("cylinder", at(0), 0.8), Detection("bolt", at(0), 0.95)
    far = Detection("bolt", at(0.2), 0.9)
    both = merged(
        [
            searched(BOLT, bolt, far, gains=(2e-4, 2e-4)),
            searched(CYLINDER, cylinder, gains=(9e-4,)),
        ]
    )
    assert both.detections == (far, cylinder)
    (lost,) = both.rejected
    assert (lost.part, str(lost.words)) == ("bolt", "reaches into another part: part-2")


def test_parts_of_one_kind_are_left_as_their_own_search_has_them():
    first, second = Detection("bolt", at(0), 0.9), Detection("bolt", at(0.001), 0.8)
    assert merged([searched(BOLT, first, second, gains=(1.0, 1.0))]).detections == (first, second)


def test_rivals_keep_their_numbers():
    one, other = Detection("bolt", at(0), 0.5), Detection("bracket", at(0.3), 0.9)
    twin = RejectedHypothesis("bolt", at(0), 0.4, Objection.TWIN, 0)
    outside = RejectedHypothesis("bracket", at(1), 0.6, Objection.OUTSIDE)
    both = merged(
        [
            searched(BOLT, one, gains=(1.0,), rejected=(twin,)),
            searched(BRACKET, other, gains=(1.0,), rejected=(outside,)),
        ]
    )
    assert both.detections == (other, one)
    assert [(d.part, str(d.words)) for d in both.rejected] == [
        ("bracket", "outside the bin"),
        ("bolt", "a twin with a worse score: part-2"),
    ]


def test_what_lost_to_one_that_lost_itself_names_the_one_that_stands():
    bolt, cylinder = Detection("bolt", at(0), 0.9), Detection("cylinder", at(0), 0.8)
    twin = RejectedHypothesis("bolt", at(0), 0.4, Objection.TWIN, 0)
    both = merged(
        [
            searched(BOLT, bolt, gains=(1e-4,), rejected=(twin,)),
            searched(CYLINDER, cylinder, gains=(9e-4,)),
        ]
    )
    assert both.detections == (cylinder,)
    assert [one.rival for one in both.rejected] == [0, 0]
