"""Additive methods: k parts on shared stages, by the trees in k colours; a problem as a sum."""

import copy
import json

import numpy as np
import pytest

import glmref
from glmref import AdditiveGLM, PartitionedGLM
from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.findings import Verdict
from glmref.judge import verdict as checked
from glmref.prove.verifier import facts_for
from glmref.theory.order import order_of
from glmref.theory.trees import parse_tree, trees
from tests.bseries import order_residuals
from tests.build import refused

EULER = {
    "format": "glmref-method-1",
    "name": "imex-euler",
    "class": "additive",
    "parts": [
        {"A": [["0", "0"], ["1", "0"]], "b": ["1", "0"]},
        {"A": [["0", "0"], ["0", "1"]], "b": ["0", "1"]},
    ],
    "claims": {
        "order": 1, "preconsistent": True, "consistent": True, "zero-stable": True,
        "explicit": False,
    },
    "source": {"citation": "Ascher, Ruuth, Spiteri (1997)", "where": "2.1", "status": "as printed"},
}  # fmt: skip


def verdicts(method):
    return {x.claim: x.verdict for x in glmref.verify(method)}


def test_parts_of_order_two_need_not_make_a_method_of_order_two():
    # two midpoint rules whose stages stand at other times: both of order 2, coupled of order 1
    explicit = [["0", "0"], ["1/2", "0"]]
    other = [["0", "0"], ["0", "1/2"]]
    good = AdditiveGLM([explicit, other], [[["0", "1"]]] * 2)
    assert order_of(good, principal="identity").order == 2
    late = AdditiveGLM([explicit, [["1/2", "0"], ["0", "0"]]], [[["0", "1"]], [["1", "0"]]])
    found = glmref.analyze(late)
    assert found.order_parts == [2, 2] and found.order == 1
    failing = order_of(late, principal="identity").failing_tree
    assert len({failing.colour, failing.children[0].colour}) == 2


def test_equal_parts_are_the_one_method():
    m = glmref.load("rk4")
    twice = AdditiveGLM([m.A, m.A], [m.B, m.B])
    assert glmref.analyze(twice).order == 4
    whole, one = order_residuals(twice, 5), order_residuals(m, 5)
    for t, x in whole.items():
        plain = parse_tree("".join("o" if y.isdigit() else y for y in str(t)).replace("o[", "["))
        assert x == one[plain]


def test_the_coupling_conditions_are_those_of_the_pair_with_the_same_blocks():
    pair = glmref.load("lobatto-iiia-iiib-3")
    both = AdditiveGLM([pair.A, pair.A_hat], [pair.B, pair.B_hat])
    first = order_of(PartitionedGLM(*_blocks(pair, ""), *_blocks(pair, "_hat")), max_order=5)
    second = order_of(both, max_order=5)
    assert (first.order, first.residual.magnitude()) == (second.order, second.residual.magnitude())
    assert len(trees(4, both.palette)) == len(trees(4, pair.palette))


def _blocks(pair, hat):
    return [getattr(pair, x + hat) for x in "AUBV"]


def imex(h, steps, method, **options):
    """y' = -y^2 (explicit) + (cos t - y) (implicit) against many small steps of the sum."""
    problem = glmref.Problem(
        terms=[("-y[0]**2",), ("cos(t) - y[0]",)], y0=("1/2",), t_span=(0.0, 1.0)
    )
    return glmref.solve(problem, method, h=h, steps=steps, **options).y[-1]


def test_a_run_has_the_order_that_is_proved():
    method = load_document(EULER)
    reference = imex(1 / 64, 64, "gauss-3")
    errors = [abs(imex(1 / n, n, method) - reference)[0] for n in (32, 64, 128)]
    rates = [np.log2(a / b) for a, b in zip(errors, errors[1:], strict=False)]
    assert all(abs(rate - 1) < 0.1 for rate in rates)
    far = imex(1 / 32, 32, method, engine="reference", digits=30)
    assert abs(float(far[0]) - imex(1 / 32, 32, method)[0]) < 1e-13


