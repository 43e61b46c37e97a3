"""The claim of rounded coefficients: an order, and the largest residual of its conditions."""

import copy
import json
import random
from fractions import Fraction
from typing import Any

import pytest

from glmref import judge as plain_judge
from glmref.catalogue.claims import ORDER_TO_DIGITS
from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.errors import DataError
from glmref.exact.judging import fast_judge
from glmref.findings import Verdict
from glmref.judge import verdict
from glmref.judge.fixed_point import Sizes
from glmref.judge.grammar import two_digits
from glmref.judge.trees import read_tree, show
from glmref.prove import digits
from glmref.prove.analysis import _steps
from glmref.prove.digits import JUMP, LARGE, rounded_up
from glmref.prove.kernel import SMALL, Kernel
from glmref.prove.verifier import facts_for
from glmref.theory.trees import Tree, parse_tree, trees, trees_up_to
from tests.build import SOURCE, refused

KEY = ORDER_TO_DIGITS.key
#: Heun's method of order 3 with thirds of four digits, and an embedded row of order 2.
ROUNDED: dict[str, Any] = {
    "format": "glmref-method-2",
    "name": "rounded",
    "class": "rk",
    "A": [["0", "0", "0"], ["3333/10000", "0", "0"], ["0", "6667/10000", "0"]],
    "b": ["1/4", "0", "3/4"],
    "embedded": [{"name": "low", "b": ["0", "1", "0"]}],
    "claims": {KEY: {"b": [3, "3.4e-5"], "low": [1, "1.0e-9"]}},
    "source": SOURCE,
}


def judged(doc: dict[str, Any]) -> Any:
    facts = facts_for(load_document(doc))
    return facts.judge(KEY, doc["claims"][KEY])


def certified(doc: dict[str, Any]) -> dict[str, Any]:
    """The certificate of the verdict, as it is written."""
    facts = facts_for(load_document(doc))
    declared = doc["claims"][KEY]
    found = facts.judge(KEY, declared).certificate
    assert isinstance(found, dict), found
    return json.loads(json.dumps(found))


@pytest.mark.parametrize("halves", ["qp", "pq"])
def test_halves_with_the_same_weights_have_conditions_of_their_own(halves: str) -> None:
    """Of the two trees of order 2 one is wrong by 0.35, the other right to twelve digits."""
    b = ["1/2", "500000000001/1000000000000"]
    made = {
        half: {"A": [["0", "0"], [a, "0"]], "U": [["1"], ["1"]], "B": [b], "V": [["1"]]}
        for half, a in zip(halves, ("3/10", "999999999998/1000000000000"), strict=True)
    }
    given = {
        "format": "glmref-method-2", "name": "same-weights", "title": "x", "class": "partitioned",
        "separable": True, "source": SOURCE, "claims": {KEY: {"b": [2, "1.0e-12"]}}, **made,
    }  # fmt: skip
    found = judged(given)
    assert found.verdict is Verdict.FAILS


@pytest.mark.parametrize("judge", [plain_judge, fast_judge()], ids=["fractions", "flint"])
@pytest.mark.parametrize("alike", [False, True], ids=["own weights", "the same weights"])
@pytest.mark.parametrize("palette", [(("o", "o"),), (("f", "k"), ("k", "f"))], ids=["one", "pair"])
def test_residuals_of_one_order_are_bounded_all_at_once(
    judge: Any, palette: Any, alike: bool
) -> None:
    """Never below the residual, and above it by less than one part in 2^100."""
    draw, rational = random.Random(3), judge.arithmetic.Fraction
    rows = [[rational(draw.randrange(-99, 99), 97) for _ in range(3)] for _ in range(8)]
    tables = {c: rows[k : k + 3] for k, (c, _) in enumerate(palette)}
    sizes = judge.fixed_point.Sizes(tables, palette, "", False, 200)
    b = {c: sizes.weights(rows[-1 if alike else k - 2]) for k, (c, _) in enumerate(palette)}
    for n in range(1, 7):
        groups, level, bounds = sizes.groups(n, b), sizes.level(n), {}
        for group in groups:
            for k, gap in zip(group.places, group.gaps, strict=True):
                bounds[level[k]] = abs(gap), group.error
        assert bounds.keys() == set(level)
        for t, (near, error) in bounds.items():
            exactly = sizes.exactly(t, b[t[0]])
            assert near - error <= exactly <= near + error < near + sizes.one // 2**100, t
            assert t in sizes.above(n, b, near + error - 1)
            assert t not in sizes.above(n, b, near + error)
        assert n < 5 or len(groups) < len(level)


