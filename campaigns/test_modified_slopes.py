"""Drifts of modified energies: the record of a closed study, against the theory and the page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any

import pytest

from campaigns.driver import fingerprint
from campaigns.pages import ROOT, measured
from glmref import modified
from glmref.catalogue.lookup import load
from glmref.scenes.modified import Modified

ROWS = measured("modified-slopes")["rows"]
#: Trees are taken through these orders; order 1 is H itself.
ORDERS = (1, 5, 7, 9)
METHODS = ("gauss-2", "gsymplectic-n", "s4-symmetric", "s5z-w3", "stormer-verlet", "pair-4-4")
#: A slope is that of the next term within so much; the page says so.
WITHIN = 0.2


@cache
def _modified(name: str) -> Modified:
    return modified(load(name), ORDERS[-1] + 2)


def slopes(x: Mapping[str, Any]) -> list[float]:
    """Return by which powers of h the drifts of a row fall, one for each of ORDERS."""
    coarse, fine = x["drifts"]
    return [math.log2(a / b) for a, b in zip(coarse, fine, strict=True)]


def expected(name: str) -> list[int]:
    """Return the powers of h of the first term that is left out, for each of ORDERS.

    What is zero within 30 digits counts as zero: the coefficients of some methods are rounded.
    """
    known = _modified(name).invariant_terms.items()
    terms = [free.root.order for free, x in known if abs(complex(x)) > 1e-30]
    return [min(k for k in terms if k > n) - 1 for n in ORDERS]


def test_every_method_is_measured_on_every_problem_with_digits_to_spare():
    assert len({x["problem"] for x in ROWS}) == 5
    assert list(dict.fromkeys(x["method"] for x in ROWS)) == list(METHODS)
    assert len(ROWS) == 5 * len(METHODS)
    for x in ROWS:
        assert x["fingerprint"] == fingerprint(x["method"])
        assert min(map(min, x["drifts"])) > 1e-50  # of 60 digits
        for drift, parasitic in zip(x["drifts"], x["parasitic"], strict=True):
            assert parasitic < min(drift) / 100, (x["method"], x["problem"])


@pytest.mark.slow
@pytest.mark.sampled(1, whole=2)
@pytest.mark.parametrize("method", METHODS)
def test_every_drift_falls_by_the_power_of_the_next_term(method: str) -> None:
    for x in ROWS:
        if x["method"] == method:
            assert slopes(x) == pytest.approx(expected(method), abs=WITHIN), x["problem"]


def test_the_page_says_what_the_record_shows():
    said = " ".join((ROOT / "docs" / "modified.md").read_text(encoding="utf-8").split())
    assert "within 0.2 for four methods and two pairs on five problems over 100,000 steps" in said
    for x in ROWS:
        assert x["steps"] == 100_000
        assert slopes(x)[1:] == pytest.approx([6, 8, 10], abs=WITHIN), (x["method"], x["problem"])
