"""The second witness of order 6: start, steps and finish of each file in extended precision.

The solution is measured as the file gives it: its own start, h-steps, its own finish. The parasitic
part is ``values - S(F(y_1))`` at the end of the run, with the start S and the finish F of the file:
what the values carried lack to the start of their own solution.
"""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from glmref.catalogue.lookup import document, load, names
from glmref.engine.reference import apply_finish, apply_start, stepper
from glmref.engine.starting_values import zero_start
from glmref.measure.convergence import ConvergenceRecord, observed_order
from glmref.problems import problem
from tests.shipped import shipped

CLOSE = 0.1
#: Errors at 192 steps of 1/6144 are about 4e-26, and their differences are wanted to four digits.
DIGITS = 36
#: Short, so that orders settle after few doublings: of 1/8 some methods take twice as many steps.
LENGTH = Fraction(1, 32)
PROBLEMS = {
    "pendulum": ("pendulum", {"q0": "3/2", "p0": "3/10"}),
    "kepler": ("kepler", {"eccentricity": "1/5"}),
}
METHODS = [
    name
    for name in names("methods")
    if shipped(name)["claims"].get("order") == 6
    and shipped(name)["class"] in ("glm", "sweep")
    and len(shipped(name)["V"]) > 1
    and shipped(name).get("field") != "complex"
]
QUICK = {("s5i1-w3", "kepler")}


def runs(name: str, case: str, *, zero: bool = False) -> tuple[Any, Any]:
    """n -> the finished solution, and n -> the parasitic part, after n steps to LENGTH.

    Args:
        zero: start from (y0, 0, .., 0), with the finish left out.
    """
    kind, parameters = PROBLEMS[case]
    method = load(name)
    start, finish = method.starting, method.finishing
    assert start is not None
    engine = stepper(method, problem(kind, **parameters), digits=DIGITS)
    number, y0 = engine.arithmetic.number, engine.problem.y0
    ends: dict[int, np.ndarray] = {}

    def end(n: int) -> tuple[np.ndarray, Any]:
        h = number(LENGTH.numerator) / LENGTH.denominator / n
        if n not in ends:
            values = zero_start(engine, y0) if zero else apply_start(start, engine, 0, y0, h)[0]
            for _ in range(n):
                step = engine.step(0, values, h)
                assert step.converged
                values = step.values
            ends[n] = values
        return ends[n], h

    def finished(values: np.ndarray, h: Any) -> np.ndarray:
        if finish is None or zero:
            return values[0]
        return apply_finish(finish, engine, 0, values[0], h)[0]

    def solution(n: int) -> list[Any]:
        return list(finished(*end(n)))

    def parasitic(n: int) -> list[Any]:
        values, h = end(n)
        ideal = apply_start(start, engine, 0, finished(values, h), h)[0]
        return list((values[1:] - ideal[1:]).ravel())

    return solution, parasitic


def measured(name: str, case: str, **options: Any) -> tuple[ConvergenceRecord, ConvergenceRecord]:
    solution, parasitic = runs(name, case, **options)
    zeros = [0] * len(parasitic(3))
    return observed_order(solution, first=3), observed_order(parasitic, first=3, target=zeros)


def test_every_real_general_linear_method_of_order_6_has_a_start() -> None:
    assert len(METHODS) >= 13
    assert all("starting" in document(name) for name in METHODS)


@pytest.mark.sampled(1, whole=8)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "case"),
    [
        pytest.param(n, c, id=f"{n}-{c}", marks=() if (n, c) in QUICK else pytest.mark.slow)
        for n in METHODS
        for c in PROBLEMS
    ],
)
def test_solution_and_parasitic_part_have_the_order_of_the_theory(name: str, case: str) -> None:
    """6 for the solution.

    The start misses the starting series by O(h^7), and so does each step; the parasitic
    components turn by their eigenvalues, so that such errors do not add up: order 7.
    """
    solution, parasitic = measured(name, case)
    assert abs(solution.order - 6) < CLOSE, solution
    assert abs(parasitic.order - 7) < CLOSE, parasitic


@pytest.mark.slow
def test_without_start_and_finish_a_conjugated_method_has_order_2() -> None:
    solution, _ = measured("s5i1-w3", "pendulum", zero=True)
    assert abs(solution.order - 2) < CLOSE, solution
