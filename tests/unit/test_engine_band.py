"""Newton's matrices of large systems: structure, order, elimination, separated stages."""

import time

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine import newton
from glmref.engine.band import band_of, stays_within
from glmref.engine.kernel import prepare
from glmref.engine.shape import banded, shape_of
from glmref.engine.solver_choice import choose_solver, newton_bytes, with_band
from glmref.engine.sweep import step_form
from glmref.errors import UsageError


def ring(sites, coupling="1"):
    """A ring of anharmonic oscillators as expressions."""
    force = tuple(
        f"{coupling}*(q[{(i + 1) % sites}] - 2*q[{i}] + q[{(i - 1) % sites}]) - q[{i}]**3"
        for i in range(sites)
    )
    return Problem(force=force, y0=tuple(0.1 * ((3 * i) % 7) for i in range(sites)) + (0,) * sites)


@pytest.mark.slow
@pytest.mark.sampled(1, besides=("radau",))
@pytest.mark.parametrize(
    ("made", "method", "width"),
    [
        (lambda: problem("nonseparable-chain", sites=40), "gauss-3", 2),  # a body of the Jacobian
        (lambda: problem("fput", sites=40), "s4-symmetric", 1),  # differences of a force
        (lambda: ring(40), "radau-iia-2", 2),  # expressions
    ],
)
def test_a_band_solves_the_same_stages(made, method, width):
    of = made()
    kernel = prepare(load(method), of, h=0.05, solver="newton")
    assert kernel.shape.band is not None and kernel.shape.band.lower == width
    ends = [solve(of, method, h=0.05, steps=20, solver=x) for x in ("newton", "fixed-point")]
    assert ends[0].factorisations
    assert np.abs(ends[0].y[-1] - ends[1].y[-1]).max() < 20 * 8 * 2.0**-52


@pytest.mark.slow
def test_machine_code_of_a_band_has_the_bits_of_the_interpreter():
    chain = problem("nonseparable-chain", sites=20)
    runs = [
        solve(chain, "gauss-2", h=0.05, steps=3, solver="newton", engine=engine)
        for engine in ("compiled", "interpreted")
    ]
    np.testing.assert_array_equal(runs[0].y, runs[1].y)


@pytest.mark.slow
def test_a_large_chain_is_solved_by_newton_in_little_memory():
    chain = problem("nonseparable-chain", sites=5_000)
    begin = time.process_time()
    run = solve(chain, "gauss-3", h=0.4, steps=2)
    assert run.completed and "newton" in run.kernel
    assert time.process_time() - begin < 5
    form, shape = step_form(load("gauss-3")), with_band(shape_of(chain))
    assert newton_bytes(form, shape) < 4e6


def test_where_there_is_no_band_the_cost_decides():
    def coupled(t, y):
        return -np.sum(y) * y

    large = Problem(f=coupled, y0=(1e-3,) * 20_000, name="large")
    with pytest.raises(UsageError, match=r"needs \d+(\.\d)? GiB for its matrices"):
        solve(large, "gauss-3", h=0.1, steps=1, solver="newton")
    heavy = problem("outer-solar-system")
    assert shape_of(heavy).band is None and banded(shape_of(heavy)).band is None
    # few rounds of the fixed point are cheaper than dense matrices of 1280, many are not
    chain = problem("nonseparable-chain", sites=640)
    form, shape = step_form(load("gauss-3")), shape_of(chain)
    assert choose_solver(form, shape, chain, 0.02) == "fixed-point"
    assert choose_solver(form, shape, chain, 0.4) == "newton"


# --- structure ----------------------------------------------------------------------------------


def test_a_jacobian_that_leaves_the_band_is_refused():
    chain = with_band(shape_of(problem("nonseparable-chain", sites=40)))
    assert chain.band is not None and chain.banded_body
    inside = "def J(t, y, params, out):\n    for i in range(len(y)):\n        out[i, i] += y[i]"
    beyond = inside.replace("[i, i]", "[i, 0]")
    branch = inside.replace("out[i", "if y[i] > 0:\n            out[i")
    assert stays_within(inside, "J", chain.band, [])
    assert not stays_within(beyond, "J", chain.band, [])
    assert stays_within(inside.replace("+=", "="), "J", chain.band, [])
    assert not stays_within(beyond.replace("+=", "="), "J", chain.band, [])
    assert not stays_within(branch, "J", chain.band, [])


# --- elimination --------------------------------------------------------------------------------


def helpers():
    names = {"compiled": lambda function: function}
    exec(newton.HELPERS + newton.COMPLEX_HELPERS, names)
    return names


