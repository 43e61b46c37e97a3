"""Rules of the kernel that no shipped method reaches: each condition of each is asked for."""

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

from glmref import load
from glmref.catalogue.reader import load_document
from glmref.exact import Exact, ball
from glmref.findings import Proof, Verdict
from glmref.judge.series import Series, path_orders
from glmref.method import GLM, PartitionedGLM
from glmref.prove.facts import facts_of
from glmref.prove.kernel import Kernel
from glmref.prove.schemes import Reach, Scheme, reach
from tests.build import SOURCE, method_document, refused


def runge_kutta(A, b, **more):
    """A Runge-Kutta method from its entries as texts."""
    doc = {"format": "glmref-method-1", "name": "one", "title": "t", "source": SOURCE}
    return load_document({**doc, "class": "rk", "A": A, "b": b, "claims": {"order": 1}, **more})


@pytest.mark.parametrize(("b", "truth"), [("1", False), ("2", True), ("1+i", None)])
def test_the_imaginary_parts_of_a_form_count(b, truth):
    # d = b* g and 2 d Re a = |b|^2 g: with b = 1 + i the real parts alone have a solution
    facts = facts_of(runge_kutta([["1"]], [b], field="complex"))
    assert facts.truth("g-symplectic") is truth


def written(**members):
    """The facts of a document with one value and the claim that it is G-symplectic."""
    one = {"U": [["1"]] * len(members["A"]), "V": [["1"]], "digits": 1}
    return facts_of(load_document(method_document("glm", {"g-symplectic": True}, **one, **members)))


def test_a_form_that_was_found_is_enough_where_decimals_play_no_part():
    # the second stage is used by nobody: its entry of 0.3 +- 0.1 meets the weight 0
    facts = written(A=[["1/2", "0"], ["0.3", "0"]], B=[["1", "0"]])
    found = facts.judge("g-symplectic", True)
    assert (found.verdict, found.proof) == (Verdict.HOLDS, Proof.ENCLOSED)


def test_a_given_form_in_decimals_is_refuted_by_balls():
    # the weight d = b g would have to be 1, and g is 2 within a tenth
    facts = written(A=[["1/2"]], B=[["1"]], G=[["2.0"]], D=["1"])
    found = facts.judge("g-symplectic", True)
    assert (found.verdict, found.proof) == (Verdict.FAILS, Proof.ENCLOSED)


def growing_pair(last, *, separable):
    """Two values in each half, the second carried along: V = diag(1, -1), V^ = diag(1, last)."""
    zero, one = Exact(0), Exact(1)
    A, U, B = ((zero,),), ((one, zero),), ((one,), (zero,))
    V, V_hat = (((one, zero), (zero, Exact(Fraction(x)))) for x in (-1, last))
    return PartitionedGLM(
        A=A, U=U, B=B, V=V, A_hat=A, U_hat=U, B_hat=B, V_hat=V_hat, separable=separable
    )


def test_eigenvalues_of_one_half_alone_leave_growth_open_where_stages_are_shared():
    for last, separable, truth in (
        ("-1", False, True),
        ("-1", True, True),
        ("1/2", False, None),
        ("1/2", True, True),
    ):
        facts = facts_of(growing_pair(last, separable=separable))
        assert facts.truth("parasitism-free") is truth, (last, separable)


def two_values_at_1(*B):
    """V = I and U = (1, 1): the growth matrix at the double eigenvalue 1 is B U."""
    rows = tuple((Exact(x),) for x in B)
    V = ((Exact(1), Exact(0)), (Exact(0), Exact(1)))
    return GLM(A=((Exact(0),),), U=((Exact(1), Exact(1)),), B=rows, V=V)


def test_a_double_1_without_the_solution_leaves_parasitism_open():
    """Of a method that is not consistent no eigenvalue of the growth matrix is the solution's 1."""
    for B, truth in (
        ((1, 0), True),
        ((0, 0), None),  # rank 0
        ((1, -1), False),  # nilpotent: exp(t M) grows
        ((2, 0), None),  # the eigenvalue 2
    ):
        facts = facts_of(two_values_at_1(*B))
        assert facts.truth("parasitism-free") is truth, B


def test_a_step_of_the_staircase_is_a_rounding_and_far_below_the_next():
    def staircase(*sizes, proved=0):
        return Reach(proved, sizes, ("",) * len(sizes), None, exact=True).staircase()

    assert staircase(1e-9, 1e-9, 0.25) == "order 2 to 1.0e-9, order 0 exactly"
    assert staircase(1e-9, 1.01e-7) == "order 2 to 1.1e-7, order 1 to 1.0e-9, order 0 exactly"
    size = 2.0**-30
    assert staircase(size, 100 * size) == "order 2 to 9.4e-8, order 0 exactly"
    assert staircase(1e-3) == "order 0 exactly"  # no rounding
    assert staircase(0.0, 0.0) == "order 0 exactly"  # balls around zero show no step
    assert staircase(0.0, 0.25, proved=1) == "order 1 exactly"


