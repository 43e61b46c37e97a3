"""The shipped files hold the tableaux of Khan (2018) that the literature tests type in."""

from collections.abc import Callable

import pytest

from glmref import load
from glmref.exact import exact
from glmref.method import GLM, StartingMethod

from .exactly import order, same
from .thesis import (
    A6_PRINTED,
    B6,
    START_CORRECTED,
    START_PRINTED,
    euler,
    gauss2,
    method_n,
    one_value,
    order4,
    order6,
    real_form,
    rk4,
    s4,
    starter_n,
)

FILES: dict[str, Callable[[], GLM]] = {
    "euler": euler,
    "rk4": rk4,
    "gauss-2": gauss2,
    "thesis-gauss-2-printed": lambda: gauss2("1/4+sqrt(3)/6"),
    "gsymplectic-n": method_n,
    "gsymplectic-p": lambda: method_n(1, -1, 1),
    "thesis-3-8": order4,
    "thesis-3-8-printed": lambda: order4("-11/72"),
    "s4-symmetric": s4,
    "g6245-w3": lambda: real_form(order6()),
    "g6245-w3-complex": order6,
    "thesis-order6-printed-a": lambda: one_value(A6_PRINTED, B6),
}


@pytest.mark.parametrize("name", FILES)
def test_file_holds_the_tableau_of_the_thesis(name: str) -> None:
    file, typed = load(name), FILES[name]()
    assert isinstance(file, GLM)
    assert all(same(getattr(file, letter), getattr(typed, letter)) for letter in "AUBV")
    if typed.G is not None and file.G is not None:
        assert same(file.G, typed.G)
        assert file.D is not None and typed.D is not None
        assert same((file.D,), (typed.D,))


@pytest.mark.parametrize(
    ("name", "stages"),
    [("thesis-start-3-6-printed", START_PRINTED), ("gsymplectic-n-start-3-6", START_CORRECTED)],
)
def test_file_holds_the_starting_method_3_6(name: str, stages: list[list[str]]) -> None:
    file, typed = load(name).starting, starter_n(stages)
    assert isinstance(file, StartingMethod)
    assert same(file.A, typed.A)
    assert same(file.B, typed.B)


def test_g4123_has_three_stages_order_4_and_no_growth() -> None:
    # The counterexample of the literature to "free of parasitism only with many stages".
    method = load("g4123")
    assert (method.s, method.r) == (3, 2)
    assert order(method) == 4
    assert order(method, "identity") == 2
    growth = [row[1] for row in method.U]
    assert sum((b * u for b, u in zip(method.B[1], growth, strict=True)), exact(0)).is_zero()