@pytest.mark.parametrize("band", [None, (2, 1), (1, 3)])
def test_elimination_solves_with_pivots(band):
    n, rng, run = 9, np.random.default_rng(5), helpers()
    A = rng.standard_normal((n, n)) + 1j * rng.standard_normal((n, n))
    A[np.arange(n), np.arange(n)] *= 1e-3  # so that rows are exchanged
    lower, upper = band or (n - 1, n - 1)
    if band:
        A = np.triu(np.tril(A, upper), -lower)
    stride, offset = (2 * lower + upper, lower + upper) if band else (n, 0)
    before, after = (lower + upper, lower) if band else (0, 0)
    rest = n, lower, upper, stride, offset, int(band is not None)
    stored = np.zeros((n + lower + upper) * (stride + 1), dtype=complex)
    for i in range(n):
        for j in range(n):
            if not band or -upper <= i - j <= lower:
                stored[offset + j * stride + i] = A[i, j]
    known = rng.standard_normal(n) + 1j * rng.standard_normal(n)
    padded = np.concatenate([np.zeros(before), known, np.zeros(after)])
    for real in (True, False):
        pivots = np.zeros(n)
        a, b, c, d = stored.real.copy(), stored.imag.copy(), padded.real.copy(), padded.imag.copy()
        if real:
            run["factor"](a, pivots, *rest)
            run["eliminate"](a, pivots, c, *rest)
            found, expected = c, np.linalg.solve(A.real, known.real)
        else:
            run["complex_factor"](a, b, pivots, *rest)
            run["complex_eliminate"](a, b, pivots, c, d, *rest)
            found, expected = c + 1j * d, np.linalg.solve(A, known)
        assert (pivots != np.arange(n)).any()
        np.testing.assert_allclose(found[before : before + n], expected, rtol=1e-9)


# --- stages apart -------------------------------------------------------------------------------


def test_stages_that_cannot_be_separated_are_solved_together(monkeypatch):
    assert newton.split_of([[1.0, 1.0], [0.0, 1.0]]) is None
    apart = solve("arenstorf", "gauss-3", h=1e-3, steps=20, solver="newton")
    monkeypatch.setattr(newton, "_WORST_CONDITION", 0.0)
    monkeypatch.setattr("glmref.engine.kernel._prepared", prepare_anew())
    together = solve("arenstorf", "gauss-3", h=1e-3, steps=20, solver="newton")
    assert together.factorisations
    assert np.abs(apart.y - together.y).max() < 1e-13


def prepare_anew():
    from glmref.engine import kernel

    kernel._sources.known.clear()
    return kernel._prepared.__wrapped__


def test_a_band_holds_its_structure_and_is_no_wider():
    rng = np.random.default_rng(4)
    for n in (40, 60):
        shuffled = rng.permutation(n).tolist()
        chain = [frozenset(shuffled[j] for j in (k - 1, k, k + 1) if 0 <= j < n) for k in range(n)]
        structure = [chain[shuffled.index(i)] for i in range(n)]
        band = band_of(structure)
        assert (band.lower, band.upper, band.entries, band.width) == (1, 1, 3 * n - 2, 3)
        one_sided = [frozenset(x for x in row if shuffled.index(x) <= shuffled.index(i))
                     for i, row in enumerate(structure)]  # fmt: skip
        assert sorted((x := band_of(one_sided), (x.lower, x.upper))[1]) == [0, 1]
    for trial in range(40):
        n = int(rng.integers(30, 60))
        near = [[j for j in range(max(0, i - 3), min(n, i + 3)) if rng.random() < 0.4 or i == j]
                for i in range(n)]  # fmt: skip
        far = {(i, n - 1 - i) for i in range(3)} if trial % 5 == 0 else set()
        structure = [
            frozenset([*row, *(b for a, b in far if a == i)]) for i, row in enumerate(near)
        ]
        band = band_of(structure)
        if band is None:
            continue
        assert sorted(band.order) == list(range(n))
        place = {i: k for k, i in enumerate(band.order)}
        assert band.places.tolist() == [place[i] for i in range(n)]
        offsets = [place[i] - place[j] for i, row in enumerate(structure) for j in row]
        assert (band.lower, band.upper) == (max(0, *offsets), max(0, -min(offsets)))
        assert band.entries == sum(map(len, structure))
        assert 4 * (2 * band.lower + band.upper + 1) <= n


def test_a_matrix_that_is_as_good_dense_has_no_band():
    def chain(n, reach):
        return [frozenset(range(max(0, i - reach), min(n, i + reach + 1))) for i in range(n)]

    # 4 (2 lower + upper + 1) numbers against n: the room that pivoting needs, for its worth
    assert band_of(chain(16, 1)) is not None and band_of(chain(15, 1)) is None
    assert band_of(chain(28, 2)) is not None and band_of(chain(27, 2)) is None
    assert band_of([frozenset(range(9))] * 9) is None
    assert band_of([frozenset()] * 4).entries == 0