def without_rows(*claimed: Any) -> dict[str, Any]:
    doc = {k: v for k, v in ROUNDED.items() if k != "embedded"}
    return {**doc, "claims": {KEY: {"b": list(claimed)}}}


@pytest.mark.parametrize(
    ("claimed", "expected", "reason"),
    [
        ((3, "3.4e-5"), Verdict.HOLDS, ""),
        ((3, "3.5e-5"), Verdict.FAILS, "the residuals through order 3 are at most 3.4e-5"),
        ((3, "3.3e-5"), Verdict.FAILS, "tree [oo] of order 3 has residual"),
        ((2, "2.5e-5"), Verdict.FAILS, "no condition of order 3 has a residual above 1000 times"),
        ((4, "3.4e-5"), Verdict.FAILS, "of order 4 has residual"),
    ],
)
def test_order_and_size_are_decided(claimed: Any, expected: Verdict, reason: str) -> None:
    doc = without_rows(*claimed)
    found = judged(doc)
    assert (found.verdict, reason in found.reason) == (expected, True), found.reason
    assert verdict(certified(doc))[0]


@pytest.mark.parametrize(
    ("claimed", "witness", "others"),
    [
        ((3, "3.5e-5"), {"order": 3}, [{"order": 4}, {"order": 2}, {"tree": "[oo]"}, {}]),
        ((3, "3.3e-5"), {"tree": "[oo]"}, [{"tree": "[[o]]"}, {"tree": "[ooo]"}, {"order": 3}]),
        ((2, "2.5e-5"), {"order": 3}, [{"order": 2}, {"order": 4}, {"tree": "[o]"}]),
        ((3, "3.4e-5"), None, [{"order": 3}, {"order": 4}, {"tree": "[oo]"}]),
    ],
)
def test_what_refutes_is_checked(claimed: Any, witness: Any, others: Any) -> None:
    """The checker takes the witness of a refutation and no other, and none of what holds."""
    good = certified(without_rows(*claimed))
    if witness is not None:
        assert good["parts"] == [{"rule": "not-to-digits", "witness": {"row": "b", **witness}}]
    for other in others:
        bad = copy.deepcopy(good)
        bad["statement"]["verdict"] = "fails"
        bad["parts"] = [{"rule": "not-to-digits", "witness": {"row": "b", **other}}]
        assert not verdict(bad)[0], other


def test_every_row_is_named() -> None:
    doc = {**ROUNDED, "claims": {KEY: {"b": [3, "3.4e-5"]}}}
    found = judged(doc)
    assert found.verdict is Verdict.OPEN  # no rule refutes what does not name every row
    assert found.reason.startswith("the weights are b, low; no certificate is written")


def test_a_name_that_is_no_row_is_refused() -> None:
    doc = {**ROUNDED, "claims": {KEY: {**ROUNDED["claims"][KEY], "lower": [1, "1.0e-9"]}}}
    refused(DataError, 'names "lower", and the weights are b, low', load_document, doc)


def test_a_row_with_the_name_of_the_solution_is_refused() -> None:
    doc = {**ROUNDED, "embedded": [{"name": "b", "b": ["0", "1", "0"]}], "claims": {}}
    refused(DataError, "give the row another name", load_document, doc)


def test_the_row_that_fails_is_named_where_there_are_several() -> None:
    doc = {**ROUNDED, "claims": {KEY: {"b": [3, "3.3e-5"], "low": [1, "1.0e-9"]}}}
    assert judged(doc).reason.startswith("row b: tree [oo] of order 3")
    assert judged(without_rows(3, "3.3e-5")).reason.startswith("tree [oo] of order 3")


def test_residuals_that_are_zero_are_said_to_be() -> None:
    doc = {**without_rows(2, "1.0e-9"), "A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"]}
    reason = "the residuals through order 2 are 0: claim the order without size"
    assert (judged(doc).verdict, judged(doc).reason) == (Verdict.FAILS, reason)


@pytest.mark.slow
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "name",
    ["verner-robust-8-7-printed", "ros3-printed", "kennedy-carpenter-ark-5-4-printed",
     "dormand-prince-rkn-12-10"],
)  # fmt: skip
def test_shipped_files_hold_and_near_misses_fail(name: str) -> None:
    doc = dict(document(name))
    assert judged(doc).verdict is Verdict.HOLDS
    for row, (order, size) in doc["claims"][KEY].items():
        digits, _, power = size.partition("e")
        less = f"{float(digits) - 0.1:.1f}e{power}"
        for wrong in ([order, less], [order + 1, size], [order - 1, size]):
            changed = copy.deepcopy(doc)
            changed["claims"][KEY][row] = wrong
            assert judged(changed).verdict is Verdict.FAILS, (row, wrong)


