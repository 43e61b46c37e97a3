"""The problem record: what a user gives, what is derived, what is refused."""

import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.problems import Problem, problem
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


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"y0": (1, 2)}, "`f` is missing"),
        ({"f": ("y[0]",), "y0": (1, 2)}, "`f` must have 2 entries, got 1"),
        ({"f": ("y[1]",), "y0": (1,)}, "`f` uses component 1, but there are 1"),
        ({"f": 3, "y0": (1,)}, "`f` must be a function or a tuple of expressions"),
        ({"f": ("y[0]",), "y0": ()}, "at least one component"),
        ({"f": ("y[0]",), "y0": 1}, "`y0` must be a vector"),
        ({"f": ("y[0]",), "y0": "1"}, "`y0` must be a vector"),
        ({"f": ("y[0]",), "y0": np.zeros((1, 1))}, "y0"),
        ({"f": ("y[0]",), "y0": (float("nan"),)}, "`y0[0]` must be a finite number"),
        ({"f": ("y[0]",), "y0": (None,)}, "`y0[0]` must be a finite number"),
        ({"force": ("q[0]",), "y0": (1, 2, 3)}, "even number of components"),
        ({"f": ("y[0]",), "y0": (1,), "quadratic": {"C": [[1, 2]]}}, "shape (1, 1)"),
        ({"f": ("a*y[0]",), "y0": (1,)}, "unknown name 'a'"),
        ({"f": ("y[0]",), "y0": (1,), "hamiltonian": 5}, "`hamiltonian` must be"),
        ({"f": ("y[0]",), "y0": (1,), "hamiltonian": "z"}, "unknown name 'z'"),
        ({"f": ("y[0]",), "y0": (1,), "invariants": {"I": "y[0"}}, "cannot be read"),
        ({"f": ("y[0]",), "y0": (1,), "observables": {"O": "y[1]"}}, "`O` uses component 1"),
        ({"f": ("y[0]",), "y0": (1,), "scales": {"time": "x"}}, "`scales['time']` must be a"),
        ({"f": ("y[0]",), "y0": (1,), "context": "x"}, "`context` is set by `Problem.on`"),
        ({"f": ("y[0]",), "y0": (1,), "t_span": (0, float("inf"))}, "two finite times"),
        ({"f": ("y[0]",), "y0": (1,), "parameters": {"a": "x"}}, "`a` must be a finite number"),
    ],
)
def test_what_does_not_fit_is_one_sentence(given, says):
    error = refused(UsageError, "", Problem, **given)
    assert says in error and "\n" not in error


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
