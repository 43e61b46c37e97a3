"""Multistep methods: the record, the tables of docs/multivalue.md, and the labels of the files.

``python campaigns/partitioned/test_multistep.py`` puts the tables into docs/multivalue.md.
"""

import json
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from campaigns.partitioned.long_runs import Case
from campaigns.partitioned.multistep import (
    LONG,
    follow,
    long_table,
    needed,
    scan,
    table,
)
from campaigns.partitioned.multistep_search import coefficients
from glmref.catalogue.lookup import data_root, load
from glmref.derive.recipes.multistep import SHIPPED

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "multivalue.md"


def record(name):
    path = data_root() / "measurements" / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8"))


def filled(text):
    tables = {
        "multistep-1e-09": table(record("multistep"), "1e-09"),
        "multistep-1e-06": table(record("multistep"), "1e-06"),
        "multistep-long": long_table(record("multistep-long")),
    }
    for name, lines in tables.items():
        pattern = rf"(<!-- table: {name} -->\n).*?(<!-- end of table -->)"
        text, count = re.subn(pattern, rf"\g<1>{lines}\g<2>", text, flags=re.DOTALL)
        assert count == 1, name
    return text


def test_the_tables_of_the_page_are_those_of_the_data():
    text = PAGE.read_text(encoding="utf-8")
    assert filled(text) == text


def test_every_shipped_method_is_measured():
    assert {x["method"] for x in record("multistep-long")["runs"]} == set(SHIPPED)
    for entry in record("multistep")["cases"]:
        assert set(SHIPPED) <= {x["method"] for x in entry["methods"]}


def test_files_say_where_they_grow():
    grown = {x["method"] for x in record("multistep-long")["runs"] if not x["bounded"]}
    assert {name for name, shipped in SHIPPED.items() if shipped.notes} == grown


def test_the_best_of_some_is_found():
    entry = {"methods": [{"method": "a", "needed": {"1e-09": 7}}, {"method": "b", "needed": {}}]}
    assert needed(entry, ["a", "b"], "1e-09") == ("a", 7)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_a_long_run_is_repeated(name):
    case = LONG[1]
    stored = next(
        x for x in record("multistep-long")["runs"]
        if (x["method"], x["problem"]) == (name, case.problem)
    )  # fmt: skip
    again = follow(name, case, case.per_evaluation, 100_000).as_json()
    # a run of another length looks at other points of an orbit whose error has sharp peaks
    for found, known in zip(again["energy"][:2], stored["energy"][:2], strict=True):
        assert known / 10 < found < known * 10


def test_a_scan_calls_a_leap_of_the_error_a_hole():
    found = scan(load("stormer-verlet"), Case("harmonic-oscillator", 1.0), [0.1, 0.2, 0.3], 50)
    assert not found.holes
    assert np.isfinite(found.errors).all()


def test_the_weights_of_the_search_are_those_of_stormer_and_of_the_leapfrog():
    # no free root: v_n = v_{n-1} + h k, q + h v; one pair: the method of order 4 by hand
    a, b = coefficients((), (Fraction(0),))
    assert a.tolist() == [1, -1, 1, -1]
    assert b.sum() == pytest.approx(2)


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