def test_the_checker_accepts_it_and_refuses_what_is_changed() -> None:
    good = certified(dict(document("verner-robust-8-7-printed")))
    assert verdict(good)[0]
    for change in ("size", "order", "largest", "beyond", "entry"):
        bad = copy.deepcopy(good)
        rows = bad["parts"][0]["witness"]["rows"]["b"]
        claimed = bad["document"]["claims"][KEY]["b"]
        if change == "size":
            claimed[1] = "2.3e-41"
        elif change == "order":
            claimed[0] = 7
        elif change == "entry":
            bad["document"]["A"][1][0] = "1/5"
        else:
            rows[change] = "o"
        bad["statement"]["declared"] = bad["document"]["claims"][KEY]
        assert not verdict(bad)[0], change


def accepted(doc: dict[str, Any]) -> Any:
    """The judgement, whose certificate the checker accepts."""
    assert verdict(certified(doc))[0]
    return judged(doc)


def test_a_residual_that_is_the_number_itself_is_decided() -> None:
    doc = {**without_rows(1, "1.0e-4"), "A": [["0"]], "b": ["9999/10000"]}
    assert accepted(doc).verdict is Verdict.HOLDS
    doc["claims"] = {KEY: {"b": [1, "1.1e-4"]}}  # the number before it is the residual itself
    assert accepted(doc).reason == "the residuals through order 1 are at most 1.0e-4"


def test_weights_that_cancel_in_many_digits_are_decided() -> None:
    """Their errors, which are as large as the weights, would hide the residual."""
    large = 10**70
    b = [str(large), str(Fraction(100049, 100000) - large)]
    doc = {**without_rows(1, "4.9e-4"), "A": [["0", "0"], ["0", "0"]], "b": b}
    assert accepted(doc).verdict is Verdict.HOLDS
    doc["claims"][KEY]["b"] = [1, "4.8e-4"]
    assert accepted(doc).reason == "tree o of order 1 has residual 4.9e-4"


@pytest.mark.parametrize(("more", "expected"), [(1, "holds"), (0, "fails"), (-1, "fails")])
def test_a_gap_that_only_the_number_itself_decides(more: int, expected: str) -> None:
    """The residual of order 2 is 1000 times the size, and ``more`` units of the 77th place."""
    residual = Fraction(1, 2) + 1000 * Fraction("4.9e-4") + Fraction(more, 10**77)
    weight = Fraction(100049, 100000)
    doc = {**without_rows(1, "4.9e-4"), "A": [[str(residual / weight)]], "b": [str(weight)]}
    assert str(accepted(doc).verdict) == expected


def test_the_residual_that_refutes_is_told_rounded_up_itself() -> None:
    """It is 1e-10, and no upper bound of it, which two digits would show as 1.1e-10."""
    doc = {**without_rows(1, "9.9e-11"), "A": [["0"]], "b": [str(1 + Fraction(1, 10**10))]}
    assert accepted(doc).reason == "tree o of order 1 has residual 1.0e-10"
    doc = {**doc, "class": "nystrom", "b": ["1/2"], "b_prime": [str(1 + Fraction(1, 10**6))],
           "c": ["1/2"], "claims": {KEY: {"b": [2, "5.0e-7"]}}}  # fmt: skip
    assert accepted(doc).reason == "tree k of order 1 has residual 1.0e-6"


def test_splittings_are_judged_on_all_trees() -> None:
    """McLachlan and Atela's has order 4 where the kinetic energy is quadratic, and 3 at large."""
    doc = copy.deepcopy(dict(document("mclachlan-atela-4")))
    unknowns = {x: Fraction(text[:42]) for x, text in doc.pop("unknowns").items()}
    for key in ("enclosure", "digits"):
        doc.pop(key)
    b2 = Fraction(doc.pop("constants")["b2"])
    a = [unknowns[x] for x in ("a1", "a2", "a3")]
    b = [unknowns["b1"], b2, unknowns["b3"]]
    doc |= {"a": [*map(str, a), str(1 - sum(a))], "b": [*map(str, b), str(1 - sum(b))]}
    doc["claims"] = {KEY: {"b": [4, "8.3e-40"]}}
    assert accepted(doc).reason == "tree f[kkk] of order 4 has residual 1.1e-2"
    doc["claims"] = {KEY: {"b": [3, "8.3e-40"]}}
    bad = certified(doc)
    assert verdict(bad)[0]
    bad["statement"]["declared"]["b"][0] = bad["document"]["claims"][KEY]["b"][0] = 4
    bad["parts"][0]["witness"]["rows"]["b"] = {"largest": "k[ff]", "beyond": "f[k[fff]]"}
    accepts, why = verdict(bad)
    assert not accepts and why.startswith("to-digits needs at tree f[kkk]: No residual through")


