"""Order of pairs: trees of two colours, general, separable and of second-order systems."""

import copy
import re
from dataclasses import replace
from fractions import Fraction as F
from typing import Any

import numpy as np
import pytest

from glmref.catalogue.lookup import document, load, names
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, UsageError
from glmref.exact import Ball, exact
from glmref.findings import Proof, Verdict
from glmref.method import PartitionedGLM
from glmref.method.component import SEPARABLE
from glmref.method.families import splitting
from glmref.prove.beside import known_beside
from glmref.prove.kernel import Kernel
from glmref.prove.verifier import facts_for
from glmref.theory.order import OrderResult, order_of
from glmref.theory.stability import oscillator, parasitic_curvature
from glmref.theory.trees import counted, is_nystrom, trees
from tests.bseries import order_residuals
from tests.build import refused
from tests.shipped import shipped


def pair(A, b, A_hat, b_hat, *, separable=False):
    return PartitionedGLM(
        A=A, U=[[1]] * len(A), B=[b], V=[[1]],
        A_hat=A_hat, U_hat=[[1]] * len(A_hat), B_hat=[b_hat], V_hat=[[1]],
        separable=separable,
    )  # fmt: skip


def symplectic_euler(*, separable):
    return pair([[1]], [1], [[0]], [1], separable=separable)


VERLET = ([[0, 0], ["1/2", "1/2"]], ["1/2", "1/2"], [["1/2", 0], ["1/2", 0]], ["1/2", "1/2"])
LOBATTO_3 = (
    [[0, 0, 0], ["5/24", "1/3", "-1/24"], ["1/6", "2/3", "1/6"]],
    ["1/6", "2/3", "1/6"],
    [["1/6", "-1/6", 0], ["1/6", "1/3", 0], ["1/6", "5/6", 0]],
    ["1/6", "2/3", "1/6"],
)


def test_symplectic_euler_is_conjugate_to_order_2_on_separable_systems_only():
    separable = symplectic_euler(separable=True)
    assert order_of(separable, principal="identity").order == 1
    free = order_of(separable)
    assert (free.order, str(free.failing_tree)) == (2, "f[k[f]]")
    general = order_of(symplectic_euler(separable=False))
    assert (general.order, str(general.failing_tree)) == (1, "f[f]")


def test_the_conjugation_of_symplectic_euler_is_half_a_kick():
    eta = order_of(symplectic_euler(separable=True)).eta
    parts = {str(t): x[0] for t, x in eta.items() if t.order == 1}
    assert parts["f"] == 0
    assert parts["k"] == F(1, 2)


@pytest.mark.parametrize("principal", ["free", "identity"])
def test_lobatto_pairs_have_order_2_and_4(principal):
    two = order_of(pair(*VERLET), principal=principal)
    assert (two.order, two.decided, two.proof) == (2, True, Proof.EXACT)
    four = order_of(pair(*LOBATTO_3), principal=principal)
    assert four.order == 4
    assert four.failing_tree.order == 5
    swapped = order_of(pair(LOBATTO_3[2], *LOBATTO_3[1:2], LOBATTO_3[0], LOBATTO_3[3]))
    assert swapped.order == 4


def test_the_failing_tree_of_lobatto_iiia_iiib_3_needs_both_colours():
    assert str(order_of(pair(*LOBATTO_3)).failing_tree) == "f[k[f]k[f]]"
    # each method by itself has order 4 too, so that mixing them is what is proved
    wrong = [list(row) for row in LOBATTO_3[2]]
    wrong[1], wrong[2] = wrong[2], wrong[1]
    mixed = order_of(pair(LOBATTO_3[0], LOBATTO_3[1], wrong, LOBATTO_3[3]))
    assert mixed.order == 1


def test_a_pair_of_twice_one_method_has_its_order():
    n = load("gsymplectic-n")
    twin = PartitionedGLM(
        A=n.A, U=n.U, B=n.B, V=n.V, A_hat=n.A, U_hat=n.U, B_hat=n.B, V_hat=n.V
    )  # fmt: skip
    for principal in ("free", "identity"):
        single, double = order_of(n, principal=principal), order_of(twin, principal=principal)
        assert double.order == single.order == 4
    p = load("gsymplectic-p")
    mixed = PartitionedGLM(A=n.A, U=n.U, B=n.B, V=n.V, A_hat=p.A, U_hat=p.U, B_hat=p.B, V_hat=p.V)
    assert order_of(mixed).order == 2


