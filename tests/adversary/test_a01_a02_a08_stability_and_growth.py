"""A1, A2, A8: what is undecided, what is multiple, and what is claimed but proved to be zero."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.examples import examples

from .deceive import Proof, Verdict, decimal, doc, findings, never_holds, shipped, texts, verdicts

FAST = examples(12)
HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.OPEN


def multistep(rho: list[Fraction], beta: list[Fraction], claims: dict, digits: int | None) -> dict:
    show = str if digits is None else (lambda x: decimal(x, digits))
    more = {} if digits is None else {"digits": digits}
    return doc("lmm", claims, alpha=[show(x) for x in rho], beta=[show(x) for x in beta], **more)


@FAST
@given(st.fractions(min_value=Fraction(11, 10), max_value=9, max_denominator=50))
def test_an_unstable_root_is_found_in_decimals_and_exactly(root: Fraction) -> None:
    # rho = (w - 1)(w + root), sigma for order 2
    rho = [-root, root - 1, Fraction(1)]
    beta = [(root - 1) / 2 - root + root, (3 + root) / 2 - (root - 1) / 2 + root - 1, Fraction(0)]
    claims = {"zero-stable": True, "parasitism-free": True, "g-symplectic": True, "growth": []}
    for digits in (None, 12, 15):
        never_holds(multistep(rho, beta, claims, digits), *claims)
    assert verdicts(multistep(rho, beta, claims, None))["zero-stable"] is FAILS
    # |product of the roots| > 1 over balls as well
    found = findings(multistep(rho, beta, claims, 15))["zero-stable"]
    assert (found.verdict, found.proof) == (FAILS, Proof.ENCLOSED)


@FAST
@given(st.integers(3, 30))
def test_leapfrog_and_milne_in_decimals_are_open(digits: int) -> None:
    claims = {"parasitism-free": True, "growth": [], "g-symplectic": True, "zero-stable": True}
    third = Fraction(1, 3)
    for beta in ([0, 2, 0], [third, 4 * third, third]):
        d = multistep(
            [Fraction(-1), Fraction(0), Fraction(1)], list(map(Fraction, beta)), claims, digits
        )
        never_holds(d, *claims)


@FAST
@given(st.integers(1, 40), st.sampled_from(["-1", "1"]))
def test_one_decimal_in_v_closes_nothing(digits: int, sign: str) -> None:
    d = shipped("gsymplectic-n")
    d["digits"] = digits
    d["V"][1][1] = decimal(Fraction(-1), digits)
    d["claims"] = {"growth": [], "parasitism-free": True, "g-symplectic": True, "zero-stable": True}
    never_holds(d, *d["claims"])


@FAST
@given(st.integers(1, 30))
def test_defective_v_with_a_decimal_elsewhere_fails(digits: int) -> None:
    d = doc(
        "glm",
        {"zero-stable": True, "parasitism-free": True, "growth": []},
        A=[[decimal(Fraction(1, 3), digits)]],
        U=[["1", "0", "0"]],
        B=[["1"], ["1"], ["1"]],
        V=[["1", "0", "0"], ["0", "-1", "1"], ["0", "0", "-1"]],
        digits=digits,
    )
    assert set(verdicts(d).values()) == {FAILS}
    assert findings(d)["zero-stable"].proof is Proof.EXACT


small = st.fractions(min_value=-3, max_value=3, max_denominator=4)


@FAST
@given(st.lists(small, min_size=4, max_size=4), st.lists(small, min_size=2, max_size=2))
def test_multiple_eigenvalues_are_listed_with_their_multiplicity(m: list, eigenvalue: list) -> None:
    """V = diag(1, -1, -1) and B U = diag(1, -M) there: the parameters are the eigenvalues of M."""
    a, b = eigenvalue
    upper = [[a, m[0]], [0, b]]
    claims = {"growth": []}
    d = doc(
        "glm", claims,
        A=texts([[0] * 3] * 3), U=texts([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        B=texts([[1, 0, 0], [0, -upper[0][0], -upper[0][1]], [0, 0, -b]]),
        V=texts([[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    )  # fmt: skip
    assert verdicts(d)["growth"] is FAILS
    for right in ([str(a), str(b)], [str(b), str(a)]):
        d["claims"]["growth"] = right
        assert verdicts(d)["growth"] is HOLDS
    d["claims"]["growth"] = [str(a), str(b + Fraction(1, 10**40))]
    assert verdicts(d)["growth"] is FAILS
    d["claims"] = {"parasitism-free": True}
    assert verdicts(d)["parasitism-free"] is (HOLDS if not (a or b or m[0]) else FAILS)


@pytest.mark.parametrize("pairs", [2, 3])
def test_several_rotations_are_all_counted(pairs: int) -> None:
    r = 1 + 2 * pairs
    V = [[Fraction(int(i == j == 0)) for j in range(r)] for i in range(r)]
    for k in range(pairs):
        V[1 + 2 * k][2 + 2 * k], V[2 + 2 * k][1 + 2 * k] = Fraction(-1), Fraction(1)
    blocks = {
        "A": [["1/2"]], "U": [["1", *["0"] * (r - 1)]], "B": [["1"], *[["0"]] * (r - 1)],
        "V": texts(V),
    }  # fmt: skip
    assert verdicts(doc("glm", {"growth": []}, **blocks))["growth"] is FAILS
    full = doc("glm", {"growth": ["0"] * 2 * pairs, "zero-stable": True}, **blocks)
    assert set(verdicts(full).values()) == {HOLDS}
    short = doc("glm", {"growth": ["0"] * (2 * pairs - 1)}, **blocks)
    assert verdicts(short)["growth"] is FAILS


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["s3-w3", "t115-i", "pair-4-4"])
@pytest.mark.parametrize("tiny", ["1/1" + "0" * 80, "-1/1" + "0" * 200])
def test_zeros_that_are_proved_are_not_something_else(name: str, tiny: str) -> None:
    d = shipped(name)
    growth = list(d["claims"]["growth"])
    d["claims"]["growth"] = [tiny, *growth[1:]]
    assert verdicts(d)["growth"] is FAILS
    d["claims"]["growth"] = growth[1:]
    assert verdicts(d)["growth"] is FAILS
    d["claims"]["growth"] = [*growth, "0"]
    assert verdicts(d)["growth"] is FAILS
