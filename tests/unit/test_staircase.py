"""Rounded tableaux: which order holds to how many digits, and orders up to 14."""

import warnings
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import glmref
from glmref.catalogue.lookup import document as shipped
from glmref.catalogue.reader import load_document
from glmref.prove.analysis import analyze
from glmref.views.facts import analysis_rows
from tests.build import SOURCE


def extrapolated_midpoint(columns: int) -> tuple[list[list[Fraction]], list[Fraction]]:
    """The explicit midpoint rule with 2, 4, .. substeps, extrapolated to order 2 ``columns``.

    Hairer, Norsett, Wanner (1993), II.9.
    """
    rows: list[dict[int, Fraction]] = [{}]
    b: dict[int, Fraction] = {}
    counts = [2 * j for j in range(1, columns + 1)]
    for n in counts:
        before, now = {}, {0: Fraction(1, n)}
        for _ in range(1, n):
            rows.append(now)
            after = dict(before)
            after[len(rows) - 1] = Fraction(2, n)
            before, now = now, after
        weight = Fraction(1)
        for m in counts:
            if m != n:
                weight *= Fraction(n * n, n * n - m * m)
        for j, x in now.items():
            b[j] = b.get(j, Fraction(0)) + weight * x
    stages = range(len(rows))
    zero = Fraction(0)
    return [[row.get(j, zero) for j in stages] for row in rows], [b.get(j, zero) for j in stages]


def rounded(x: Fraction, digits: int) -> str:
    with localcontext() as context:
        context.prec = 2 * digits
        value = Decimal(x.numerator) / Decimal(x.denominator)
        return format(value.quantize(Decimal(1).scaleb(-digits)), "f") if x else "0"


def document(columns: int, write: Any, **more: Any) -> dict[str, Any]:
    A, b = extrapolated_midpoint(columns)
    return {
        "format": "glmref-method-1", "name": "extrapolated", "title": "t", "class": "rk",
        "A": [[write(x) for x in row] for row in A], "b": [write(x) for x in b],
        "claims": {}, "source": SOURCE, **more,
    }  # fmt: skip


def test_decimals_say_order_and_digits() -> None:
    found = analyze(load_document(document(3, lambda x: rounded(x, 33), digits=33)))
    assert (found.order, found.order_proved) == (6, [0, 6])
    assert found.order_witness.startswith("order 6 to ")
    size = float(found.order_witness.split()[3].rstrip(","))
    assert 1e-34 < size < 1e-31


def test_rounded_decimals_have_their_order_to_digits() -> None:
    found = analyze(load_document(document(3, lambda x: str(Fraction(rounded(x, 33))))))
    assert (found.order, found.order_proved, str(found.proof)) == (6, [0, 6], "measured")
    assert found.order_to_digits is not None and 1e-34 < float(found.order_to_digits) < 1e-31
    assert f"order 6 to {found.order_to_digits}, " in repr(found)
    (row,) = [text for name, text in analysis_rows(found.as_json()) if name == "order"]
    assert row.startswith(f"6 to {found.order_to_digits}, ")
    assert found.order_witness.startswith("order 6 to ")
    assert "order 0 exactly" in found.order_witness


@pytest.mark.parametrize("name", ["forest-ruth-4", "yoshida-4", "rk4"])
def test_a_method_in_doubles_has_its_order_to_16_digits(name: str) -> None:
    exact = glmref.load(name)
    doubles = {x: np.array(y, dtype=float) for x, y in vars(exact).items() if x[0] in "AUBV"
               and x.partition("_")[0] in "AUBV"}  # fmt: skip
    if name == "forest-ruth-4":
        doubles["separable"] = True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = analyze(type(exact)(**doubles))
    assert found.order == 4 and set(found.error_constants) == set(analyze(exact).error_constants)
    assert found.order_to_digits is not None and 1e-17 < float(found.order_to_digits) < 1e-15


def test_an_exact_method_has_no_staircase() -> None:
    found = analyze(load_document(document(3, str)))
    assert (found.order, found.order_proved) == (6, [6, 6])
    assert found.order_witness.startswith("tree [oooooo] of order 7")


@pytest.mark.slow
def test_order_14_is_found() -> None:
    found = analyze(load_document(document(7, lambda x: rounded(x, 60), digits=60)))
    assert (found.order, found.order_proved) == (14, [0, 14])
    assert found.order_witness.startswith("order 14 to ")


def two_values(a: str, digits: int) -> dict[str, Any]:
    """V = I: both values are the solution. Order 2 for a = 1; W R([o]) is (a - 1) / 2."""
    return {
        "format": "glmref-method-1", "name": "two-values", "title": "t", "class": "glm",
        "digits": digits, "A": [["0", "0"], [a, "0"]], "U": [["1", "0"], ["0", "1"]],
        "B": [[f"{x:.{digits}f}" for x in row] for row in ((0.25, 0.75), (0.75, 0.25))], "V": [["1", "0"], ["0", "1"]],
        "claims": {}, "source": SOURCE,
    }  # fmt: skip


def test_a_multiple_eigenvalue_in_decimals_is_decided() -> None:
    found = analyze(load_document(two_values("1.00003000000000000000", 20)))
    assert (found.order, found.order_proved) == (1, [0, 1])
    assert "order 2 to 3.1e-5, order 1 to " in found.order_witness
    assert "tree [o] of order 2" in found.order_witness
    exact = analyze(load_document(two_values("1.00000000000000000000", 20)))
    assert exact.order == 2


@pytest.mark.parametrize("name", ["ros3-printed", "imkg-353-printed", "ars-3-4-3-printed"])
def test_the_sizes_shown_are_those_that_are_claimed(name: str) -> None:
    claimed = shipped(name)["claims"]["order-to-digits"]
    witness = analyze(name).order_witness
    for row, (order, size) in claimed.items():
        said = f"order {order} to {size}, order "
        assert (f"row {row}: {said}" if len(claimed) > 1 else said) in witness


@pytest.mark.slow
def test_second_order_systems_and_rows_have_a_staircase() -> None:
    found = analyze("dormand-prince-rkn-12-10")
    assert found.order_witness.startswith(
        "on second-order systems row b: order 12 to 1.2e-54, order 2 exactly; row embedded: order "
        "10 to 1.8e-54, order 2 exactly; tree f[kk] of order 3"
    )


def test_a_size_that_is_a_short_decimal_is_not_rounded_up() -> None:
    weights = ["0.5", "0.500000001"]
    doc = {**document(1, str), "A": [["0", "0"], ["1", "0"]], "b": weights}
    texts = [str(Fraction(x)) for x in weights]
    found = analyze(load_document({**doc, "b": texts}))
    assert "order 2 to 1.0e-9, order 0 exactly" in found.order_witness


def test_residuals_beyond_the_range_of_doubles_are_analyzed() -> None:
    huge = "9" * 600
    b = ["sqrt(2)/2", "(2-sqrt(2))/2"]  # which is measured, where rational numbers are bounded
    parts = [{"A": [["0", "0"], ["1", "0"]], "b": b}, {"A": [["1", "0"], [huge, "0"]], "b": b}]
    content = {
        "format": "glmref-method-1", "name": "huge", "class": "additive", "parts": parts,
        "claims": {}, "source": SOURCE,
    }  # fmt: skip
    assert analyze(load_document(content)).order == 1
