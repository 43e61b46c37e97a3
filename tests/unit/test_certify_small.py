"""Certificates of small random methods of each class, for each claim and its contrary.

The checker, which shares nothing with the library, accepts every one and refuses the contrary
verdict from the same parts.
"""

import json
import random
from fractions import Fraction
from typing import Any

import pytest

from glmref import judge
from glmref.catalogue.reader import load_document
from glmref.exact import Exact, linalg
from glmref.exact.expression import parse, to_text
from glmref.prove.field import equation_numbers
from glmref.prove.verifier import facts_for
from tests.adversary.deceive import shipped
from tests.build import SOURCE
from tests.oracle.draw import Draw

HEAD = {"format": "glmref-method-1", "name": "x", "source": SOURCE}


def written(d: dict[str, Any], claim: str, declared: Any) -> dict[str, Any] | str:
    """The certificate, or why there is none."""
    method = load_document({**HEAD, **d, "claims": {**d.get("claims", {}), claim: declared}})
    facts = facts_for(method)
    judged = facts.judge(claim, declared)
    found = judged.certificate
    return found if isinstance(found, str) else json.loads(json.dumps(found))


def proved(d: dict[str, Any], claim: str, declared: Any) -> tuple[bool, list[Any]]:
    """Whether the claim holds, and the parts; the checker accepts them, for this verdict only."""
    found = written(d, claim, declared)
    assert isinstance(found, dict), (claim, declared, found)
    accepted, why = judge.verdict(found)
    assert accepted, (claim, declared, why)
    holds = found["statement"]["verdict"] == "holds"
    found["statement"]["verdict"] = "fails" if holds else "holds"
    assert not judge.verdict(found)[0], (claim, declared)
    return holds, found["parts"]


@pytest.mark.parametrize("name", ["lambda", "in", "None", "i_", "_"])
def test_a_constant_may_have_any_name(name: str) -> None:
    method = {"class": "rk", "A": [[f"{name}*{name}*root(8,3)"]], "b": [f"2*{name}"]}
    assert proved({**method, "constants": {name: "(1/2)"}}, "order", 2)[0]


def single(seed: int) -> dict[str, Any]:
    draw = Draw(random.Random(seed), near=0)
    return {"class": "glm", **draw.text(draw.component())}


def pair(seed: int) -> dict[str, Any]:
    draw = Draw(random.Random(f"pair {seed}"), near=0)
    q, p = map(draw.text, draw.halves())
    return {"class": "partitioned", "separable": True, "q": q, "p": p}


def rounded(d: dict[str, Any], letters: str) -> dict[str, Any]:
    """The same with eight decimals in some of the matrices, each an interval."""

    def decimals(rows: list[list[str]]) -> list[list[str]]:
        return [[f"{round(float(Fraction(x)), 8):.8f}" for x in row] for row in rows]

    def inner(block: dict[str, Any]) -> dict[str, Any]:
        return {k: decimals(x) if k in letters else x for k, x in block.items()}

    if d["class"] == "glm":
        return {**inner(d), "digits": 8}
    return {**d, "q": inner(d["q"]), "p": inner(d["p"]), "digits": 8}


#: Claims that are true or false, and those that are orders, of every method of a class.
TRUTHS = ("preconsistent", "consistent", "zero-stable", "explicit", "symmetric", "g-symplectic",
          "symplectic", "parasitism-free")  # fmt: skip
MORE = {"glm": ("symmetric-reduced", "a-stable", "l-stable"), "partitioned": ("reducible",)}
ORDERS = {"glm": ("order", "order-identity", "stage-order"),
          "partitioned": ("order", "order-identity")}  # fmt: skip
#: Why there may be no certificate.
UNDECIDED = (
    "the claim is open",
    "the order is not settled",
    "no form was found",
    "no exchange of stages was found",
    "a method with idle stages is not reduced",
    "the judge refuses the certificate: there is not one u with V u = u, U u = 1",
    "the judge refuses the certificate: growth needs: In a pair 1 is not a multiple eigenvalue",
    "the judge refuses the certificate: unbounded needs: An eigenvalue of V, or of the block",
)


def check_every_claim(d: dict[str, Any], *, exact: bool = True) -> None:
    """A statement holds exactly if its contrary fails, and an order is one number.

    Whether a statement is true may stay open within decimals.
    """
    for claim in (*TRUTHS, *MORE[d["class"]]):
        found = [answer(d, claim, x, exact=exact) for x in (True, False)]
        assert found in ([True, False], [False, True], [None, None]), (claim, found)
    check_abscissae(d)
    for claim in ORDERS[d["class"]]:
        found = [answer(d, claim, x) for x in range(4)]
        assert found.count(True) == 1 or None in found, (claim, found)


