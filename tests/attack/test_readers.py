"""Small attacks on the readers of records, problems, vectors and certificates; what they found."""

from __future__ import annotations

import json

import pytest

from glmref import Problem, load
from glmref.conformance.vectors import vectors_of
from glmref.errors import BudgetError, DataError, UsageError
from glmref.exact import Exact
from glmref.exact.linalg import conjugate_transpose
from glmref.system.budget import limited
from tests.build import refused

from . import (
    campaigns,
    certificates,
    imports,
    problems,
    records,
    surroundings,
    tableaux,
    texts,
    vectors,
)  # fmt: skip


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("attack", "count", "ends"),
    [
        (records, 60, ("4 of 4 records", "3 of 4 records")),
        (problems, 80, ("refused", "run completed")),
        (campaigns, 60, ("refused", "planned", "problem")),
        (tableaux, 60, ("refused", "unread", "holds")),
        (imports, 60, ("refused", "read", "exported")),
        (surroundings, 30, ("damaged entry", "the same")),
        (vectors, 6, ("refused",)),
        pytest.param(vectors, 40, ("refused", "holds"), marks=pytest.mark.slow),
        (certificates, 12, ("no",)),
        pytest.param(certificates, 60, ("no", "yes"), marks=pytest.mark.slow),
    ],
)
def test_what_was_mutated_is_read_or_refused_with_a_sentence(attack, count, ends):
    tally = texts.attack(attack, count, 3)
    assert not tally.violations, tally.text()
    assert sum(tally.outcomes.values()) == count
    assert all(tally.outcomes[x] for x in ends), tally.text()


def test_the_attack_sees_a_record_that_nobody_wrote(monkeypatch):
    class Wrong(records.Records):
        def __iter__(self):
            return ({**record, "error": 0.25} for record in super().__iter__())

    monkeypatch.setattr(records, "Records", Wrong)
    tally = texts.attack(records, 5, 1)
    assert any("a run reads what nobody wrote" in x for x in tally.violations)


@pytest.mark.slow
def test_the_attack_sees_a_certificate_of_what_is_false():
    (rk4,) = (x for x in certificates.sound()
              if (x["statement"]["method"], x["statement"]["claim"]) == ("rk4", "order"))  # fmt: skip
    assert not list(certificates._false(rk4))
    rk4 = json.loads(json.dumps(rk4))
    rk4["statement"]["declared"] = 5
    (said,) = certificates._false(rk4)
    assert "accepted as holds, and it fails" in said


# --- what they found ------------------------------------------------------------------------------


def test_a_nested_formula_is_refused_with_a_short_sentence():
    for text in ("-" * 3000 + "1", "+".join(["y[0]"] * 3000), "(" * 3000, "t." + "x" * 5000):
        try:
            Problem(f=(text,), y0=(1.0,))
        except UsageError as error:
            assert len(str(error)) < 300
        else:  # right formulas, which newer versions of Python nest as deep
            assert text[0] in "-y"


@pytest.mark.parametrize(
    "given", [{"f": [["0"] * 900]}, {"y0": [float("nan")] * 900}, {"y0": "1" * 900}]
)
def test_a_problem_that_is_none_is_refused_with_a_short_sentence(given):
    caught = refused(UsageError, "", Problem, **{"f": ("y[0]",), "y0": (1.0,)} | given)
    assert len(caught) < 200


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("cases", 0, "kind"), None), (("cases", 0, "h"), "0"), (("cases", 0, "output"), [["1"]]),
        (("cases", 0, "problem"), "zzz"), (("cases", 0, "input"), [["x", "1"]]), (("values",), "x"),
        (("cases", 0, "bound"), "nan"), (("coefficients", "A"), [["1"], ["1", "2"]]),
        (("cases", 0, "id"), "<script>"), (("cases", 0, "stages"), [["0", "1"], ["2"]]),
        (("cases", 0, "stages"), [["0"]]), (("cases", 0, "flags"), ["zzz"]),
        (("cases", 0, "conserved"), "inf"), (("coefficients", "c"), ["0"]),
        (("cases", 10, "rows", 3, "error"), "0"),
        (("cases", 10, "rows", 3, "steps"), 10_001),
        (("cases", 5, "wrong", 0, "output"), [["1"]]), (("cases", 5, "wrong", 0, "flag"), "zzz"),
    ],
)  # fmt: skip
def test_a_vector_file_that_is_not_as_specified_is_refused(tmp_path, monkeypatch, place, value):
    doc = json.loads(json.dumps(vectors.sound()["rk4"]))
    *path, last = place
    block = doc
    for key in path:
        block = block[key]
    block[last] = value
    (tmp_path / "rk4.json").write_text(json.dumps(doc))
    (tmp_path / "problems.json").write_text(json.dumps(vectors.sound()["problems"]))
    for module in (vectors.vector_problems, vectors.vectors):
        monkeypatch.setattr(module, "folder", lambda: tmp_path)
    vectors._forget()
    try:
        refused(DataError, r"rk4\.json: the file is not as data/vectors/README", vectors_of, "rk4")
    finally:
        vectors._forget()


@pytest.mark.parametrize(
    "matrix", [[["1", "0"], ["0", "("]], [["1"], ["0", "1"]], [[1, 0], [0, 1]]]
)
def test_a_quadratic_form_that_is_none_is_refused_by_its_problem(matrix):
    doc = json.loads(json.dumps(vectors.sound()["problems"]))
    doc["problems"][0]["quadratic"] = matrix
    with pytest.raises(ValueError, match="quadratic of linear"):
        vectors.vector_problems._problems(doc)


def test_the_reciprocal_of_a_number_of_thousands_of_digits():
    large = Exact(10**1500)
    x = large * Exact(2).sqrt() + Exact(3).sqrt() + large * Exact(5).sqrt()
    assert abs(complex(x * (1 / x)) - 1) < 1e-9


def test_conjugates_look_at_the_budget():
    A = load("gauss-2").A
    with limited(0.0), pytest.raises(BudgetError):
        conjugate_transpose(A)