def in_doubles(name, read):
    """A shipped pair with its coefficients as doubles, each read so."""
    good = load(name)

    def matrix(letter):
        return [[exact(F(y)) if (y := float(x)).is_integer() else read(y) for x in row]
                for row in getattr(good, letter)]  # fmt: skip

    letters = ("A", "U", "B", "V", "A_hat", "U_hat", "B_hat", "V_hat")
    return PartitionedGLM(**{x: matrix(x) for x in letters}, separable=True)


@pytest.mark.parametrize(("name", "order"), [("pair-4-4", 4), ("pair-6-7", 6)])
@pytest.mark.parametrize("principal", ["free", "identity"])
def test_explicit_pairs_have_their_order_within_the_digits_of_doubles(name, order, principal):
    method = in_doubles(name, lambda x: Ball.decimal(f"{x:.14f}", 14))
    result = order_of(method, principal=principal)
    assert (result.order, result.proof, result.decided) == (order, Proof.ENCLOSED, True)
    # radii of 1e-14, weights and couplings up to 6.2 in products of up to six factors
    assert 0 < result.largest_residual < 1e-8


@pytest.mark.parametrize(("name", "order"), [("pair-4-4", 4), ("pair-6-7", 6)])
def test_doubles_taken_as_exact_miss_the_conditions_by_rounding_only(name, order):
    method = in_doubles(name, lambda x: exact(F(x)))
    sizes = [x.magnitude() for x in order_residuals(method, order).values()]
    # a rounding of 1.1e-16 per coefficient, tens of terms of size up to 1 in a condition
    assert 0 < max(sizes) < 1e-14
    assert order_of(method).order < order
    higher = order_residuals(method, order + 1, free=True)
    assert max(x.magnitude() for t, x in higher.items() if t.order == order + 1) > 1e-6


def test_a_pair_that_is_not_preconsistent_says_why():
    broken = pair([[1]], [1], [[0]], [1])
    broken = PartitionedGLM(
        A=broken.A, U=broken.U, B=broken.B, V=[["1/2"]],
        A_hat=broken.A_hat, U_hat=broken.U_hat, B_hat=broken.B_hat, V_hat=broken.V_hat,
    )  # fmt: skip
    result = order_of(broken)
    assert result.order == 0
    assert "no eigenvalue 1" in result.witness


# -- the oscillator near w = -1 ----------------------------------------------------------------------

SWEEPS = [x for x in names("methods") if shipped(x)["class"] == "pair-sweep"]
LABEL = re.compile(r"\|w\| - 1 = (\S+) \(h omega\)\^3")


@pytest.mark.sampled(4, besides=("pair-8-24", "pair-rkn-8"))
@pytest.mark.parametrize("name", SWEEPS)
def test_a_pair_is_labelled_exactly_where_its_curvature_is_negative(name):
    kappa = parasitic_curvature(load(name))
    labels = [m for note in document(name).get("notes", []) for m in LABEL.findall(note)]
    if kappa.real.sign() > 0:  # a ball that excludes zero: decided
        assert labels == []
    else:
        assert kappa.real.sign() < 0
        assert labels == [f"{(-float(kappa)) ** 0.5:.2e}"]


def step_matrix(pair, y):
    """The step on q' = p, p' = -q with h = y, in double precision."""
    one = oscillator(pair)
    A, U, B, V = (np.vectorize(complex)(np.array(getattr(one, x))) for x in "AUBV")
    return V + y * B @ np.linalg.solve(np.eye(len(A)) - y * A, U)


@pytest.mark.sampled(3, besides=("pair-8-24", "pair-rkn-8"))
@pytest.mark.parametrize(
    "name", ["pair-4-4", "pair-6-7", "pair-8-24", "pair-rkn-6-8b", "pair-rkn-8-16"]
)
def test_the_curvature_is_what_the_eigenvalues_of_a_step_show(name):
    pair, y = load(name), 2.0**-3
    kappa, M = float(parasitic_curvature(pair)), step_matrix(pair, y)
    # the next terms are of relative size y^2 = 1/64 times ratios of coefficients below 10
    e = np.linalg.det(np.eye(4) + M) / (4 + np.trace(M))
    assert e.real / y**6 == pytest.approx(kappa, rel=10 / 64)
    # eigenvalues 2 sqrt|kappa| y^3 > 1e-6 apart are right to 1e-16 / 1e-6 times a norm below 100
    off = max(abs(abs(w) - 1) for w in np.linalg.eigvals(M))
    if kappa > 0:
        assert off < 1e-8
    else:
        assert off == pytest.approx((-kappa) ** 0.5 * y**3, rel=10 / 64)


