"""What ``analyze`` says is what was found, and cannot be changed."""

import json
import math
from dataclasses import FrozenInstanceError, is_dataclass
from typing import Any

import pytest

from glmref import analyze, load
from glmref.catalogue.lookup import document
from glmref.exact.expression import parse
from glmref.prove import digits, enclosure, starting
from glmref.prove.verifier import facts_for
from glmref.theory import starting_series


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("name", "exchanges"),
    [("stormer-verlet", [[1], [2, 1]]), ("gsymplectic-n-pair", [[2, 1], [2, 1]]),
     ("gsymplectic-n", [2, 1]), ("rk4", None)],
)  # fmt: skip
def test_exchanges_of_stages_are_told_by_their_numbers(name: str, exchanges: Any) -> None:
    assert analyze(load(name)).symmetric["P"] == exchanges


@pytest.mark.slow
def test_the_periodicity_interval_of_an_enclosed_method_is_found() -> None:
    """Decimals do not show that eigenvalues are mirrored; the form that is conserved does."""
    assert analyze(load("s3-w3")).stability["periodicity"] == pytest.approx(2.0252, abs=1e-3)


def test_what_was_proved_cannot_be_changed() -> None:
    found = analyze(load("rk4"))
    with pytest.raises(FrozenInstanceError):
        found.order = 5  # type: ignore[misc]
    made = [x for m in (digits, enclosure, starting_series, starting) for x in vars(m).values()
            if isinstance(x, type) and is_dataclass(x) and x.__module__ == m.__name__]  # fmt: skip
    assert len(made) > 6
    assert all(x.__dataclass_params__.frozen for x in made)  # type: ignore[attr-defined]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["gauss-2", "gsymplectic-n", "gsymplectic-n-pair", "g4123"])
def test_an_analysis_holds_what_was_found_and_is_strict_json(name: str) -> None:
    found, facts = analyze(load(name)), facts_for(load(name))
    plain = json.loads(json.dumps(found.as_json(), allow_nan=False))
    for key, x in found.stability.items():
        assert plain["stability"][key] == ("infinity" if x == math.inf else x)
    form, turned = facts.g_symplecticity, facts.symmetry

    def same(texts: Any, rows: Any) -> bool:
        if rows is None:
            return texts is None
        gaps = [parse(x) - y for row, given in zip(texts, rows, strict=True)
                for x, y in zip(row, given, strict=True)]  # fmt: skip
        return all(x.is_zero() for x in gaps)

    assert same(found.g_symplectic["G"], form.G)
    assert same(found.symmetric["L"], turned.L)
    if facts.is_single:
        assert same([found.g_symplectic["D"]], [form.D])
        assert "L_hat" not in found.symmetric
    else:
        assert same(found.symmetric["L_hat"], turned.involutions["k"])
        D = found.g_symplectic["D"]
        assert same([D["D_P"]], [form.D_P]) and same([D["D_Q"]], [form.D_Q])


#: Orders of an analysis, by the claim: what is not in a file has none.
ORDERS = {"order": "order", "order-identity": "order_identity", "stage-order": "stage_order",
          "embedded-order": "order_embedded", "dense-order": "order_dense",
          "w-order": "order_w"}  # fmt: skip


@pytest.mark.parametrize(
    "name", ["rk4", "bogacki-shampine-3-2", "dormand-prince-5-4", "rodas3", "ros3p", "g4123"]
)
def test_orders_are_those_that_the_file_claims(name: str) -> None:
    found, claims = analyze(load(name)), document(name)["claims"]
    plain = found.as_json()
    for claim, key in ORDERS.items():
        shown = getattr(found, key)
        if claim in claims:
            assert shown == plain[key] == claims[claim], claim
        elif claim in ("embedded-order", "dense-order", "w-order"):
            assert shown is None and key not in plain, claim