def slopes(A: list[list[Fraction]], t: Tree) -> list[Fraction]:
    """Phi(t) at the stages, by definition."""
    value = [Fraction(1)] * len(A)
    for child in t.children:
        value = [x * y for x, y in zip(value, stages(A, child), strict=True)]
    return value


def stages(A: list[list[Fraction]], t: Tree) -> list[Fraction]:
    """A Phi(t)."""
    inner = slopes(A, t)
    return [sum(map(Fraction.__mul__, row, inner), Fraction(0)) for row in A]


def residual(A: list[list[Fraction]], b: list[Fraction], t: Tree) -> Fraction:
    """``|b Phi(t) - 1 / gamma(t)|``."""
    return abs(sum(map(Fraction.__mul__, b, slopes(A, t)), Fraction(0)) - Fraction(1, t.density))


def rounded_method(seed: int) -> tuple[list[list[Fraction]], list[Fraction]]:
    """Heun's method of order 3, or the midpoint rule, with entries off by up to 9e-6."""
    draw = random.Random(seed)

    def off(x: Fraction) -> Fraction:
        return x + Fraction(draw.choice((-1, 1)) * draw.randint(1, 9), 10 ** draw.randint(6, 9))

    third = Fraction(1, 3)
    if seed % 2:
        return [[off(Fraction(1, 2))]], [off(Fraction(1))]
    A = [[Fraction(0)] * 3, [off(third), Fraction(0), Fraction(0)],
         [Fraction(0), off(2 * third), Fraction(0)]]  # fmt: skip
    return A, [off(Fraction(1, 4)), Fraction(0), off(Fraction(3, 4))]


def kernel_of(A: list[list[Fraction]], b: list[Fraction]) -> Kernel:
    table = {"A": [[str(x) for x in row] for row in A], "b": [str(x) for x in b], "claims": {}}
    doc = {k: v for k, v in ROUNDED.items() if k != "embedded"} | table
    return facts_for(load_document(doc)).kernel


@pytest.mark.parametrize("seed", range(8))
def test_sizes_are_those_of_fractions(seed: int) -> None:
    A, b = rounded_method(seed)
    found = kernel_of(A, b).sizes_to_digits["b"]
    wanted, n = [Fraction(0)], 0
    while wanted[-1] <= LARGE and n < 10:
        n += 1
        wanted.append(max(wanted[-1], *(residual(A, b, t) for t in trees(n))))
    assert [rounded_up(x) for x in found] == [rounded_up(x) for x in wanted]


@pytest.mark.parametrize(("more", "goes_on"), [(0, True), (Fraction(1, 10**30), False)])
def test_a_thousandth_is_the_largest_rounding(more: Fraction, goes_on: bool) -> None:
    """Through order 1 the residual is b - 1 itself."""
    b = Fraction(1001, 1000) + more
    found = kernel_of([[Fraction(1, 2)]], [b]).sizes_to_digits["b"]
    assert (len(found) > 2) == goes_on


@pytest.mark.parametrize("seed", [0, 1, 2, 4])
def test_beyond_the_last_order_sizes_end_with_the_next(seed, monkeypatch):
    A, b = rounded_method(seed)
    last = 1 if seed % 2 else 2
    monkeypatch.setattr(Kernel, "_most", lambda self, *, nystrom: last)
    found = kernel_of(A, b).sizes_to_digits["b"]
    wanted = [max((residual(A, b, t) for m in range(1, n + 1) for t in trees(m)), default=0)
              for n in range(last + 2)]  # fmt: skip
    assert [rounded_up(x) for x in found] == [rounded_up(Fraction(x)) for x in wanted]


def test_of_many_trees_no_residual_above_a_rounding_goes_on(monkeypatch):
    half = Fraction(1, 2)
    for many, off, length in ((0, 8, 3), (0, 10, 4), (1, 8, 4)):
        monkeypatch.setattr(digits, "MANY", many)
        kernel = kernel_of([[half + Fraction(1, 10**off)]], [Fraction(1)])
        assert len(kernel.sizes_to_digits["b"]) == length, (many, off)


