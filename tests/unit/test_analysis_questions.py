"""What ``analyze`` says where a question has no answer, and that one question leaves time for others."""

import json
from pathlib import Path

import pytest

import glmref
from glmref.prove.analysis import SHARES, analyze
from glmref.views.facts import analysis_rows

SOURCE = {"citation": "a test", "where": "here", "status": "derived"}


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
    assert found.undecided is None
    assert (found.zero_stable, found.parasitism_free, found.order_proved) == (True, False, [1, 1])
    assert (found.g_symplectic["holds"], found.symmetric["holds"]) == (False, False)
    assert [g["eigenvalue"] for g in found.growth] == ["exp(2*pi*i/7)", "exp(2*pi*i/5)"]
    assert [g["mu"] for g in found.growth] == ["exp(12*pi*i/7)/3", "exp(8*pi*i/5)/4"]


@pytest.mark.parametrize(
    "entry", ["root(2,3)*exp(2*pi*i/7)", "exp(2*pi*i/24)*exp(-2*pi*i/15)", "sqrt(3)*exp(2*pi*i/9)"]
)
def test_products_of_roots_are_decided(entry: str, tmp_path: Path) -> None:
    doc = turned(tmp_path, "1", "-1", U=[["1", entry]], B=[["1"], [entry]])
    found = analyze(doc)
    assert found.undecided is None
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
    assert SHARES == 4


def test_an_analysis_says_why_a_property_is_open() -> None:
    """Balls do not decide A-stability, and say so by name."""
    found = analyze(glmref.load("tsitouras-5-4"))
    assert found.stability["A"] is None
    assert found.undecided is not None
    assert "published decimals" in found.undecided["a-stable"]
    assert "undecided" in found.as_json()
    assert "undecided" not in analyze(glmref.load("rk4")).as_json()
