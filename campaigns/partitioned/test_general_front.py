"""Methods found by a search beside those shipped: what the record has, and what the page says."""

import math
from fractions import Fraction
from pathlib import Path

import pytest

from campaigns.pages import measured
from campaigns.partitioned.general_front import (
    FOUND,
    METHODS,
    interval,
    method_of,
    over,
    separation,
    turning,
)
from glmref.derive.halves import GeneralHalf

#: The cosine of a root beside -1.
BESIDE = Fraction(-511, 512)
ROWS = {x["method"]: x for x in measured("nonseparable")["front"]}
PAGE = " ".join((Path(__file__).parents[2] / "docs" / "nonseparable.md").read_text("utf-8").split())


@pytest.mark.parametrize("name", ROWS)
def test_what_is_recorded_of_the_roots_follows_from_them(name: str) -> None:
    _, q, p = method_of(name)
    x = ROWS[name]
    assert [interval(q, p, [turning(omega)]) for omega in (0.0, 1.0)] == x["interval"]
    assert float(q.error_constant) == float(p.error_constant)
    assert math.isclose(float(q.error_constant), x["error_constant"], rel_tol=5e-3)
    assert math.isclose(separation(q, p), x["separation"], rel_tol=5e-3)
    largest = max(abs(float(mu)) for half in (q, p) for mu in half.residues)
    assert math.isclose(largest, x["residue"], rel_tol=5e-3)


def test_conjugate_roots_beside_minus_one_are_near_each_other() -> None:
    halves = (
        GeneralHalf((x, y)) for x, y in ((Fraction(0), BESIDE), (Fraction(1, 2), Fraction(-1, 2)))
    )
    assert math.isclose(separation(*halves), 2 * (180 - math.degrees(math.acos(BESIDE))))


def test_the_page_says_what_the_search_found() -> None:
    assert tuple(ROWS) == (*METHODS, *FOUND)
    first, *_ = ROWS.values()
    found = [ROWS[name] for name in (METHODS[1], *FOUND)]
    ratios, residues = [over(x, first) for x in found], [x["residue"] for x in found]
    constants = [-x["error_constant"] for x in found if x["order"] == 8]
    assert f"{min(ratios):.2f} to {max(ratios):.2f} of the evaluations of `-8b`" in PAGE
    assert f"residues of {min(residues):.1f} to {max(residues):.1f}" in PAGE
    assert max(constants) < 0.2
    assert all(x["kept"][k] <= ROWS[METHODS[2]]["kept"][k] for x in found for k in (0, 1))
    assert f"one of {['five', 'six', 'seven'][len(found) - 5]} methods from a search" in PAGE
