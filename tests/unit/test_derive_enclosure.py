"""The interval test on systems with no, one and two roots, and on method files."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import pytest

from glmref.catalogue import lookup as catalogue
from glmref.catalogue.lookup import load
from glmref.catalogue.reader import load_document
from glmref.errors import DataError, ExactnessError
from glmref.exact import Exact, ball, linalg
from glmref.exact.expression import parse
from glmref.findings import Proof, Verdict
from glmref.method import GLM
from glmref.method.component import Component
from glmref.method.sweep import SweepForm
from glmref.prove import kernel
from glmref.prove.enclosure import obstruction, prove, shift_matrix
from glmref.prove.equations import starting_series
from glmref.prove.facts import facts_of
from glmref.prove.implications import implied_by
from glmref.prove.krawczyk import Outcome, krawczyk
from glmref.prove.verifier import verify
from glmref.theory.trees import parse_tree, single, trees

TINY = Fraction(1, 10**60)
ONE = ((Exact(1),),)


def document(name: str) -> dict[str, Any]:
    """A shipped document without its start, which has tests of its own."""
    doc = copy.deepcopy(catalogue.document(name))
    for key in ("starting", "finishing"):
        doc.pop(key, None)
    return doc


def test_one_root_is_found_and_enclosed_far_inside_the_box() -> None:
    # x^2 = 2 near 1.41421356237...: K = x - Y f(x) + (1 - Y f'(X)) (X - x) contracts quadratically.
    result = krawczyk(
        lambda v: [v[0] * v[0] - 2],
        [ball(Fraction("1.41421356237309504880168872420969807"))],
        Fraction(1, 10**30),
    )
    assert result.outcome is Outcome.UNIQUE
    assert result.contraction < 1e-29
    assert result.box[0].contains(Exact(2).sqrt())
    assert result.box[0].radius() < 1e-58  # of the order of radius^2


def test_no_root_is_proved_by_a_component_that_excludes_zero() -> None:
    result = krawczyk(lambda v: [v[0] * v[0] + 1], [ball(1)], Fraction(1, 10))
    assert result.outcome is Outcome.NONE
    assert "excludes zero" in result.witness


def test_no_root_is_proved_where_each_component_vanishes_somewhere() -> None:
    # x + y = 1/5 and x + 11/10 y = -1/5 meet at (4.2, -4); each line crosses the box of radius 1.
    result = krawczyk(
        lambda v: [v[0] + v[1] - Fraction(1, 5), v[0] + v[1] * Fraction(11, 10) + Fraction(1, 5)],
        [ball(0), ball(0)],
        Fraction(1),
    )
    assert result.outcome is Outcome.NONE
    assert "misses" in result.witness


@pytest.mark.parametrize(
    ("centre", "radius", "outcome"),
    [
        (Fraction(1), Fraction(1, 10**20), Outcome.UNDECIDED),  # both roots lie in the box
        (1 + Fraction(1, 10**30), Fraction(1, 10**40), Outcome.UNIQUE),
        (1 - Fraction(1, 10**30), Fraction(1, 10**40), Outcome.UNIQUE),
        (Fraction(1), Fraction(1, 10**40), Outcome.NONE),  # between the two
    ],
)
def test_two_roots_near_each_other_are_never_called_one(
    centre: Fraction, radius: Fraction, outcome: Outcome
) -> None:
    # (x - 1)^2 = 1e-60: roots 1 +- 1e-30.
    result = krawczyk(
        lambda v: [(v[0] - 1) * (v[0] - 1) - Fraction(1, 10**60)], [ball(centre)], radius
    )
    assert result.outcome is outcome


def test_a_double_root_is_undecided_at_every_radius() -> None:
    for k in (10, 30, 60):
        result = krawczyk(lambda v: [(v[0] - 1) * (v[0] - 1)], [ball(1)], Fraction(1, 10**k))
        assert result.outcome is Outcome.UNDECIDED


def test_a_system_that_is_not_square_is_refused() -> None:
    with pytest.raises(DataError, match="square"):
        krawczyk(lambda v: [v[0]], [ball(0), ball(0)], TINY)


SMALL = ("s3i1-w3", "s4-w3", "t115a-i")


@pytest.mark.parametrize("name", SMALL)
def test_a_shipped_method_is_proved_from_its_file(name: str) -> None:
    record = prove(document(name))
    assert record.order == 6
    assert record.radius == TINY
    assert record.width < 1e-100
    assert record.next_order > 1e-5
    implied = implied_by(document(name), None)
    assert implied is not None and implied.at_least["order"] == 6
    assert {"g-symplectic", "symmetric", "parasitism-free"} <= implied.true
    assert all(x.radius() < 1e-75 for x in record.values.values())
    assert not any(f"{x}=" in repr(record) for x in ("system", "form", "series"))  # pages long


def changed(name: str, **changes: Any) -> Mapping[str, Any]:
    """A copy of a shipped document with other keys."""
    return {**copy.deepcopy(document(name)), **changes}


def test_a_perturbed_candidate_is_refused() -> None:
    doc = copy.deepcopy(document("s3i1-w3"))
    text = doc["unknowns"]["b1"]
    doc["unknowns"]["b1"] = text[:40] + str((int(text[40]) + 1) % 10) + text[41:]
    with pytest.raises(ExactnessError, match="is not satisfied within the published digits"):
        prove(doc)


def test_a_wrong_last_digit_is_refused() -> None:
    # The root is still unique within 1e-60, but it is not rounded to what is printed.
    doc = copy.deepcopy(document("s3i1-w3"))
    text = doc["unknowns"]["b1"]
    doc["unknowns"]["b1"] = text[:-2] + f"{(int(text[-2:]) + 1) % 100:02d}"
    with pytest.raises(ExactnessError, match="not satisfied within the published digits"):
        prove(doc)


def test_a_missing_order_condition_is_named() -> None:
    doc = copy.deepcopy(document("s5i1-w3"))
    equations = doc["enclosure"]["equations"]
    equations[equations.index("order [oo[o]]")] = "abscissa 1 = 0"
    with pytest.raises(DataError, match="conditions of order 5"):
        prove(doc)


def test_more_unknowns_than_equations_are_refused() -> None:
    doc = copy.deepcopy(document("s3i1-w3"))
    doc["enclosure"]["equations"].remove("explicit 1")
    with pytest.raises(DataError, match="as many as the unknowns"):
        prove(doc)


def test_a_pattern_that_is_not_palindromic_is_refused() -> None:
    doc = copy.deepcopy(document("s3i1-w3"))
    doc["X"][1][0] = "2*alpha1"
    with pytest.raises(DataError, match="palindromic"):
        prove(doc)


def test_a_radius_above_1e_minus_60_is_refused() -> None:
    doc = changed("s3i1-w3", enclosure={**document("s3i1-w3")["enclosure"], "radius": "1e-20"})
    with pytest.raises(DataError, match="radius"):
        prove(doc)


def test_a_radius_of_thousands_of_characters_is_not_repeated() -> None:
    enclosure = {**document("s3i1-w3")["enclosure"], "radius": "0." + "3" * 3664}
    with pytest.raises(DataError, match="radius") as caught:
        prove(changed("s3i1-w3", enclosure=enclosure))
    assert len(str(caught.value)) < 200


def test_a_claim_of_order_8_needs_the_equations_of_order_7() -> None:
    claims = {**document("s3i1-w3")["claims"], "order": 8}
    with pytest.raises(DataError, match="conditions of order 7"):
        prove(changed("s3i1-w3", claims=claims))


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


def test_starting_series_is_unique_order_by_order() -> None:
    # Full column rank at orders 2..5; at order 1 the kernel is the flow itself.
    assert linalg.rank(shift_matrix(1)) == 0
    for n in (2, 3, 4, 5):
        assert linalg.rank(shift_matrix(n)) == len(trees(n))


def composition(weights: list[Exact]) -> tuple[Component, ...]:
    """Midpoint steps of the given lengths, in the sweep form with r = 1."""
    X, word = ((Exact(1),) * len(weights),), [("o", i) for i in range(len(weights))]
    return SweepForm({"o": weights}, {"o": X}, {"o": ONE}, ONE, word).blocks


def test_compositions_of_order_4_have_residuals_of_order_5_in_a_plane() -> None:
    # Theory: R = p alpha_5 + q [f, [f, alpha_3]]. Two exact compositions span the plane, a third
    # lies in it, and [oooo] and [[o][o]] are coordinates on it.
    w = parse("1/(2-root(2,3))")
    suzuki = parse("1/(4-root(4,3))")
    cases = [[w, 1 - w * 2, w], [suzuki, suzuki, 1 - suzuki * 4, suzuki, suzuki]]
    rows = []
    for weights in cases:
        residual = starting_series(composition(weights), ONE, 5).residual
        assert all(residual[t].is_zero() for n in range(1, 5) for t in trees(n))
        rows.append(tuple(residual[t] for t in trees(5)))
    assert linalg.rank(tuple(rows)) == 2
    places = [trees(5).index(parse_tree(x)) for x in ("[oooo]", "[[o][o]]")]
    assert linalg.rank(tuple(tuple(row[k] for k in places) for row in rows)) == 2
    nested = [x * y for x in (suzuki, suzuki, 1 - suzuki * 4) for y in (w, 1 - w * 2, w)]
    mixed = [*nested, *reversed(nested[:6])]
    third = starting_series(composition(mixed), ONE, 5).residual
    assert all(third[t].is_zero() for n in range(1, 5) for t in trees(n))
    assert linalg.rank((*rows, tuple(third[t] for t in trees(5)))) == 2


def test_obstruction_is_zero_for_a_method_of_the_higher_order() -> None:
    # Gauss with three stages has order 6: nothing at order 5 is obstructed, order 7 is.
    A = [
        [parse(x) for x in row]
        for row in (
            ("5/36", "2/9-sqrt(15)/15", "5/36-sqrt(15)/30"),
            ("5/36+sqrt(15)/24", "2/9", "5/36-sqrt(15)/24"),
            ("5/36+sqrt(15)/30", "2/9+sqrt(15)/15", "5/36"),
        )
    ]
    b = [parse(x) for x in ("5/18", "4/9", "5/18")]
    gauss = [Component("o", tuple(map(tuple, A)), ((Exact(1),),) * 3, (tuple(b),), ONE)]
    assert obstruction(starting_series(gauss, ONE, 6), 5) == 0.0
    assert obstruction(starting_series(gauss, ONE, 7), 6) > 1e-6


@pytest.mark.parametrize(
    ("gap", "outcome"),
    [
        (Fraction(-1, 10**50), Outcome.NONE),  # the circle and the line do not meet
        (Fraction(0), Outcome.UNDECIDED),  # they touch
        (Fraction(1, 10**30), Outcome.UNDECIDED),  # two roots 1e-15 apart, both in the box
    ],
)
def test_two_unknowns_with_no_one_and_two_roots_near_the_centre(
    gap: Fraction, outcome: Outcome
) -> None:
    # x^2 + y^2 = 2 and x + y = 2 - gap touch at (1, 1) for gap = 0; for gap > 0 they meet at
    # 1 - gap/2 +- sqrt(gap - gap^2/4) in x.
    def circle_and_line(v: Sequence[Any]) -> list[Any]:
        return [v[0] * v[0] + v[1] * v[1] - 2, v[0] + v[1] - 2 + gap]

    radius = Fraction(1, 10**60) if outcome is Outcome.NONE else Fraction(1, 10**12)
    result = krawczyk(circle_and_line, [ball(1), ball(1)], radius)
    assert result.outcome is outcome
    if gap > 0:  # a box around one of the two holds one
        x = 1 - gap / 2 + Fraction(1, 10**15)  # sqrt(gap) to 1e-45
        near = [ball(x), ball(2 - gap - x)]
        assert krawczyk(circle_and_line, near, Fraction(1, 10**25)).outcome is Outcome.UNIQUE


def with_growth_replaced() -> dict[str, Any]:
    """The order-8 method of stage order 3 with an abscissa fixed in place of its growth at -1.

    The abscissa is the true one to 90 places, so that a true method lies within the digits, its
    growth parameter at -1 below 1e-85 and not zero.
    """
    doc = document("order8-s5q3-w3")
    first = prove(doc).series[0].eta[single()][0]
    places = Fraction(ball(first).decimal_text(120)).limit_denominator(10**45)
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