@pytest.mark.parametrize("seed", range(8))
def test_near_misses_on_both_sides_of_the_bound(seed: int) -> None:
    """A size of two digits is refused one unit below and one above that of the fractions."""
    A, b = rounded_method(seed)
    order = 2 if seed % 2 else 3
    size = max(residual(A, b, t) for n in range(1, order + 1) for t in trees(n))
    right = rounded_up(size)
    unit = Fraction(10) ** (int(right.partition("e")[2]) - 1)
    rows = {"A": [[str(x) for x in row] for row in A], "b": [str(x) for x in b]}
    above = rounded_up(Fraction(right) + unit)
    below = rounded_up(two_digits(right)[1])
    for claimed, expected in ((right, "holds"), (above, "fails"), (below, "fails")):
        found = accepted({**without_rows(order, claimed), **rows})
        assert str(found.verdict) == expected, claimed


@pytest.mark.parametrize("s", [1, 2, 5, 9])
@pytest.mark.parametrize("bits", [6, 12])
def test_radii_bound_what_few_bits_lose(s: int, bits: int) -> None:
    """Every entry loses nearly a unit; numbers are as large as a unit is small, or larger."""
    draw, unit = random.Random(s), Fraction(1, 1 << bits)

    def entries(largest: int) -> list[Fraction]:
        return [(draw.randint(-largest, largest) + Fraction(999, 1000)) * unit for _ in range(s)]

    for largest in (1, 1 << bits, 4 << bits):
        A, b = [entries(largest) for _ in range(s)], entries(largest)
        fixed = Sizes({"o": A}, (("o", "o"),), "", False, bits)
        weights = fixed.weights(b)
        row = [
            sum(x * y for x, y in zip(b, column, strict=True)) for column in zip(*A, strict=True)
        ]
        before = fixed.before(weights, "o")
        assert (
            max(abs(x - y / unit) for x, y in zip(before.values, row, strict=True)) <= before.radius
        )
        for tree in trees_up_to(4):
            for found, exact in ((fixed.phi(read_tree(str(tree))), slopes(A, tree)),
                                 (fixed.below(read_tree(str(tree))), stages(A, tree))):  # fmt: skip
                lost = [abs(x - y / unit) for x, y in zip(found.values, exact, strict=True)]
                assert max(lost) <= found.radius, tree
                assert found.size == max(map(abs, found.values))
            low, high = fixed.residual(read_tree(str(tree)), weights)
            assert low <= residual(A, b, tree) / unit <= high
        for n in range(1, 6):
            for group in fixed.groups(n, {"o": weights}):
                for k, gap in zip(group.places, group.gaps, strict=True):
                    tree = parse_tree(show(fixed.level(n)[k]))
                    off = abs(abs(gap) - residual(A, b, tree) / unit)
                    assert off <= group.error, tree


def test_a_next_order_that_is_exact_keeps_the_residual_of_the_last(monkeypatch):
    """b is off by 1e-4, and b a is 1/2: the list does not fall."""
    monkeypatch.setattr(Kernel, "_most", lambda self, *, nystrom: 1)
    b = 1 + Fraction(1, 10**4)
    found = kernel_of([[1 / (2 * b)]], [b]).sizes_to_digits["b"]
    assert [rounded_up(x) for x in found] == ["0", "1.0e-4", "1.0e-4"]


@pytest.mark.parametrize("place", [60, 70, 90, 300])
def test_a_residual_too_small_for_the_units_is_told_by_a_bound(place: int) -> None:
    """It is not 0, and neither is what is said of it."""
    doc = {**without_rows(1, "1.0e-9"), "A": [["0"]], "b": [str(1 + Fraction(1, 10**place))]}
    reason = accepted(doc).reason
    assert reason.startswith("the residuals through order 1 are at most ")
    bound = Fraction(reason.rpartition(" ")[2])
    assert Fraction(1, 10**place) <= bound < Fraction(1, 10**50)


def test_steps_are_orders_that_are_nearly_reached() -> None:
    """Below the smallest residual that is no rounding, and a hundred times below the next."""
    tiny, jump = Fraction(1, 10**12), Fraction(int(JUMP))
    small, one = Fraction(SMALL), Fraction(1)
    assert _steps([Fraction(0), tiny, tiny, one], 0) == "order 2 to 1.0e-12, order 0 exactly"
    assert _steps([Fraction(0), tiny, tiny, one], 2) == ""
    assert _steps([Fraction(0), Fraction(0), one], 0) == ""
    assert _steps([Fraction(0), tiny, tiny * jump], 0) == ""
    assert (
        _steps([Fraction(0), tiny, tiny * jump + tiny], 0) == "order 1 to 1.0e-12, order 0 exactly"
    )
    assert _steps([Fraction(0), small, one], 0) == ""
    assert _steps([Fraction(0), small * Fraction(99, 100), one], 0) != ""
