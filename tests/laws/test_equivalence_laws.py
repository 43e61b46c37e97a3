"""Laws of equivalence: what is carried, and in which order, changes no verdict and no solution.

A method that carries ``T y`` instead of y, numbers its stages anew, or has a stage or a value that
nothing uses is the same method. So ``analyze`` must say the same of it, and ``solve`` must return
the same solution to round-off, whatever the start.
"""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

import glmref
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.solve import solve
from glmref.errors import DataError
from glmref.exact import exact, linalg
from glmref.exact.expression import parse
from glmref.method import GLM, PartitionedGLM, StartingMethod
from glmref.method.preconsistency import (
    abscissae,
    consistency_vector,
    output,
    outputs,
    preconsistency_vector,
)
from glmref.prove.analysis import analyze
from glmref.prove.facts import facts_of
from tests.build import invertible, refused
from tests.examples import law

LAWS = settings(max_examples=3, deadline=None, suppress_health_check=[HealthCheck.too_slow])
#: One value and several; explicit, diagonally and fully implicit; multistep; u = (1, 1); with start
#: and finish; symmetric; published decimals.
METHODS = [
    "rk4", "gauss-2", "radau-iia-3", "gsymplectic-n", "g4123", "thesis-3-8", "leapfrog", "ab-3",
    "bdf-2", "dimsim-2-type-1", "dimsim-2-type-3", "s4-symmetric", "nystrom-3",
]  # fmt: skip
CARRIED = [name for name in METHODS if name not in ("rk4", "gauss-2", "radau-iia-3")]
PAIRS = ["stormer-verlet", "ruth-3", "gsymplectic-n-pair", "pair-4-4", "lobatto-iiia-iiib-2"]
#: Published decimals are enclosed: sums of them leave open what stood in one entry before.
EXACT_PAIRS = [name for name in PAIRS if name != "pair-4-4"]
#: Everything an analysis says that is a verdict or belongs to the method and not to its values.
SAME = (
    "explicit", "preconsistent", "consistent", "zero_stable", "order", "principal",
    "order_identity", "stage_order", "parasitism_free", "proof",
)  # fmt: skip


def symmetric_reduced(m: GLM) -> bool | None:
    """Whether the method without its idle values equals its adjoint."""
    return facts_of(m).truth("symmetric-reduced")


def condition(T: Any) -> float:
    """Condition number of a matrix in the maximum norm."""
    norms = [max(sum(x.magnitude() for x in row) for row in X) for X in (T, linalg.inverse(T))]
    return norms[0] * norms[1]


def same_verdicts(a: Any, b: Any, *, stages: bool = True, symmetric: bool = True) -> None:
    """Both analyses say the same: verdicts, orders, abscissae, error constants, growth.

    ``symmetric`` is a verdict on the tableau as it stands, where an idle stage has no mirror image
    and an idle value is lost: ``symmetric-reduced`` is the one on what is left without them.
    """
    for key in SAME:
        if stages or key != "stage_order":
            assert getattr(a, key) == getattr(b, key), key
    assert a.g_symplectic["holds"] == b.g_symplectic["holds"]
    if symmetric:
        assert a.symmetric["holds"] == b.symmetric["holds"]
    assert grows(a) == grows(b)
    assert a.error_constants.keys() == b.error_constants.keys()
    for t, x in a.error_constants.items():
        assert b.error_constants[t] == pytest.approx(x, rel=1e-12, abs=1e-15), t
    if stages:
        assert a.abscissae is None or sorted(a.abscissae) == sorted(b.abscissae)


def grows(a: Any) -> list[Any]:
    """Eigenvalues with their growth parameters: for pairs mu_q mu_p.

    Each of the two alone is measured in a basis of parasitic values of q or of p.
    """
    if not isinstance(a.values, list):
        return a.growth
    found = []
    for g in a.growth:
        q, p = ([[parse(x) for x in row] for row in g[key]] for key in ("mu_q", "mu_p"))
        found.append((g["eigenvalue"], linalg.matmul(q, p)))
    return found


def end(method: Any, start: Any = None, **options: Any) -> np.ndarray:
    found = solve("pendulum", method, h=0.1, steps=12, every=4, start=start, **options)
    assert found.completed, found.message
    return found.y