def check_abscissae(d: dict[str, Any]) -> None:
    """They are those of a method with its first value as solution, where V and B are exact."""
    facts = facts_for(load_document({**HEAD, **d}))
    c = facts.abscissae if facts.is_single and facts.method.is_exact else None
    if c is None:
        return
    right = [to_text(x) for x in c]
    found = written(d, "abscissae", right)
    if isinstance(found, str) and "All v with 0 in the solution" in found:
        return  # c is not the only one
    assert answer(d, "abscissae", right) in (True, None)
    for i in range(len(right)):
        wrong = [*right[:i], f"{right[i]}+1", *right[i + 1 :]]
        if answer(d, "abscissae", wrong) is not None:  # V may keep more than the solution
            assert not proved(d, "abscissae", wrong)[0]


def answer(d: dict[str, Any], claim: str, declared: Any, *, exact: bool = True) -> bool | None:
    found = written(d, claim, declared)
    open_ = isinstance(declared, bool) and not exact
    if isinstance(found, str) and (open_ or found.startswith(UNDECIDED)):
        return None
    return proved(d, claim, declared)[0]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(12))
def test_each_claim_of_a_method_or_its_contrary_is_certified(seed: int) -> None:
    check_every_claim(single(seed))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("seed", range(12))
def test_each_claim_of_a_pair_or_its_contrary_is_certified(seed: int) -> None:
    check_every_claim(pair(seed))


def test_a_pair_whose_u_is_not_determined_is_reducible() -> None:
    """Every u will do: the difference of two is never seen by a stage."""
    A, B, V = [["1/2"]], [["1"], ["1"]], [["1", "0"], ["0", "1"]]
    q = {"A": A, "U": [["1", "0"]], "B": B, "V": V}
    for p in (q, {"A": A, "U": [["1"]], "B": [["1"]], "V": [["1"]]}):
        for first, second in ((q, p), (p, q)):
            d = {"class": "partitioned", "separable": True, "q": first, "p": second}
            assert proved(d, "reducible", True)[0]
            found = written(d, "reducible", False)
            found["parts"][0]["rule"], found["statement"]["verdict"] = "irreducible", "holds"
            assert not judge.verdict(found)[0]


@pytest.mark.parametrize("seed", [42, 60, 100, 228])
def test_one_rank_that_is_decided_shows_that_a_pair_is_reducible(seed: int) -> None:
    """Decimals leave open how many values are reached, or seen; the other rank is less."""
    assert proved(rounded(pair(seed), "AB"), "reducible", True)[0]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("letters", ["A", "B", "AB", "UV", "AUB"])
@pytest.mark.parametrize("seed", range(3))
def test_what_is_decided_within_decimals_is_certified(seed: int, letters: str) -> None:
    check_every_claim(rounded(single(seed), letters), exact=False)
    check_every_claim(rounded(pair(seed), letters), exact=False)


def moved(name: str, T: list[list[int]]) -> dict[str, Any]:
    """A shipped method whose values are combined by T; what it does is the same."""
    d = shipped(name)
    r = len(T)
    matrix = tuple(tuple(Exact(x) for x in row) for row in T)
    back = linalg.inverse(matrix)

    def inner(block: dict[str, Any]) -> dict[str, Any]:
        A, U, B, V = (tuple(tuple(map(parse, row)) for row in block[k]) for k in "AUBV")
        assert len(V) == r
        new = {"A": A, "U": linalg.matmul(U, matrix), "B": linalg.matmul(back, B),
               "V": linalg.matmul(back, V, matrix)}  # fmt: skip
        return {k: [[to_text(x) for x in row] for row in M] for k, M in new.items()}

    if "q" in d:
        both = {"q": inner(d["q"]), "p": inner(d["p"])}
        return {"class": "partitioned", "separable": d["separable"], **both}
    return {"class": "glm", **inner(d)}


@pytest.mark.sampled(4)
@pytest.mark.parametrize("T", [[[1, 0], [1, 1]], [[2, 1], [1, 1]], [[1, 1], [0, -1]]])
@pytest.mark.parametrize("name", ["gsymplectic-n", "g4123", "gsymplectic-n-pair"])
def test_claims_stay_where_values_are_combined(name: str, T: list[list[int]]) -> None:
    """The vectors to the eigenvalue 1 on both sides of V, which was diagonal, differ now."""
    before, d = shipped(name)["claims"], moved(name, T)
    for claim in ("order", "symmetric", "g-symplectic", "parasitism-free", "reducible"):
        if claim in before:
            check_abscissae(d)
            assert proved(d, claim, before[claim])[0], claim


