"""The interval test on systems with no, one and two roots, and on method files."""

import copy
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import pytest

from glmref.catalogue import lookup as catalogue
from glmref.catalogue.lookup import load
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, ExactnessError
from glmref.exact import linalg
from glmref.exact.expression import parse
from glmref.exact.judging import Fraction as rational
from glmref.exact.judging import consulted, newton
from glmref.findings import Proof, Verdict
from glmref.judge.refusals import Refused
from glmref.method import GLM
from glmref.method.families import composition
from glmref.prove import kernel
from glmref.prove.enclosure import prove
from glmref.prove.facts import facts_of
from glmref.prove.implications import implied_by
from glmref.prove.starting import texts_of
from glmref.prove.verifier import verify
from glmref.theory.trees import parse_tree, trees
from tests.bseries import order_residuals
from tests.build import refused


def document(name: str) -> dict[str, Any]:
    """A shipped document without its start, which has tests of its own."""
    doc = copy.deepcopy(catalogue.document(name))
    for key in ("starting", "finishing"):
        doc.pop(key, None)
    return doc


def root_near(function: Any, published: Sequence[Any], digits: int = 75) -> list[Any]:
    """The root of a system of the judge, with centre and inverse as a finder proposes them."""
    with consulted() as judge:
        points = [rational(x.numerator, x.denominator) for x in map(Fraction, published)]
        radius = rational(1, 10**60)
        over = function(judge.krawczyk.box_around(points, radius))
        proof = {"radius": "1e-60", **texts_of(*newton(function, points, over))}
        return judge.krawczyk.only_root(function, points, digits, proof, lambda: over)  # fmt: skip


ROOT_2 = "1.414213562373095048801688724209698078569671875376948073176679737990732478462"


@pytest.mark.parametrize(
    ("gap", "centre", "said"),
    [
        (-2, f"{ROOT_2[:-1]}3", "rounded"),  # the last digit is another
        (-2, f"{ROOT_2[:50]}0{ROOT_2[51:]}", "outside the box"),
        (2, ROOT_2, "box"),  # there is no root
        (Fraction(-1, 10**160), 0, "singular"),  # two roots 2e-80 apart, in one box
    ],
)
def test_a_root_that_is_not_the_one_within_the_digits_is_refused(gap, centre, said):
    shift = rational(Fraction(gap).numerator, Fraction(gap).denominator)
    with pytest.raises((Refused, ZeroDivisionError), match=said):
        root_near(lambda v: [v[0] * v[0] + shift], [centre])


def test_a_system_that_is_not_square_is_refused() -> None:
    refused((Refused, ValueError), "", root_near, lambda v: [v[0]], [0, 0])


def changed(name: str, **changes: Any) -> Mapping[str, Any]:
    """A copy of a shipped document with other keys."""
    return {**copy.deepcopy(document(name)), **changes}


def test_a_perturbed_candidate_is_refused() -> None:
    doc = copy.deepcopy(document("s3i1-w3"))
    text = doc["unknowns"]["b1"]
    doc["unknowns"]["b1"] = text[:40] + str((int(text[40]) + 1) % 10) + text[41:]
    refused(ExactnessError, "is not satisfied within the published digits", prove, doc)


def test_a_wrong_last_digit_is_refused() -> None:
    # The root is still unique within 1e-60, but it is not rounded to what is printed.
    doc = copy.deepcopy(document("s3i1-w3"))
    text = doc["unknowns"]["b1"]
    doc["unknowns"]["b1"] = text[:-2] + f"{(int(text[-2:]) + 1) % 100:02d}"
    refused(ExactnessError, "not satisfied within the published digits", prove, doc)


def test_a_missing_order_condition_is_named() -> None:
    doc = copy.deepcopy(document("s5i1-w3"))
    equations = doc["enclosure"]["equations"]
    equations[equations.index("order [oo[o]]")] = "abscissa 1 = 0"
    refused(DataError, "conditions of order 5", prove, doc)


def test_more_unknowns_than_equations_are_refused() -> None:
    doc = copy.deepcopy(document("s3i1-w3"))
    doc["enclosure"]["equations"].remove("explicit 1")
    refused(DataError, "as many as the unknowns", prove, doc)


def test_a_pattern_that_is_not_palindromic_is_refused() -> None:
    doc = copy.deepcopy(document("s3i1-w3"))
    doc["X"][1][0] = "2*alpha1"
    refused(DataError, "palindromic", prove, doc)


def test_a_radius_of_thousands_of_characters_is_not_repeated() -> None:
    enclosure = {**document("s3i1-w3")["enclosure"], "radius": "0." + "3" * 3664}
    caught = refused(DataError, "radius", prove, changed("s3i1-w3", enclosure=enclosure))
    assert len(caught) < 200


def test_without_a_growth_equation_nothing_is_said_about_parasitism() -> None:
    # Yoshida's composition has no eigenvalue but 1; the claim then needs no equation.
    implied = implied_by(document("yoshida-6-midpoint"), None)
    assert implied is not None and "parasitism-free" in implied.true
    doc = copy.deepcopy(document("t115-i"))
    equations = doc["enclosure"]["equations"]
    equations.remove("growth -1")
    doc["constants"]["gamma3"] = doc["unknowns"].pop("gamma3")
    with pytest.raises((DataError, ExactnessError)):
        prove(doc)  # a decimal is no constant: it would be a ball in an exact place