def _scheme(A, b, *, most, stop=10.0, below=9):
    """`reach` of a Runge-Kutta method, with the trees below an order."""
    scheme = Scheme({"o": "o"}, {"o": (A, b)}, "o", lambda t: t.order < below)
    return reach(scheme, most, stop=stop)


def test_the_first_order_that_fails_is_kept_and_an_order_is_proved_after_the_one_below_it():
    zero, one = Exact(0), Exact(1)
    found = _scheme(((zero,),), (one,), most=4)  # Euler
    assert (found.proved, found.refuted) == (1, 2)
    assert len(found.sizes) == 4
    # no tree of order 3 counts: its conditions hold, those of order 2 do not
    assert _scheme(((zero,),), (one,), most=3, below=3).proved == 1
    # a residual that is the limit itself is looked beyond
    assert len(_scheme(((zero,),), (one,), most=3, stop=0.5).sizes) == 3
    assert len(_scheme(((zero,),), (one,), most=3, stop=0.4).sizes) == 2
    assert found.exact
    third = ((zero, zero), (Exact(Fraction(2, 3)), zero))  # of order 3 the bush holds
    found = _scheme(third, (Exact(Fraction(1, 4)), Exact(Fraction(3, 4))), most=3)
    assert (found.first, found.refuted) == (("", "", "[[o]]"), 3)
    assert not _scheme(((zero,),), (ball(1),), most=1).exact


@pytest.mark.parametrize(
    ("refuted", "order", "verdict", "value"),
    [(3, 1, "holds", 2), (3, 2, "holds", 2), (3, 3, "fails", 2), (3, 4, "fails", 2),
     (None, 2, "holds", 2), (None, 3, "open", 2), (4, 3, "open", 3)],
)  # fmt: skip
def test_an_order_is_reached_where_it_is_proved_and_not_where_one_below_is_refuted(
    refuted, order, verdict, value
):
    from glmref.prove.verdicts import reaches

    found = reaches(Reach(2, (0.0, 0.0, 0.1, 0.2), ("", "", "t", "s"), refuted, True), order, "")
    assert (str(found.verdict), found.value) == (verdict, value)
    assert (found.residual > 0) == (verdict != "holds")


def test_what_is_open_stays_open_where_a_failure_was_announced():
    from glmref.prove.verdicts import reaches, refuted

    refutes = {True: None, False: 1, None: None}  # an order that is proved, refuted, or neither
    made = {x: reaches(Reach(int(x is True), (0.5,), ("t",), refutes[x], True), 1, "why")
            for x in (True, False, None)}  # fmt: skip
    verdicts = [str(refuted(made[x], as_expected=y).verdict)
                for x in (True, False, None) for y in (True, False)]  # fmt: skip
    assert verdicts == ["fails", "fails", "holds", "fails", "open", "open"]
    assert refuted(made[False]).reason == "why"
    assert refuted(made[False], reason="because").reason == "because"


def test_a_verdict_that_is_open_always_has_a_reason():
    def reason(truth, exact, given):
        return Kernel._made(truth, exact=exact, value=None, residual=0.0, reason=given).reason

    assert reason(None, True, "") == "no rule decides it"
    assert reason(None, False, "") == "the published digits do not decide it"
    assert reason(None, True, "why") == "why"
    assert reason(True, True, "") == ""
    assert reason(False, True, "why") == "why"


@pytest.mark.parametrize(("one", "exact"), [("1", True), ("1.000", False)])
def test_dense_output_in_decimals_is_not_exact(one, exact):
    method = load_document({
        "format": "glmref-method-2", "name": "euler", "class": "rk", "A": [["0"]], "b": ["1"],
        "digits": 3, "dense": [[one]], "claims": {"dense-order": 1},
        "source": SOURCE,
    })  # fmt: skip
    assert Kernel(method).range("dense-order").exact is exact


def single(A, U, B, V):
    """A method from its entries."""
    return GLM(A, U, B, V)


def test_what_an_enclosure_implies_only_raises_a_lower_bound():
    from glmref.errors import ExactnessError
    from glmref.prove.implications import Implied
    from glmref.prove.ranges import Range

    kernel = Kernel(load("rk4"), Implied(at_least={"order": 3}))
    for found in (Range(3, 4), Range(4, 4)):
        assert kernel._with_implied("order", found) is found
    assert kernel._with_implied("order", Range(2, None)) == Range(3, None, exact=False)
    assert kernel._with_implied("order", Range(2, 3)) == Range(3, 3, exact=False)
    with pytest.raises(ExactnessError, match="order 3 and the digits at most 2"):
        kernel._with_implied("order", Range(2, 2))
    assert kernel._with_implied("order-identity", Range(2, 2)) == Range(2, 2)