def test_a_curvature_is_refused_where_it_has_no_meaning():
    refused(UsageError, "must carry two values", parasitic_curvature, load("stormer-verlet"))
    refused(UsageError, "must be explicit", parasitic_curvature, load("gsymplectic-n-pair"))
    good = load("pair-4-4")
    second = good.B[1]
    grown = replace(good, B=(good.B[0], (2 * second[0], *second[1:])), G=None)  # sum b w w is not 0
    refused(UsageError, "or grows", parasitic_curvature, grown)


@pytest.mark.parametrize(
    ("name", "expected", "tree"),
    [("pair-4-4", 1, "f[k]"), ("pair-6-7", 1, "k[f]"), ("pair-6-8", 3, "f[kkk]")],
)
def test_zero_starting_values_are_right_to_a_low_order(name, expected, tree):
    found = Kernel(replace(load(name), starting=None)).range("starting-order")
    assert found.upper == expected < document(name)["claims"]["starting-order"]
    assert found.reason == f"a carried value starts with a term of {tree}"


# --- second-order systems -------------------------------------------------------------------------


def nystrom_order_of(pair: Any, most: int = 9) -> OrderResult:
    return order_of(pair, max_order=most, principal="identity", counts=counted("nystrom"))


def nystrom_trees(order):
    return [t for t in trees(order, SEPARABLE) if is_nystrom(t)]


def test_there_are_as_many_trees_as_nystrom_series_have():
    # Hairer, Norsett, Wanner (1993), section II.14: conditions for y' at orders 1, 2, ..
    counts = [1, 1, 2, 3, 6, 10, 20]
    by_root = {
        root: [sum(t.colour == root for t in nystrom_trees(n)) for n in range(1, 8)]
        for root in "kf"
    }
    assert by_root["k"] == counts
    assert by_root["f"] == [1, *counts[:-1]]  # f has one child at most


def test_the_trees_that_count_are_closed_under_cutting():
    for n in range(2, 7):
        for t in nystrom_trees(n):
            assert all(is_nystrom(child) for child in t.children)


@pytest.mark.parametrize(
    ("name", "general", "nystrom"),
    [
        ("stormer-verlet", 2, 2),
        ("forest-ruth-4", 4, 4),
        ("mclachlan-atela-4", 3, 4),
        ("blanes-moan-rkn-6-11", 4, 6),
        ("blanes-moan-rkn-6-14", 4, 6),
        ("pair-6-7", 6, 6),
    ],
)
def test_orders_on_all_separable_and_on_second_order_systems(name, general, nystrom):
    method = load(name)
    assert order_of(method, principal="identity").order == general
    found = nystrom_order_of(method)
    assert found.order == nystrom
    assert found.failing_tree.order == nystrom + 1


def test_one_weight_off_and_the_order_is_lost():
    good = load("forest-ruth-4")
    a, b = list(good.B[0]), list(good.B_hat[0])
    b[0], b[1] = b[1], b[0]
    assert nystrom_order_of(splitting(a, b)).order == 1


def test_shared_stages_and_no_end_of_the_search():
    found = nystrom_order_of(load("lobatto-iiia-iiib-3"))  # q' = p, p' = k(q, p)
    assert (found.order, str(found.failing_tree)) == (4, "f[k[fff]]")
    assert nystrom_order_of(load("stormer-verlet"), 1).at_least


def test_other_pairs_cannot_claim_row_sums():
    doc = copy.deepcopy(dict(document("stormer-verlet")))
    refused(DataError, "row-sums", load_document, {**doc, "claims": {"row-sums": True}})
    for name in ("stormer-verlet", "ruth-3", "pair-4-4"):
        method: Any = load(name)
        assert facts_for(method).judge("row-sums", True).verdict is Verdict.OPEN
        assert known_beside(facts_for(method), "row-sums").truth is not False
