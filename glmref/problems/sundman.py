"""Sundman's time transformation: small steps where they are wanted, at a constant step.

With dt = g(y) ds small steps in t are taken where g is small, at a constant step in s. For y' =
f(t, y) that is the system

    dy/ds = g(y) f(t, y),        dt/ds = g(y),

which is reversible where f and g are. It is not Hamiltonian where y' = f(y) is. But

    K(q, t, p, w) = g(q, p) (H(q, p) + w),        w = -H at the start

is a Hamiltonian in the extended phase space, with t as a coordinate and w as its momentum. On K = 0
its flow in s is that of H in t. A symplectic or G-symplectic method with a constant step in s then
keeps what it keeps. K is not separable, also where H is.

References
----------
Sundman, Acta Math. 36 (1912) 105-179.
Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006), section VIII.2.1 (Poincaré's
transformation; Darboux-Sundman as (2.1)). Leimkuhler and Reich, "Simulating Hamiltonian Dynamics"
(2004), section 9.2.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import UsageError
from ..system.arguments import shown
from .canonical import equations, shared
from .formula import Formula, substituted
from .from_expressions import scalar_in
from .loops import QuadraticForm
from .model import Problem

#: Bits of a denominator beyond which a float is written in decimals.
_WIDE = 200


def time_transformed(problem: Problem, rate: str) -> Problem:
    """Return the problem in the time s with dt = rate ds, Hamiltonian again where it was.

    Parameters
    ----------
    problem : Problem
        Its equations, or, where it is canonical, its Hamiltonian, given as expressions, and its
        initial value as expressions or numbers.
    rate : str
        Expression in the names of the components, or in ``y[0]``, .., and the problem's parameters;
        small where small steps are wanted, and positive all along.

    Returns
    -------
    Problem
        A canonical one in y = (q, t, p, w), another in (y, t). Its times are s, also ``h`` and
        ``t_end``. Functions of y that are no expressions are left out.

    Raises
    ------
    UsageError
        For a problem that is not given as expressions, or a rate that cannot be read.
    """
    if not isinstance(problem, Problem):
        raise UsageError(f"`problem` must be a glmref.Problem, got {shown(problem)}")
    canonical, given = problem.canonical, problem.hamiltonian if problem.canonical else problem.f
    if not isinstance(given, Formula) or callable(problem.initial):
        what = "its Hamiltonian, without t," if canonical else "its equations"
        raise UsageError(
            f"{problem.name} must have {what} in expressions without sums or loops, and its "
            "initial value in expressions or numbers"
        )
    d, begin = problem.dimension, problem.t_span[0]
    m = d // 2 if canonical else d  # where t stands

    def moved(formula: Formula) -> Formula:
        # what a name is replaced by is replaced, too: t is told from the components by its vector
        return formula.rewritten(
            lambda vector, i: f"y[{m}]" if vector == "t_" else f"y[{i + (i >= m)}]", {"t": "t_[0]"}
        )

    factor = moved(_rate(problem, rate)).outputs[0]
    names, whole = problem.labels, moved(given)
    known = problem.initial.tolist() if hasattr(problem.initial, "tolist") else problem.initial
    entries: dict[str, Any] = {
        "invariants": {k: moved(x) for k, x in _formulas(problem.invariants)},
        "observables": {k: moved(x) for k, x in _formulas(problem.observables)},
        "quadratic": {
            k: _spread(form, m, d + 1 + canonical) for k, form in problem.quadratic.items()
        },
    }
    if canonical:
        K = f"({factor})*({whole.outputs[0]} + y[{d + 1}])"
        start = substituted(
            given.outputs[0], lambda _, i: _text(known[i]), {k: f"({x})" for k, x in given.common}
        )
        entries |= equations(replace(whole, outputs=(K,), variables=("t", "y")), m + 1)
        entries["hamiltonian"] = replace(whole, outputs=(K,))
        entries["energy"] = moved(problem.conserved)
        known = [*known[:m], begin, *known[m:], f"-({start})"]
        names = (*names[:m], "t", *names[m:], "p_t")
    else:
        slopes = (*(f"({factor})*({x})" for x in whole.outputs), factor)
        entries["f"] = shared(replace(whole, outputs=slopes, shape=(d + 1,)))
        if isinstance(problem.hamiltonian, Formula):
            entries["hamiltonian"] = problem.hamiltonian
        known, names = [*known, begin], (*names, "t")
    return Problem(
        name=f"{problem.name}, transformed",
        source=f"{problem.source}; dt = ({rate}) ds",
        parameters=problem.parameters,
        y0=tuple(known),
        t_span=problem.t_span,
        canonical=canonical,
        names=names if problem.labels else (),
        scales={"time": float(problem.scales.get("time", 1.0))},
        **entries,
    )


def _rate(problem: Problem, rate: str) -> Formula:
    """Read the rate."""
    found = scalar_in("rate", rate, problem.labels, problem.dimension, problem.parameters)
    with np.errstate(all="ignore"), suppress(ArithmeticError):
        if 0 < found(np.asarray(problem.y0, dtype=float)) < np.inf:
            return found
    raise UsageError(f"`rate` must be positive and finite, and is not at y0: {shown(rate)}")


def _formulas(given: Mapping[str, Any]) -> list[tuple[str, Formula]]:
    """Return those functions that are expressions."""
    return [(k, x) for k, x in given.items() if isinstance(x, Formula)]


def _text(value: Any) -> str:
    """Return an initial value, a number at its exact value, as an expression."""
    if isinstance(value, str):
        return f"({value})"
    number = Fraction(value.item() if isinstance(value, np.generic) else value)
    wide = number.denominator.bit_length() > _WIDE
    return f"({float(number)!r})" if wide else f"({number.numerator}/{number.denominator})"


def _spread(form: QuadraticForm, m: int, d: int) -> QuadraticForm:
    """Return the same form in d components, of which the one numbered m is new."""
    terms = {(i + (i >= m), j + (j >= m)): value for (i, j), value in form.terms.items()}
    return QuadraticForm(terms, d)
