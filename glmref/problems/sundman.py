"""Sundman's time transformation that keeps the structure: a variable step that is no variable step.

With dt = g(y) ds small steps are taken where g is small, at a constant step in s. Applied to the
equations alone it would destroy the Hamiltonian form; applied to the Hamiltonian it does not:

    K(q, t, p, w) = g(q) (H(q, p) + w),        w = -H at the start

is a Hamiltonian in the extended phase space, with t as a coordinate and w as its momentum. On K = 0
its flow in s is that of H in t. A symplectic or G-symplectic method with a constant step in s then
keeps what it keeps.

References
----------
Sundman, Acta Math. 36 (1912) 105-179.
Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006), section VIII.2.1 (Poincaré's
transformation; Darboux-Sundman as (2.1)). Leimkuhler and Reich, "Simulating Hamiltonian Dynamics"
(2004), section 9.2.
"""

from __future__ import annotations

from typing import Any

from ..errors import UsageError
from .derivative import differentiated
from .formula import Formula, kept, substituted
from .loops import QuadraticForm
from .model import Problem


def time_transformed(problem: Problem, rate: str) -> Problem:
    """Return the problem in the time s with dt = rate ds, Hamiltonian again.

    Parameters
    ----------
    problem : Problem
        Canonical, with a Hamiltonian and initial values given as expressions or numbers.
    rate : str
        Positive expression in ``y[0]``, ... and the problem's parameters, small where small steps
        are wanted; for the symplectic form it may use positions and momenta alike.

    Returns
    -------
    Problem
        A problem in y = (q, t, p, w), two components more.

    Raises
    ------
    UsageError
        For a problem that is not canonical or not given as expressions.
    """
    energy = problem.hamiltonian
    if not problem.canonical or not isinstance(energy, Formula):
        raise UsageError(
            f"{problem.name} must be canonical with its Hamiltonian as an expression; give one"
        )
    if callable(problem.initial):
        raise UsageError(f"{problem.name} must give its initial value as numbers or expressions")
    m = problem.dimension // 2
    known = [f"({x})" if isinstance(x, str) else repr(x) for x in _listed(problem.initial)]
    wanted = Formula((rate,), variables=("y",), parameters=problem.parameters, shape=())
    text = substituted(energy.outputs[0], kept, {k: f"({x})" for k, x in energy.common})
    factor, moved = (
        substituted(x, lambda _, i: f"y[{i + (i >= m)}]") for x in (wanted.outputs[0], text)
    )
    K = f"({factor})*({moved} + y[{2 * m + 1}])"
    whole = Formula((K,), variables=("y",), parameters=problem.parameters, shape=())
    slopes = differentiated(whole, 2 * m + 2)
    half = m + 1
    f = Formula(
        outputs=(*slopes.outputs[half:], *(f"-({x})" for x in slopes.outputs[:half])),
        common=slopes.common,
        parameters=problem.parameters,
    )
    start = substituted(text, lambda _, i: known[i])
    return Problem(
        name=f"{problem.name}, transformed",
        source=f"{problem.source}; dt = ({rate}) ds",
        parameters=problem.parameters,
        f=f,
        y0=(*known[:m], 0, *known[m:], f"-({start})"),
        t_span=problem.t_span,
        hamiltonian=K,
        quadratic={name: _spread(form, m) for name, form in problem.quadratic.items()},
        canonical=True,
        scales={"time": float(problem.scales.get("time", 1.0))},
    )


def _listed(initial: Any) -> list[Any]:
    return initial.tolist() if hasattr(initial, "tolist") else list(initial)


def _spread(form: QuadraticForm, m: int) -> QuadraticForm:
    """The same form in the extended phase space."""

    def place(i: int) -> int:
        return i if i < m else i + 1

    terms = {(place(i), place(j)): value for (i, j), value in form.terms.items()}
    return QuadraticForm(terms, 2 * m + 2)