def test_a_form_is_found_by_elimination_where_none_is_given():
    i = Exact(-1).sqrt()
    zero, one = Exact(0), Exact(1)
    n: Any = load("gsymplectic-n")
    turned = n.transform(((one, i), (zero, one)))
    n = n.transform(((one, one), (zero, one)))
    both = PartitionedGLM(n.A, n.U, n.B, n.V, n.A, n.U, n.B, n.V)
    for method in (turned, n, both, load("stormer-verlet")):
        assert facts_of(method).truth("g-symplectic") is True


def test_a_scheme_of_two_colours_is_exact_where_both_are():
    zero, one = Exact(0), Exact(1)
    palette = {"f": "fk", "k": "fk"}
    blocks = {"f": (((zero,),), (one,)), "k": (((ball(0),),), (one,))}
    found = reach(Scheme(palette, blocks, "fk"), 1)
    assert (found.proved, found.exact) == (1, False)
    half = Exact(Fraction(1, 2))
    blocks = {"f": (((zero,),), (one,)), "k": (((zero,),), (half,))}
    found = reach(Scheme(palette, blocks, "fk"), 1)
    assert (found.proved, found.refuted, found.sizes) == (0, 1, (0.5,))


def test_an_error_constant_needs_a_multistep_method():
    method = single([["0"]], [["1"]], [["1"]], [["1"]])
    found = facts_of(method).judge("error-constant", "1/2")
    assert found.verdict is Verdict.OPEN
    assert found.reason.endswith("error-constant needs: The file is of class `lmm` or `one-leg`")


def test_paths_alone_do_not_tell_the_stage_order():
    found = Kernel(load("multistep-10")).range("stage-order")
    assert (found.lower, found.upper, found.value) == (1, None, 1)
    assert "were not compared" in found.reason


def off(name, size="1/1000000000000"):
    """A Runge-Kutta method with its first weight off, in fractions."""
    m = load(name)
    (b,) = m.B
    return single(m.A, m.U, [[b[0] + Exact(Fraction(size)), *b[1:]]], m.V)


def test_what_is_nearly_zero_is_measured_order_by_order():
    assert Kernel(single([["0"]], [["1"]], [["1"]], [["1"]])).nearly() == pytest.approx([0, 0.5])
    found = Kernel(off("rk4")).nearly()
    assert found[:4] == pytest.approx([1e-12] * 4)
    assert found[4:] == pytest.approx([1 / 80])
    assert len(Kernel(off("gauss-2", "1/100")).nearly()) == 1  # no rounding


def test_what_is_nearly_zero_is_measured_to_the_largest_order(monkeypatch):
    from glmref.prove import kernel

    with monkeypatch.context() as patch:  # trees beyond order 2 are asked for their first one
        patch.setattr(kernel, "MAX_ORDER", (4, 4, 4, 4, 4))
        found = Kernel(off("rk4")).nearly()
        assert found == pytest.approx([1e-12] * 4 + [1 / 120], rel=1e-3)
        n = load("gsymplectic-n")
        slight = single(
            n.A, n.U, [[n.B[0][0] + Exact(Fraction("1e-12")), *n.B[0][1:]], n.B[1]], n.V
        )
        assert len(Kernel(slight).nearly()) == 2
    monkeypatch.setattr(kernel, "HIGHEST", 4)
    assert Kernel(off("rk4")).nearly()[4:] == pytest.approx([1 / 120])
    found = Kernel(load("rk4")).order_range(free=False)
    assert (found.lower, found.upper, found.tree) == (4, 4, "[oooo]")


@pytest.mark.slow
def test_beyond_order_10_a_residual_counts_as_rounding_to_9_digits_only():
    m = load("gauss-5")
    text = lambda x: f"{float(x):.6f}"  # noqa: E731
    document = runge_kutta(
        [[text(x) for x in row] for row in m.A], [text(x) for x in m.B[0]], digits=6
    )
    found = Kernel(document).nearly()
    assert len(found) == 11 and 1e-9 < found[9] < 1e-3 < 1e3 * found[10]


def test_a_stage_is_the_solution_as_far_as_every_path_says_so():
    # c = 6: the path of order 2 misses c^2 / 2, that of order 3 is c^3 / 6 again
    series = Series.of_tables({"f": ([[Fraction(6)]], [[]]), "k": ([[Fraction(1)]], [[]])})
    method: Any = SimpleNamespace(palette=(("f", "k"), ("k", "f")))
    assert [path_orders(method, series, c, 3) for c in "fk"] == [[1], [1]]


def test_dense_output_and_any_matrix_are_judged_for_the_methods_that_have_them():
    from dataclasses import replace

    from glmref.errors import ExactnessError

    two: Any = load("gsymplectic-n")
    two = replace(two, dense=((Exact(1),),) * two.s)
    refused(ExactnessError, "one value is carried", Kernel(two).range, "dense-order")
    refused(ExactnessError, "a Rosenbrock method is needed", Kernel(load("rk4")).range, "w-order")