def same_solutions(
    a: Any, b: Any, *, starts: Any = (None, "zero", ("enhanced", 2)), condition: float = 1.0
) -> None:
    """Every engine returns the same y for both, whatever the start.

    Round-off in the values ``T y`` has the size of T, and reading the solution off them multiplies
    it by ``T^-1``: ``condition`` is the product of their norms. A sweep moves its coefficients by
    up to 500 units in the last place.
    """
    allowed = 5e-13 + 5e-14 * condition
    for start in starts:
        for engine in ("reference", "interpreted"):
            first, second = end(a, start, engine=engine), end(b, start, engine=engine)
            np.testing.assert_allclose(second, first, rtol=0, atol=allowed)


# --- a change of values ---------------------------------------------------------------------------


@law(CARRIED, LAWS, 0, besides=("s4-symmetric", "g6245", "gsymplectic"))
def test_analyze_says_the_same_of_other_values(name, data):
    m = glmref.load(name)
    other = m.transform(data.draw(invertible(m.r))).permute_stages(
        data.draw(st.permutations(range(m.s)))
    )
    same_verdicts(analyze(m), analyze(other))


@law(CARRIED, LAWS, 1)
def test_solve_returns_the_same_of_other_values(name, data):
    m = glmref.load(name)
    T = data.draw(invertible(m.r))
    other = m.transform(T).permute_stages(data.draw(st.permutations(range(m.s))))
    same_solutions(m, other, condition=condition(T))


@law(EXACT_PAIRS, LAWS, 0)
def test_analyze_says_the_same_of_a_pair_in_other_values(name, data):
    m, other, _ = moved_pair(name, data)
    same_verdicts(analyze(m), analyze(other))


@law(PAIRS, LAWS, 1)
def test_solve_returns_the_same_of_a_pair_in_other_values(name, data):
    m, other, size = moved_pair(name, data)
    same_solutions(m, other, condition=size)


def moved_pair(name: str, data: Any) -> tuple[PartitionedGLM, PartitionedGLM, float]:
    """A pair, the same in other values and another order of stages, and how ill conditioned."""
    m = glmref.load(name)
    T, T_hat = data.draw(invertible(m.r)), data.draw(invertible(m.r_hat))
    other = m.transform(T, T_hat)
    Q = data.draw(st.permutations(range(m.n_Q)))
    P = data.draw(st.permutations(range(m.n_P))) if m.separable else Q
    return m, other.permute_stages(Q, P), max(condition(T), condition(T_hat))


@law(CARRIED, LAWS, 3)
def test_the_vectors_move_with_the_values(name, data):
    m = glmref.load(name)
    T = data.draw(invertible(m.r))
    other = m.transform(T)
    assert preconsistency_vector(other) == linalg.matvec(T, preconsistency_vector(m))
    assert consistency_vector(other) == linalg.matvec(T, consistency_vector(m))
    assert output(other) == linalg.vecmat(output(m), linalg.inverse(T))
    assert abscissae(other) == abscissae(m)
    assert linalg.dot(output(other), preconsistency_vector(other)) == 1


def test_a_form_with_a_zero_on_its_diagonal_has_a_sweep():
    # diag(1, -1) in these values is ((1, -1), (-1, 0)): one rounded coefficient is moved by another
    m = glmref.load("g4123")
    other = m.transform([["1", "1"], ["0", "1"]])
    assert other.G is not None and other.G[1][1] == 0
    np.testing.assert_allclose(end(other), end(m), rtol=0, atol=5e-13)


@pytest.mark.parametrize("start", [None, "zero", ("enhanced", 3)])
def test_exchanged_values_do_not_make_h_f_the_solution(start):
    m = glmref.load("gsymplectic-n")
    other = m.transform([["0", "1"], ["1", "0"]])
    np.testing.assert_allclose(
        end(other, start, engine="reference"), end(m, start, engine="reference"), atol=1e-15
    )
    # a file need not say it: the first value that carries the solution is found from u = (0, 1)
    silent = GLM(other.A, other.U, other.B, other.V, starting=other.starting, claims=m.claims)
    assert silent.output is None
    assert [complex(x) for x in output(silent)] == [0, 1]
    np.testing.assert_allclose(end(silent, start), end(other, start), atol=1e-15)