#: sqrt(3)/12, the entry of a start of order 3, and the same wrong in the 41st place.
RIGHT = "0.144337567297406441127287195125489363911900437817531719004650581620994418076"
WRONG = RIGHT[:42] + "8" + RIGHT[43:]


def started(name: str, hats: tuple[str, ...], digits: str) -> dict[str, Any]:
    """A method with a start in decimals, each an interval."""
    d = {k: v for k, v in shipped(name).items() if k != "claims"}
    for hat in hats:
        d["starting"][f"B{hat}"] = [["0"] * 3, ["0", f"-{digits}", digits]]
    return {**d, "digits": 75}


@pytest.mark.parametrize(("digits", "q"), [(RIGHT, 3), (WRONG, 1)])
@pytest.mark.parametrize("claim", ["starting-order", "nystrom-starting-order"])
def test_a_start_of_a_pair_in_decimals_fails_where_it_certainly_does(digits, q, claim):
    d = started("gsymplectic-n-pair", ("", "_hat"), digits)
    assert answer(d, claim, q) is None
    for declared in (q + 1, q + 2):
        holds, (part,) = proved(d, claim, declared)
        assert (holds, part["rule"], part["witness"]["q"]) == (False, "start-at-most", q)


@pytest.mark.parametrize(("digits", "q"), [(RIGHT, 3), (WRONG, 1)])
def test_a_start_of_one_method_that_fails_beyond_order_1_has_no_certificate(digits, q):
    """The rule that refutes one is for order 1: the judge refuses a certificate beyond."""
    d = started("gsymplectic-n", ("",), digits)
    held, failed = (written(d, "starting-order", x) for x in (q, q + 1))
    assert held == "the claim is open"
    assert failed.startswith("the judge refuses the certificate: start-at-most needs")


@pytest.mark.sampled(0)
@pytest.mark.parametrize("name", ["g6245-w3", "s3-w3"])
def test_an_enclosed_start_of_one_method_is_certified(name: str) -> None:
    """A start of an exact method, whose symmetry is shown, and one of an enclosed method."""
    holds, parts = proved(shipped(name), "starting-order", 6)
    assert holds
    assert [x["rule"] for x in parts[-2:]] == ["implied-start", "start-at-most"]
    assert ("symmetric" in [x["rule"] for x in parts]) == (name == "g6245-w3")


@pytest.mark.slow
def test_an_order_of_an_enclosed_start_that_is_not_the_right_one() -> None:
    """No rule says that the order is higher than declared, and no certificate is written."""
    said = "The start is proved to be the starting series that the equations give"
    assert said in written(shipped("s3-w3"), "starting-order", 5)
    assert proved(shipped("s3-w3"), "starting-order", 7)[0] is False


@pytest.mark.parametrize("root", ["sqrt(2)", "sqrt(2+sqrt(2))", "root(2,3)"])
def test_radicals_beside_decimals_stand_in_the_field(root: str) -> None:
    d = {"class": "glm", "A": [["0.50000000"]], "U": [["1", root]], "B": [["1"], [root]],
         "V": [["1", "0"], ["0", "1/2"]], "digits": 8}  # fmt: skip
    for claim, declared in (("preconsistent", True), ("symmetric", False), ("order", 1)):
        found = written(d, claim, declared)
        assert root in found["field"]["radicals"]
        assert judge.verdict(found)[0]
        del found["field"]["radicals"][root]
        assert not judge.verdict(found)[0]


@pytest.mark.sampled(1, besides=("tsitouras", "s3"))
@pytest.mark.parametrize("name", ["tsitouras-5-4", "s3-w3", "rodas4", "ros34pw2", "ros3p"])
def test_orders_at_below_and_above_those_of_a_file_are_certified(name: str) -> None:
    """A sweep form asks for the equations of the order claimed, so that no other one is tried."""
    claims = shipped(name)["claims"]
    for claim in ("order", "stage-order", "w-order", "embedded-order"):
        right = claims.get(claim)
        for more in (0, -1, 1, 3) if name != "s3-w3" or claim == "stage-order" else (0,):
            if isinstance(right, int):
                assert proved(shipped(name), claim, right + more)[0] == (more == 0), (claim, more)
            elif right is not None:
                declared = {row: p + more for row, p in right.items()}
                assert proved(shipped(name), claim, declared)[0] == (more == 0), (claim, more)


