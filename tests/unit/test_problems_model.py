"""The problem record: what a user gives, what is derived, what is refused."""

import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.problems import Problem, names, problem
from tests.build import high, refused


def test_plain_functions_of_doubles_say_so_in_a_context():
    p = Problem(f=lambda t, y: np.sin(y), y0=(1,)).on(high())
    refused(UsageError, "double precision only", p.f, 0, p.y0)


def test_conserved_functions_come_in_every_form():
    p = Problem(
        f=("y[1]", "-y[0]"),
        y0=(3, 4),
        hamiltonian="(y[0]**2 + y[1]**2)/2",
        quadratic={"norm": np.eye(2)},
        invariants={"plain": lambda y: y[0] ** 2 + y[1] ** 2},
    )
    assert p.hamiltonian(p.y0) == 12.5
    assert p.quadratic["norm"](p.y0) == 25 == p.invariants["plain"](p.y0)
    assert np.asarray(p.quadratic["norm"]).tolist() == [[1, 0], [0, 1]]


def test_repr_is_one_line():
    assert repr(problem("kepler")) == "<Problem kepler, eccentricity=3/5, dimension 4>"


def test_values_are_frozen():
    p = problem("pendulum")
    with pytest.raises(AttributeError):
        p.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        p.y0[0] = 1
    with pytest.raises(TypeError):
        p.parameters["q0"] = 1


def test_a_matrix_is_no_state():
    refused(UsageError, "y0", Problem, f=("y[0]",), y0=np.zeros((1, 1)))


def test_quadratic_form_must_be_symmetric():
    with pytest.raises(UsageError, match="symmetric"):
        Problem(f=("y[0]", "y[1]"), y0=(1, 2), quadratic={"C": [[1, 2], [3, 4]]})


def test_no_closed_form_says_so():
    refused(UsageError, "no solution in closed form", problem("henon-heiles").solution, 1.0)


def test_loops_compile_in_one_piece_with_any_compiler():
    p = problem("toda", sites=4)
    compiled = []
    f_into = p.f.compiled(lambda body: compiled.append(body) or body)
    out = np.empty(8)
    f_into(0.0, p.y0, p.params, out)
    assert len(compiled) == 2 and (out == p.f(0.0, p.y0)).all()
    assert p.force.body is not None and p.expressions is None


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["outer-solar-system", "pleiades", "fput", "toda", "nonseparable-chain"]
)
def test_numba_compiles_the_loops_as_they_stand(name):
    numba = pytest.importorskip("numba")
    p = problem(name)
    out = np.empty(p.dimension)
    p.f.compiled(numba.njit)(0.0, np.array(p.y0), p.params, out)
    # the same operations in the same order, but for fused multiplication
    assert out == pytest.approx(p.f(0.0, p.y0), rel=1e-13, abs=1e-15)
    energy = p.hamiltonian.compiled(numba.njit)(np.array(p.y0), p.hamiltonian.params)
    assert energy == pytest.approx(p.hamiltonian(p.y0), rel=1e-13)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *((x, [1]) for x in ("parameters", "quadratic", "invariants", "observables", "scales")),
        ("terms", 3), ("terms", "y[0]"), ("t_span", None), ("t_span", 1.0), ("t_span", (0, 1, 2)),
        ("t_span", ("a", 1)), ("t_span", (0, 10**400)), ("bodies", "2"), ("bodies", None),
        ("name", None), ("source", 3), ("canonical", "yes"), ("scales", {"time": 0}),
    ],
)  # fmt: skip
def test_what_is_of_another_kind_is_refused_by_its_key(key: str, value: object) -> None:
    with pytest.raises(UsageError, match=f"`{key}` must "):
        Problem(**{"f": ("y[1]", "-y[0]"), "y0": (1.0, 0.0), key: value})


# --- names ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", names())
def test_every_problem_is_built_and_evaluates(name):
    p = problem(name)
    assert p.name == name and p.source
    if name != "fault-shape":  # which every call refuses, see test_problems_extreme
        with np.errstate(all="ignore"):
            slope = p.f(p.t_span[0], p.y0)
        assert slope.shape == p.y0.shape and np.isfinite(slope).all()
    assert p.t_span[0] < p.t_span[1] and all(x > 0 for x in p.scales.values())


@pytest.mark.parametrize("name", names())
def test_defaults_written_out_give_the_same_problem(name):
    same = problem(name, **problem(name).parameters)
    assert (same.y0 == problem(name).y0).all()
