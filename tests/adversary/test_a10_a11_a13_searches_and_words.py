"""A10, A11, A13: searches that end, stability at its edges, words that mean something else."""

import random
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.exact.expression import to_text
from glmref.method import GLM, families
from glmref.prove.facts import facts_of

from .deceive import Proof, Verdict, doc, findings, never_holds, shipped, texts, verdicts

FAST = settings(max_examples=8, deadline=None)
HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN
MIDPOINT = GLM(A=[["1/2"]], U=[["1"]], B=[["1"]], V=[["1"]])


def composed(steps: list[Fraction], order: list[int], claims: dict) -> dict:
    m = families.composition(MIDPOINT, steps).permute_stages(order)
    return doc(
        "rk", claims, A=[[to_text(x) for x in row] for row in m.A], b=[to_text(x) for x in m.B[0]]
    )


@FAST
@given(st.integers(2, 7), st.integers(0, 10**6), st.booleans())
def test_a10_a_symmetric_composition_is_never_called_unsymmetric(n, seed, equal) -> None:
    """2 n stages; the stages are numbered anew so that P is i <-> i + n, or anything."""
    chance = random.Random(seed)
    half = [Fraction(1, 2 * n) if equal else Fraction(chance.randint(1, 9), 7) for _ in range(n)]
    order = list(range(n)) + list(range(2 * n - 1, n - 1, -1))
    if seed % 2:
        chance.shuffle(order)
    d = composed([*half, *half[::-1]], order, {"symmetric": False})
    assert verdicts(d)["symmetric"] is not HOLDS
    d["claims"] = {"symmetric": True}
    assert verdicts(d)["symmetric"] is not FAILS


@FAST
@given(st.integers(1, 5), st.integers(0, 10**6))
def test_a10_a_composition_that_is_no_palindrome_is_not_symmetric(n, seed) -> None:
    chance = random.Random(seed)
    half = [Fraction(chance.randint(1, 9), 7) for _ in range(n)]
    steps = [*half, *half[::-1]]
    steps[0] += Fraction(1, 10 ** chance.randint(1, 60))
    d = composed(steps, list(range(2 * n)), {"symmetric": True})
    assert verdicts(d)["symmetric"] is FAILS


def test_a10_many_equal_stages_are_open_or_right() -> None:
    """Fourteen equal stages of the implicit midpoint rule: any exchange of stages will do."""
    n = 14
    d = doc("rk", {"symmetric": False}, A=texts([[Fraction(1, 2 * n)] * n] * n),
            b=[str(Fraction(1, n))] * n)  # fmt: skip
    assert verdicts(d)["symmetric"] is not HOLDS


def glm(A, U, B, V, **claims) -> dict:
    claims = {k.replace("_", "-"): x for k, x in claims.items()}
    return doc("glm", claims, A=texts(A), U=texts(U), B=texts(B), V=texts(V))


@FAST
@given(st.fractions(min_value=Fraction(1, 9), max_value=5, max_denominator=9))
def test_a11_defective_on_the_axis(weight: Fraction) -> None:
    """Two midpoint rules, the second driving the first: M(iy) is a Jordan block on the circle."""
    d = glm([["1/2", 0], [0, "1/2"]], [[1, 0], [0, 1]], [[1, weight], [0, 1]],
            [[1, 0], [0, 1]], a_stable=True)  # fmt: skip
    assert verdicts(d)["a-stable"] is FAILS
    # the trapezoidal rule beside the implicit midpoint rule, apart: power-bounded
    apart = glm([["1/2", 0], [0, "1/2"]], [[1, 0], [0, 1]], [[1, 0], [0, 1]],
                [[1, 0], [0, 1]], a_stable=False)  # fmt: skip
    assert verdicts(apart)["a-stable"] is not HOLDS


@FAST
@given(st.fractions(min_value=Fraction(1, 9), max_value=5, max_denominator=9))
def test_a11_a_pole_that_the_characteristic_polynomial_does_not_see(a: Fraction) -> None:
    d = glm(
        [["1", 0], [0, -a]], [[1, 0], [0, 1]], [[1, 1], [0, 0]], [[1, 0], [0, 0]], a_stable=True
    )
    assert verdicts(d)["a-stable"] is FAILS
    twin = glm(
        [["1", 0], [0, a]], [[1, 0], [0, 1]], [[1, 1], [0, 0]], [[1, 0], [0, 0]], a_stable=True
    )
    assert verdicts(twin)["a-stable"] is HOLDS


@pytest.mark.parametrize("n", [3, 10, 30])
@pytest.mark.parametrize("name", ["gauss-2", "implicit-euler", "lobatto-iiic-2", "radau-iia-2"])
def test_a11_near_misses_of_a_stability(name: str, n: int) -> None:
    from glmref.catalogue.lookup import names

    if name not in names():
        pytest.skip("not shipped")
    d = shipped(name)
    d["claims"] = {"a-stable": True}
    assert verdicts(d)["a-stable"] is HOLDS
    d["b"][0] = f"{d['b'][0]}+1/1{'0' * n}"  # R(infinity) or R(iy) leaves the disc, or R(0) != 1
    if name == "gauss-2":
        assert verdicts(d)["a-stable"] is FAILS


@FAST
@given(st.lists(st.integers(-3, 3), min_size=9, max_size=9))
def test_a13_the_error_constant_is_not_read_off_another_basis(entries: list[int]) -> None:
    d = shipped("ab-3")
    right = d["claims"]["error-constant"]
    d["claims"] = {"error-constant": right}
    assert verdicts(d)["error-constant"] is HOLDS
    d["claims"] = {"error-constant": "0"}
    assert verdicts(d)["error-constant"] is FAILS
    m = families.linear_multistep(d["alpha"], d["beta"])
    T = [entries[:3], entries[3:6], entries[6:]]
    try:
        other = m.transform(T)
    except Exception:  # a singular basis
        return
    blocks = {x: [[to_text(y) for y in row] for row in getattr(other, x)] for x in "AUBV"}
    for claimed in ("0", "1", right):
        assert verdicts(doc("glm", {"error-constant": claimed}, **blocks))["error-constant"] is OPEN


def test_a13_an_order_beyond_the_trees_compared_is_at_least() -> None:
    from glmref.prove.kernel import MAX_ORDER, Kernel
    from glmref.theory.trees import trees  # noqa: F401

    m = facts_of(families.runge_kutta([["1/2"]], ["1"])).kernel.range("order")
    assert (m.lower, m.upper) == (2, 2)
    assert MAX_ORDER[0] >= 12 and Kernel is not None


@pytest.mark.slow
@FAST
@given(st.sampled_from(["rk4", "kutta-3", "heun-2", "gauss-2", "lobatto-iiia-3"]),
       st.integers(1, 100), st.integers(0, 10**6))  # fmt: skip
def test_exact_near_misses_fail(name: str, n: int, seed: int) -> None:
    from glmref.catalogue.lookup import names

    if name not in names():
        return
    d, chance = shipped(name), random.Random(seed)
    d["claims"] = {"order": d["claims"]["order"]}
    found = findings(d)["order"]
    assert (found.verdict, found.proof) == (HOLDS, Proof.EXACT)
    i = chance.randrange(len(d["b"]))
    d["b"][i] = f"{d['b'][i]}+1/1{'0' * n}"
    assert verdicts(d)["order"] is FAILS
    never_holds(d, "order")