def test_the_field_of_a_growth_equation_holds_its_eigenvalue() -> None:
    """Numbers that stand in the names of equations alone are in the field of the certificate."""
    texts = ["order [oo]", "growth i", "growth q sqrt(3)/2+i/2", "growth p -1", "abscissa 1 = 2/3"]
    found = equation_numbers({"enclosure": {"equations": texts}})
    assert found == ["i", "sqrt(3)/2+i/2", "-1"]
    assert equation_numbers({}) == []


@pytest.mark.parametrize("name", ["i", "with i", "sqrt(", "root of it", "exp(x)"])
def test_names_of_rows_are_no_numbers(name: str) -> None:
    """An error ended `certify` where a row was called `sqrt(`."""
    d = {k: v for k, v in shipped("bogacki-shampine-3-2").items() if k != "claims"}
    d["embedded"][0]["name"] = name
    assert proved(d, "embedded-order", {name: 2})[0]
    found = written(d, "embedded-order", {name: 2})
    assert found["field"] == {"kind": "rational"}


def test_eigenvalues_that_are_rational_and_complex_stand_in_the_field() -> None:
    V = [["1", "0", "0"], ["0", "3/5", "-4/5"], ["0", "4/5", "3/5"]]
    d = {"class": "glm", "A": [["0"]], "U": [["1", "0", "0"]], "B": [["1"], ["1"], ["0"]], "V": V}
    holds, parts = proved(d, "growth", ["0", "0"])
    assert holds
    assert parts[0]["witness"]["zeta"] == ["1", "(3+4*i)/5", "(3-4*i)/5"]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("claim", "trees", "failing"),
    [("starting-order", "all", "f[fff]"), ("nystrom-starting-order", "nystrom", "f[k[ff]]")],
)
def test_an_exact_start_of_a_pair_is_judged_on_the_trees_of_its_claim(claim, trees, failing):
    for declared in (2, 3, 4):
        holds, parts = proved(shipped("gsymplectic-n-pair"), claim, declared)
        assert holds == (declared == 3)
        assert [x["witness"]["trees"] for x in parts[:2]] == [trees, trees]
        assert parts[2:] == [
            {"rule": "start-at-least", "witness": {"q": 3}},
            {"rule": "start-at-most", "witness": {"q": 3, "tree": failing}},
        ]


@pytest.mark.parametrize("letters", ["A", "B", "AB"])
def test_abscissae_that_are_certainly_others(letters: str) -> None:
    """The abscissae before the entries were rounded are not refuted by the same part."""
    for seed in (1, 2, 10, 27):
        d = rounded(single(seed), letters)
        found = written(d, "abscissae", ["9"] * len(d["A"]))
        assert isinstance(found, dict)
        assert proved(d, "abscissae", ["9"] * len(d["A"]))[0] is False
        c = facts_for(load_document({**HEAD, **single(seed)})).abscissae
        assert c is not None
        right = [to_text(x) for x in c]
        found["statement"]["declared"] = found["document"]["claims"]["abscissae"] = right
        accepted, why = judge.verdict(found)
        assert not accepted
        assert why.startswith("other-abscissae needs: The declared list has another length, or"), (
            why
        )


@pytest.mark.sampled(1)
@pytest.mark.parametrize("claim", ["order", "order-identity", "effective-order"])
def test_an_order_along_paths_is_certified(claim: str) -> None:
    """`effective-order` alone, for which the other series had not been made, was a KeyError."""
    d = {k: v for k, v in shipped("multistep-10").items() if k != "claims"}
    for declared in (9, 10, 11):
        holds, parts = proved(d, claim, declared)
        assert holds == (declared == 10)
        assert {x["witness"]["trees"] for x in parts} == {"paths"}
        assert parts[-1]["witness"]["tree"] == "f[k[" * 5 + "f" + "]" * 10


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("key", "tree"), [("B", "f"), ("B_hat", "k")])
def test_a_start_of_a_pair_that_is_wrong_at_once(key: str, tree: str) -> None:
    d = {k: v for k, v in shipped("gsymplectic-n-pair").items() if k != "claims"}
    d["starting"][key] = [["0"] * 3, ["1", "0", "0"]]
    for declared in (0, 1, 3):
        holds, parts = proved(d, "starting-order", declared)
        assert (holds, parts[-1]["witness"]["tree"]) == (declared == 0, tree)


@pytest.mark.parametrize("name", ["numerov", "stoermer-8"])
def test_orders_of_pairs_on_all_systems_and_on_those_of_second_order(name: str) -> None:
    claims = shipped(name)["claims"]
    d = {k: v for k, v in shipped(name).items() if k != "claims"}
    for claim in ("order", "nystrom-order", "order-identity"):
        for declared in range(claims[claim] - 1, claims[claim] + 2):
            assert proved(d, claim, declared)[0] == (declared == claims[claim]), claim
