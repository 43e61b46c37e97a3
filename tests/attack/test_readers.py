"""Small attacks on the readers of records, problems and certificates; what they found."""

import json

import pytest

from glmref import Problem, load
from glmref.errors import BudgetError, UsageError
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
    scenes,
    surroundings,
    tableaux,
    texts,
    twins,
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
        (scenes, 30, ("refused", "planned")),
        (certificates, 12, ("no",)),
        pytest.param(scenes, 150, ("refused", "planned"), marks=pytest.mark.slow),
        pytest.param(certificates, 60, ("no", "yes"), marks=pytest.mark.slow),
    ],
)
def test_what_was_mutated_is_read_or_refused_with_a_sentence(attack, count, ends):
    tally = texts.attack(attack, count, 3)
    assert not tally.violations, tally.text()
    assert sum(tally.outcomes.values()) == count
    assert all(tally.outcomes[x] for x in ends), tally.text()


@pytest.mark.slow
@pytest.mark.parametrize(("count", "seed"), [(5, 3), (20, 4)])
def test_a_verdict_about_digits_is_true_of_every_method_in_them(count, seed):
    tally = twins.attack(count, seed)
    assert not tally.violations, tally.text()
    assert tally.outcomes["fails"] and tally.outcomes["open, in digits"]


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


def test_the_reciprocal_of_a_number_of_thousands_of_digits():
    large = Exact(10**1500)
    x = large * Exact(2).sqrt() + Exact(3).sqrt() + large * Exact(5).sqrt()
    assert abs(complex(x * (1 / x)) - 1) < 1e-9


def test_conjugates_look_at_the_budget():
    A = load("gauss-2").A
    with limited(0.0), pytest.raises(BudgetError):
        conjugate_transpose(A)
