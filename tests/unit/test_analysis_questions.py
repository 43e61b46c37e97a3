"""What ``analyze`` says where a question has no answer, and that one question leaves time for others."""

import json
from pathlib import Path

import pytest

import glmref
from glmref.catalogue.reader import load_document
from glmref.prove.analysis import SHARES, _Questions, analyze
from glmref.prove.facts import facts_of
from glmref.system.budget import limited
from glmref.views.facts import analysis_rows
from tests.build import SOURCE, method_document


def turned(tmp_path: Path, *entries: str, **keys: object) -> Path:
    """A method with one stage whose V is diagonal."""
    r = len(entries)
    V = [[x if i == j else "0" for j in range(r)] for i, x in enumerate(entries)]
    doc = {
        "format": "glmref-method-1", "name": "turned", "class": "glm", "field": "complex",
        "A": [["1/2"]], "U": [["1"] * r], "B": [["1"]] + [[f"1/{i + 3}"] for i in range(r - 1)],
        "V": V, "claims": {"order": 1}, "source": SOURCE, **keys,
    }  # fmt: skip
    path = tmp_path / "turned.json"
    path.write_text(json.dumps(doc))
    return path


def test_roots_of_unity_of_orders_7_and_5_are_decided_together(tmp_path: Path) -> None:
    found = analyze(turned(tmp_path, "1", "exp(2*pi*i/7)", "exp(2*pi*i/5)"))
    assert set(found.undecided) == {"g-symplectic"}  # no form of a complex method is excluded
    assert (found.zero_stable, found.parasitism_free, found.order_proved) == (True, False, [1, 1])
    assert (found.g_symplectic["holds"], found.symmetric["holds"]) == (None, False)
    assert [g["eigenvalue"] for g in found.growth] == ["exp(2*pi*i/7)", "exp(2*pi*i/5)"]
    assert [g["mu"] for g in found.growth] == ["exp(12*pi*i/7)/3", "exp(8*pi*i/5)/4"]


@pytest.mark.sampled(2, besides=("24",))
@pytest.mark.parametrize(
    "entry", ["root(2,3)*exp(2*pi*i/7)", "exp(2*pi*i/24)*exp(-2*pi*i/15)", "sqrt(3)*exp(2*pi*i/9)"]
)
def test_products_of_roots_are_decided(entry: str, tmp_path: Path) -> None:
    doc = turned(tmp_path, "1", "-1", U=[["1", entry]], B=[["1"], [entry]])
    found = analyze(doc)
    assert set(found.undecided) == {"g-symplectic"}  # no form of a complex method is excluded
    assert found.order_proved == [1, 1]
    assert found.growth[0]["eigenvalue"] == "-1"


def test_an_analysis_names_what_its_budget_left_open() -> None:
    found = analyze(glmref.load("gauss-3"), budget=4e-9)
    assert found.undecided
    assert set(found.undecided.values()) <= {
        "the budget of 1e-09 s of processor time is spent",
        "the budget of 4e-09 s of processor time is spent",
    }
    assert found.order_proved == [0, None]
    assert "the budget of" in found.order_witness
    assert found.symmetric["holds"] is found.g_symplectic["holds"] is None
    rows = dict(analysis_rows(found.as_json()))
    assert rows["not decided: order"] == found.undecided["order"]
    assert (found.explicit, rows["explicit"]) == (None, "not decided")
    assert SHARES == 4


def test_an_analysis_says_why_a_property_is_open() -> None:
    """Balls do not decide A-stability, and say so by name."""
    found = analyze(glmref.load("tsitouras-5-4"))
    assert found.stability["A"] is None
    assert "published decimals" in found.undecided["a-stable"]
    assert "undecided" in found.as_json()
    assert "undecided" not in analyze(glmref.load("rk4")).as_json()


def test_whether_digits_make_a_method_implicit_is_not_decided(tmp_path: Path) -> None:
    """An entry within one unit of its last place of zero."""
    doc = {
        "format": "glmref-method-2", "name": "near", "class": "rk", "digits": 3, "A": [["0.001"]],
        "b": ["1"], "claims": {"order": 1}, "source": SOURCE,
    }  # fmt: skip
    path = tmp_path / "near.json"
    path.write_text(json.dumps(doc))
    found = analyze(path)
    assert found.explicit is None
    assert "other entries are exact zeros" in found.undecided["explicit"]


def test_nothing_is_asked_when_the_budget_is_spent() -> None:
    """Each of the questions left took a while more, of a method of 200 steps three seconds."""
    asked: list[str] = []
    facts = facts_of(glmref.load("rk4"))
    with limited(1e-9):
        questions = _Questions(facts, 1e-9)
        assert questions.ask("order", lambda _: asked.append("order"), "nothing") == "nothing"
    assert not asked
    assert questions.undecided == {"order": "the budget of 1e-09 s of processor time is spent"}


@pytest.mark.parametrize("name", ["rodas4", "ros34pw2"])
def test_a_rosenbrock_method_in_decimals_is_known_by_its_linear_form(name: str) -> None:
    """Its consistency follows from order 1; whether it is A-stable decimals do not say."""
    found = analyze(name)
    said = (found.explicit, found.preconsistent, found.consistent, found.zero_stable)
    assert said == (False, True, True, True)
    assert sorted(found.undecided or ()) == ["a-stable", "l-stable"]


def test_a_rosenbrock_method_in_decimals_may_be_inconsistent() -> None:
    keys = {"alpha": [["0"]], "gamma": [["0.500"]], "b": ["0.900"], "digits": 3}
    found = analyze(
        load_document(
            {**method_document("rosenbrock", {"w-order": 1}, **keys), "format": "glmref-method-2"}
        )
    )
    assert (found.consistent, found.preconsistent) == (False, True)