@pytest.mark.slow
def test_ensembles_read_the_solution_like_single_runs():
    m = glmref.load("gsymplectic-n").transform([["1", "1"], ["1/2", "-1"]])
    initial = np.array([[0.5, 0.1], [1.0, -0.2], [0.2, 0.3]])
    for width in (1, 8):
        found = solve_ensemble(
            "pendulum", m, initial, h=0.1, steps=12, start="enhanced", width=width
        )
        for y0, y in zip(initial, found.y[-1], strict=True):
            subject = glmref.problem("pendulum", q0=str(Fraction(y0[0])), p0=str(Fraction(y0[1])))
            alone = solve(subject, m, h=0.1, steps=12, start="enhanced")
            np.testing.assert_allclose(y, alone.y[-1], rtol=0, atol=1e-13)


# --- stages and values that nothing uses ----------------------------------------------------------


def with_idle_stage(m: GLM) -> GLM:
    """One stage more, last, that reads the values like the first and is read by nothing."""
    A = (*((*row, 0) for row in m.A), (0,) * (m.s + 1))
    return GLM(
        A, (*m.U, m.U[0]), tuple((*row, 0) for row in m.B), m.V, starting=m.starting,
        finishing=m.finishing, claims=m.claims, output=output(m),
    )  # fmt: skip


def with_idle_value(m: GLM, *, copy: bool) -> GLM:
    """One value more, last: a copy of the first, or a sum of slopes; no stage reads it."""
    B = (*m.B, m.B[0] if copy else (1,) * m.s)
    V = (*((*row, 0) for row in m.V), (*(m.V[0] if copy else (0,) * m.r), 0))
    U = tuple((*row, 0) for row in m.U)
    start = m.starting
    if start is not None:
        last = start.B[0] if copy else (exact(0),) * start.stages
        start = StartingMethod(
            start.A, (*start.B, last), (*start.u, start.u[0] if copy else exact(0))
        )
    return GLM(
        m.A, U, B, V, starting=start, finishing=m.finishing, claims=m.claims,
        output=(*output(m), 0),
    )  # fmt: skip


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", METHODS)
def test_an_idle_stage_changes_nothing(name):
    m = glmref.load(name)
    other = with_idle_stage(m)
    same_solutions(m, other)
    bare = GLM(m.A, m.U, m.B, m.V)
    same_verdicts(analyze(bare), analyze(other), stages=False, symmetric=False)


@pytest.mark.sampled(1, besides=("s4-symmetric",), whole=15)
@pytest.mark.parametrize("copy", [True, False])
@pytest.mark.parametrize("name", METHODS)
def test_an_idle_value_changes_nothing(name, copy):
    m = glmref.load(name)
    other = with_idle_value(m, copy=copy)
    same_solutions(m, other)
    bare = GLM(m.A, m.U, m.B, m.V)
    same_verdicts(analyze(bare), analyze(other), symmetric=False)
    assert symmetric_reduced(other) == symmetric_reduced(bare)


# --- what a declared output may be ----------------------------------------------------------------


def test_an_output_that_is_not_the_solution_is_refused():
    m = glmref.load("gsymplectic-n")
    wrong = GLM(m.A, m.U, m.B, m.V, output=["0", "1"])  # reads the value that carries no y
    for use in (analyze, lambda x: end(x, "zero"), lambda x: end(x, "zero", engine="reference")):
        refused(DataError, "`output` must read the solution", use, wrong)
    refused(DataError, "`output` must have 2 entries", GLM, m.A, m.U, m.B, m.V, output=["1"])


def test_a_multiple_of_the_solution_is_divided():
    m = glmref.load("gauss-2")
    other = GLM(m.A, linalg.scale(exact(Fraction(1, 2)), m.U), linalg.scale(exact(2), m.B), m.V)
    assert outputs(other.components) == ((exact(Fraction(1, 2)),),)
    same_solutions(m, other, starts=(None, "zero"))
    same_verdicts(analyze(GLM(m.A, m.U, m.B, m.V)), analyze(other))


def test_among_several_u_the_consistent_one_is_taken():
    # two copies side by side: y_2 is carried on its own and read by no stage
    m = glmref.load("rk4")
    twice = GLM(
        m.A, tuple((*row, 0) for row in m.U), (m.B[0], m.B[0]), linalg.identity(2), output=[0, 1]
    )
    assert preconsistency_vector(twice) == (1, 1)
    assert analyze(twice).order == analyze(m).order == 4
    assert [len(x.components) for x in (m, glmref.load("ruth-3"))] == [1, 2]