def test_callables_are_summed_too():
    problem = glmref.Problem(terms=[lambda t, y: -y, lambda t, y: 0 * y + t], y0=(1.0,))
    assert problem.f(2.0, np.array([3.0])) == pytest.approx(-1.0)
    end = glmref.solve(problem, load_document(EULER), h=0.5, steps=1).y[-1]
    # stage 1 is y, stage 2 is 1 - 0.5 + 0.5 * 0.5
    assert end == pytest.approx([1 - 0.5 * 1 + 0.5 * 0.5])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"parts": EULER["parts"][:1]}, "2 to 9"),
        ({"parts": [{**EULER["parts"][0], "c": ["0"]}, EULER["parts"][1]]}, "keys A and b"),
        ({"claims": {"symmetric": True}}, "no meaning for an additive method"),
        ({"parts": [{"A": [["0"]], "b": ["1"]}, EULER["parts"][1]]}, "shape"),
    ],
)
def test_what_does_not_fit_is_refused(change, message):
    refused(DataError, message, load_document, {**EULER, **change})


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("name", "order"), [("ars-2-2-2", 2), ("ars-4-4-3", 3)])
def test_the_order_is_seen_in_runs(name, order):
    # y' = y^2/2 + (1 + t - y), nonlinear and not autonomous, in two parts that do not commute
    problem = glmref.Problem(
        terms=[lambda t, y: y * y / 2, lambda t, y: 1 + t - y], y0=(0.5,), t_span=(0.0, 1.0)
    )
    exact = glmref.solve(
        glmref.Problem(f=lambda t, y: y * y / 2 + 1 + t - y, y0=(0.5,)), "gauss-4", h=1 / 64,
        steps=64, engine="reference",
    ).y[-1, 0]  # fmt: skip
    error = [
        abs(glmref.solve(problem, name, h=1 / n, steps=n).y[-1, 0] - exact) for n in (8, 16, 32)
    ]
    seen = np.log2(np.array(error[:-1]) / error[1:])
    assert seen[-1] == pytest.approx(order, abs=0.15), seen
    run = glmref.solve(problem, name, h=0.1, steps=2)
    assert "the reference engine" in " ".join(run.notices)


@pytest.mark.parametrize(
    ("row", "order"), [(("11/30", "2/5"), 2), (("4/15", "2/5"), 3), (("11/30", "3/10"), 3)]
)
def test_two_entries_would_mend_the_printed_imkg_354a(row, order):
    """The sum of its fourth row must be 2/3, and the print does not say which of two is wrong."""
    explicit, implicit = copy.deepcopy(document("imkg-354a-printed")["parts"])
    implicit["A"][3][2:4] = row
    found = load_document({**EULER, "parts": [explicit, implicit], "claims": {"order": order}})
    assert verdicts(found)["order"] is Verdict.HOLDS


def test_the_abscissae_of_the_parts_stand_one_after_another():
    for declared, expected in (
        (["0", "1", "0", "1"], Verdict.HOLDS),
        (["0", "1", "0", "1/2"], Verdict.FAILS),
        (["0", "1"], Verdict.FAILS),
    ):
        method = load_document({**EULER, "claims": {"abscissae": declared}})
        assert verdicts(method) == {"abscissae": expected}
        facts = facts_for(method)
        found = facts.judge("abscissae", method.claims["abscissae"])
        proof = found.certificate
        assert checked(json.loads(json.dumps(proof)))[0], proof
    parts = copy.deepcopy(EULER["parts"])
    parts[1]["b"] = ["0", "1/2"]
    method = load_document({**EULER, "parts": parts, "claims": {"abscissae": ["0", "1", "0", "1"]}})
    (found,) = glmref.verify(method)
    assert found.verdict is Verdict.FAILS and "no abscissae" in found.witness


@pytest.mark.parametrize(("two", "order"), [(False, 1), (True, 0)])
def test_stages_with_two_times_have_the_order_0(two: bool, order: int) -> None:
    parts = [{"A": [["0"]], "b": ["1"]}, {"A": [["1" if two else "0"]], "b": ["1"]}]
    table = {"class": "rk", "A": [["0"]], "b": ["1"], "c": ["1" if two else "0"]}
    common = {k: x for k, x in EULER.items() if k not in ("class", "parts")}
    for own in ({"class": "additive", "parts": parts}, table):
        method = load_document({**common, "format": "glmref-method-2", **own, "claims": {}})
        for q in (0, 1):
            expected = Verdict.HOLDS if q == order else Verdict.FAILS
            found = facts_for(method).judge("stage-order", q)
            assert found.verdict is expected and checked(found.certificate)[0]


@pytest.mark.parametrize("parts", [6, 9])
def test_many_parts_have_more_trees_than_the_judge_lists(parts: int) -> None:
    A = [[0, 0, 0, 0], ["1/2", 0, 0, 0], [0, "1/2", 0, 0], [0, 0, 1, 0]]
    both = [{"A": A, "b": ["1/6", "1/3", "1/3", "1/6"]}] * parts
    (found,) = glmref.check({"parts": both, "order": 4})
    assert found.verdict is Verdict.HOLDS
