"""Groups of turns, against what the field's own definitions say of them."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.symmetry import BALL, NONE, ROUND, Symmetry, SymmetryAxis

X, Y, Z = np.eye(3)
CORNER = np.ones(3) / np.sqrt(3)
GOLDEN = np.array([0.0, 1.0, (1 + np.sqrt(5)) / 2])
GOLDEN /= np.linalg.norm(GOLDEN)

# Their names in SciPy, which makes the groups by tables of its own, with the main axis along z.
GROUPS = {
    "C1": Symmetry(),
    "C5": Symmetry(fold=5),
    "D2": Symmetry(fold=2, also=(SymmetryAxis(X, 2),)),
    "D4": Symmetry(fold=4, also=(SymmetryAxis(X, 2),)),
    "D7": Symmetry(fold=7, also=(SymmetryAxis(X, 2),)),
    "T": Symmetry(fold=2, also=(SymmetryAxis(CORNER, 3),)),
    "O": Symmetry(fold=4, also=(SymmetryAxis(CORNER, 3),)),
    "I": Symmetry(GOLDEN, 5, also=(SymmetryAxis(CORNER, 3),)),
}


def cosines(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Of the angles between each two rotations."""
    return (np.einsum("nij,mij->nm", one, other) - 1) / 2


@pytest.mark.parametrize("name", GROUPS)
def test_the_groups_are_those_of_scipy(name):
    ours = GROUPS[name].motions(1)[:, :3, :3]
    theirs = Rotation.create_group(name).as_matrix()
    assert len(ours) == len(theirs)
    # SciPy's icosahedron may be turned by a quarter about an axis of the cube.
    turned = [theirs, Rotation.from_euler("z", 90, degrees=True).as_matrix() @ theirs
              @ Rotation.from_euler("z", -90, degrees=True).as_matrix()]  # fmt: skip
    assert any((cosines(ours, one).max(axis=1) > 1 - 1e-9).all() for one in turned)


@pytest.mark.parametrize("name", GROUPS)
def test_products_of_turns_are_turns(name):
    found = GROUPS[name].motions(1)[:, :3, :3]
    products = np.array([a @ b for a, b in itertools.product(found, found)])
    assert (cosines(products, found).max(axis=1) > 1 - 1e-9).all()
    assert (np.triu(cosines(found, found), 1) < 1 - 1e-6).all(), "none is there twice"


def test_round_groups_are_told_by_their_axes():
    def form(*also: SymmetryAxis) -> tuple[str, str]:
        symmetry = Symmetry(fold=0, also=also)
        return symmetry.form, str(symmetry)

    assert form() == (ROUND, "C-inf")
    assert form(SymmetryAxis(X, 2)) == (ROUND, "D-inf")
    assert form(SymmetryAxis(-Z, 0)) == (ROUND, "C-inf")
    assert form(SymmetryAxis(X, 0)) == (BALL, "sphere")
    assert form(SymmetryAxis(X, 3)) == (BALL, "sphere")
    assert form(SymmetryAxis(CORNER, 2)) == (BALL, "sphere")
    assert Symmetry(fold=6).form == NONE
    assert [str(one) for one in (Symmetry(), Symmetry(fold=6), GROUPS["D4"])] == [
        "none",
        "C6",
        "D4",
    ]


def test_turns_leave_their_point_where_it_is():
    point = (0.01, -0.02, 0.03)
    for symmetry in (
        Symmetry(X, 2, point),
        Symmetry(fold=0, point=point, also=(SymmetryAxis(X, 2),)),
        Symmetry(fold=0, point=point, also=(SymmetryAxis(X, 0),)),
    ):
        for M in symmetry.motions(18):
            assert M @ [*point, 1.0] == pytest.approx([*point, 1.0])
        for _, motion in symmetry.turns:
            assert motion.act(np.array(point)) == pytest.approx(point)
        names = [name for name, _ in symmetry.turns]
        assert len(set(names)) == len(names) > 0
    assert Symmetry(X, 2, point).invariant_point(np.ones(3)) == pytest.approx([1.0, -0.02, 0.03])


def test_a_symmetry_stated_as_before_has_its_digest_of_before():
    plain = {"axis": np.array([0.0, 0.0, 1.0]), "fold": 6}
    assert digest_of(Symmetry(fold=6)) == digest_of(plain)
    assert digest_of(Symmetry(fold=6, point=(0.1, 0, 0))) != digest_of(plain)
    assert digest_of(GROUPS["D4"]) != digest_of(Symmetry(fold=4))


@pytest.mark.parametrize(
    ("symmetry", "says"),
    [
        (Symmetry(fold=-1), "0 to 360"),
        (Symmetry(np.zeros(3), 2), "unit axis"),
        (Symmetry(fold=2, also=(SymmetryAxis(np.array([2.0, 0, 0]), 2),)), "unit axis"),
        (Symmetry(fold=4, point=(np.nan, 0, 0)), "no place"),
        (Symmetry(fold=4, also=(SymmetryAxis(np.array([0.6, 0, 0.8]), 4),)), "more than 720"),
    ],
)
def test_axes_that_make_no_group_are_refused(symmetry, says):
    with pytest.raises(InputError, match=says):
        symmetry.check()