def test_compositions_of_order_4_have_residuals_of_order_5_in_a_plane() -> None:
    # Theory: R = p alpha_5 + q [f, [f, alpha_3]]. Two exact compositions of midpoint steps span the
    # plane, a third lies in it, and [oooo] and [[o][o]] are coordinates on it.
    w = parse("1/(2-root(2,3))")
    suzuki = parse("1/(4-root(4,3))")
    nested = [x * y for x in (suzuki, suzuki, 1 - suzuki * 4) for y in (w, 1 - w * 2, w)]
    cases = [[w, 1 - w * 2, w], [suzuki, suzuki, 1 - suzuki * 4, suzuki, suzuki],
             [*nested, *reversed(nested[:6])]]  # fmt: skip
    midpoint, rows = load("gauss-1"), []
    assert isinstance(midpoint, GLM)
    for weights in cases:
        residual = order_residuals(composition(midpoint, weights), 5)
        assert all(x.is_zero() for t, x in residual.items() if t.order < 5)
        rows.append(tuple(residual[t] for t in trees(5)))
    assert linalg.rank(tuple(rows[:2])) == linalg.rank(tuple(rows)) == 2
    places = [trees(5).index(parse_tree(x)) for x in ("[oooo]", "[[o][o]]")]
    assert linalg.rank(tuple(tuple(row[k] for k in places) for row in rows)) == 2


def test_next_order_is_refuted_unless_it_holds() -> None:
    doc = copy.deepcopy(document("yoshida-6-midpoint"))
    assert prove(doc).next_order > 1e-3
    doc["claims"]["order"] = doc["claims"]["order-identity"] = 4  # where the equations give 6
    assert prove(doc).next_order == 0.0


@pytest.mark.parametrize(("k", "fine"), [(3, True), (6, True), (62, False)])
def test_of_two_roots_one_is_found_where_the_other_lies_outside_the_box(k: int, fine: bool) -> None:
    """The circle x^2 + y^2 = 2 and the line x + y = 2 - 10^-2k meet twice near (1, 1)."""
    gap = Fraction(1, 10 ** (2 * k))
    square = (gap - gap * gap / 4) * 10**300
    root = math.isqrt(int(square)) * Fraction(1, 10**150)
    below = rational(gap.numerator, gap.denominator)

    def circle_and_line(v: Sequence[Any]) -> list[Any]:
        return [v[0] * v[0] + v[1] * v[1] + rational(-2), v[0] + v[1] + rational(-2) + below]

    x = 1 - gap / 2 + root
    near = [x, 2 - gap - x]
    if fine:
        assert len(root_near(circle_and_line, near)) == 2
    else:
        refused(Refused, r"image|contraction", root_near, circle_and_line, near)


def with_growth_replaced() -> dict[str, Any]:
    """The order-8 method of stage order 3 with an abscissa fixed in place of its growth at -1.

    The abscissa is the true one to 90 places, so that a true method lies within the digits, its
    growth parameter at -1 below 1e-85 and not zero.
    """
    doc = document("order8-s5q3-w3")
    found = prove(doc).root.enclosed
    with consulted() as judge:
        first = found.series(found.root, 2).stages(judge.trees.LEAF)[0].as_ball()
    places = Fraction(first.decimal_text(120)).limit_denominator(10**45)
    equations = doc["enclosure"]["equations"]
    equations[equations.index("growth -1")] = f"abscissa 1 = {places}"
    del doc["claims"]["starting-order"]
    return doc


@pytest.mark.slow
def test_without_its_growth_equation_a_method_is_not_enclosed_as_parasitism_free() -> None:
    doc = with_growth_replaced()
    record = prove(doc)
    assert record.order == 8
    implied = implied_by(doc, None)
    assert implied is not None and implied.growth_zeros is None
    proofs = {x.claim: (x.verdict, x.proof) for x in verify(load_document(doc))}
    assert proofs["order"] == (Verdict.HOLDS, Proof.ENCLOSED)
    assert proofs["parasitism-free"][0] is Verdict.OPEN
    assert proofs["growth"][0] is Verdict.OPEN


def test_orders_beyond_the_trees_stay_open() -> None:
    # Gauss with three stages has order 6; looked at up to order 5 only, nothing fails.
    method = load("gauss-3")
    assert isinstance(method, GLM)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kernel, "MAX_ORDER", (5, 5, 5))
        patch.setattr(kernel, "HIGHEST", 5)
        seen = facts_of(method)
        found = {p: seen.judge("order", p) for p in (4, 5, 6)}
        assert [found[p].verdict for p in (4, 5, 6)] == [Verdict.FAILS, Verdict.OPEN, Verdict.OPEN]
        assert "no tree of order 5 or less fails" in found[5].reason
    far = facts_of(method)
    assert far.judge("order", 6).verdict is Verdict.HOLDS
    assert far.judge("order", 7).verdict is Verdict.FAILS
