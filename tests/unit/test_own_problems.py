"""A user's own problem: Hamilton's equations from H, expressions by name, files, sums."""

from fractions import Fraction

import numpy as np
import pytest

import glmref
from glmref import Problem, UsageError, solve
from glmref.errors import DataError, GlmrefError
from glmref.problems import problem
from glmref.problems.table import from_table
from glmref.scenes import load_scene, plan
from tests.build import refused, scene_text

DOUBLE = "(p1**2 + 2*p2**2 - 2*p1*p2*cos(q1 - q2))/(2 + 2*sin(q1 - q2)**2) - 2*cos(q1) - cos(q2)"


def random_states(d, count=5):
    return np.random.default_rng(4).uniform(-1, 1, (count, d))


def moved_by(H, y, step=1e-6):
    """The right-hand side of Hamilton's equations, from differences of H."""
    q, p = np.split(
        np.array([(H(y + e) - H(y - e)) / (2 * step) for e in step * np.eye(len(y))]), 2
    )
    return np.concatenate([p, -q])


def test_the_double_pendulum_from_h_alone_is_not_separable_and_has_the_right_field():
    own = Problem.from_hamiltonian(DOUBLE, {"q1": 1, "q2": "3/2", "p1": 0, "p2": 0})
    shipped = problem("double-pendulum")
    assert own.canonical and not own.separable
    for y in random_states(4):
        np.testing.assert_allclose(own.f(0, y), shipped.f(0, y), rtol=1e-13)
        np.testing.assert_allclose(own.jacobian(0, y), shipped.jacobian(0, y), rtol=1e-12)
        assert own.hamiltonian(y) == pytest.approx(shipped.hamiltonian(y), rel=1e-14)


@pytest.mark.parametrize(
    ("H", "kind"),
    [
        ("p**2/2 + q**4/4", "force"),
        ("p*p/2 + t0*q", "force"),
        ("p**2/(2*m) - cos(q)", "parts"),
        ("p**4/4 + q**2/2", "parts"),
        ("sqrt(1 + p**2) - 1/q", "parts"),
        ("(1 + q**2)*(1 + p**2)/2", "whole"),
        ("p**2/2 + p*q", "whole"),
    ],
)
def test_separability_is_seen(H, kind):
    own = Problem.from_hamiltonian(H, {"q": "1/2", "p": "1/4"}, parameters={"m": "3", "t0": 2})
    seen = "force" if own.second_order else "parts" if own.separable else "whole"
    assert seen == kind
    for y in random_states(2) * 0.4 + 0.6:
        np.testing.assert_allclose(own.f(0, y), moved_by(own.hamiltonian, y), atol=1e-8)


def test_names_are_the_user_s_and_may_be_listed():
    own = Problem.from_hamiltonian(
        "(px**2 + py**2)/2 - mu/sqrt(x**2 + y**2)",
        {"px": 0, "x": "2/5", "py": 2, "y": 0},
        coordinates=["x", "y"], momenta=["px", "py"], parameters={"mu": 1},
        invariants={"L": "x*py - y*px"}, t_end="2*pi",
    )  # fmt: skip
    np.testing.assert_array_equal(own.y0, [0.4, 0, 0, 2])
    assert own.second_order and own.t_span == (0.0, 2 * np.pi)
    ends = solve(own, "blanes-moan-rkn-6-14", h=np.pi / 500, steps=1000)
    np.testing.assert_allclose(ends.y[-1], own.y0, atol=1e-6)
    invariant = own.invariants["L"]
    assert invariant(ends.y[-1]) == pytest.approx(invariant(own.y0), abs=1e-14)


def chain(n, **options):
    q = [f"sin(pi*{i + 1}/{n + 1})" for i in range(n)]
    H = (
        "sum(p[i]**2/2 for i in range(n)) + sum((q[i+1] - q[i])**2/2"
        " + alpha*(q[i+1] - q[i])**3/3 for i in range(n - 1))"
        " + q[0]**2/2 + alpha*q[0]**3/3 + q[n-1]**2/2 - alpha*q[n-1]**3/3"
    )
    y0 = {"q": q, "p": [0] * n}
    return Problem.from_hamiltonian(H, y0, parameters={"alpha": "1/4"}, **options)


@pytest.mark.parametrize(
    ("H", "y0"),
    [
        # both halves have a root that occurs twice, and f is made of both
        ("sqrt(1 + px**2 + py**2) - 1/sqrt(qx**2 + qy**2)", {"qx": 1, "qy": 0, "px": 0, "py": 0.5}),
        # a constant under a sum is no part of a gradient
        (
            "sum(1 - cos(p[i]) for i in range(n)) + sum(1 - cos(q[i]) for i in range(n))",
            {"q": [1, 0.5], "p": [0, 0.3]},
        ),
    ],
)
def test_a_kinetic_energy_with_roots_or_constants_is_differentiated(H, y0):
    found = from_table({"H": H, "y0": y0})
    y = np.array(found.y0, dtype=float)
    assert found.f(0.0, y) == pytest.approx(moved_by(found.hamiltonian, y), abs=1e-9)
    assert found.dq is not None and found.force is None


def test_sums_are_loops_and_give_the_shipped_chain():
    own, shipped = chain(6), problem("fput", sites=6)
    assert own.second_order
    for y in random_states(12):
        np.testing.assert_allclose(own.f(0, y), shipped.f(0, y), rtol=1e-12, atol=1e-14)
        assert own.hamiltonian(y) == pytest.approx(shipped.hamiltonian(y), rel=1e-13)
    assert chain(6).dp.body.source == chain(60).dp.body.source


def test_double_sums_masses_and_wrapped_indices():
    n = 5
    masses = [Fraction(i + 1, 3) for i in range(n)]
    own = Problem.from_hamiltonian(
        "sum(p[i]**2/(2*m[i]) for i in range(n))"
        " - G*sum(m[i]*m[j]/sqrt((q[i] - q[j])**2 + 1) for i in range(n) for j in range(i))"
        " + sum((q[i] - q[(i-1) % n])**4 for i in range(n))/4",
        {"q": [0.1 * i * i for i in range(n)], "p": [0] * n},
        parameters={"m": masses, "G": "2"},
    )  # fmt: skip
    assert own.separable and not own.second_order

    def energy(y):
        q, p = y[:n], y[n:]
        pairs = ((i, j) for i in range(n) for j in range(i))
        return (
            sum(p[i] ** 2 / (2 * float(masses[i])) for i in range(n))
            - 2
            * sum(float(masses[i] * masses[j]) / np.sqrt((q[i] - q[j]) ** 2 + 1) for i, j in pairs)
            + sum((q[i] - q[i - 1]) ** 4 for i in range(n)) / 4
        )

    for y in random_states(2 * n, 2):
        assert own.hamiltonian(y) == pytest.approx(energy(y), rel=1e-13)
        np.testing.assert_allclose(own.f(0, y), moved_by(energy, y, 1e-5), atol=1e-7)
    options = {"h": 0.01, "steps": 20, "solver": "fixed-point"}
    ours = solve(own, "gauss-2", **options)
    np.testing.assert_array_equal(ours.y, solve(own, "gauss-2", engine="interpreted", **options).y)


MAKER = """
def make(k=1):
    return {"H": f"p**2/2 + {k}*q**2/2", "y0": {"q": 1, "p": 0}}

def ready():
    from glmref import Problem
    return Problem.from_hamiltonian("p**2/2 - cos(q)", {"q": 1, "p": 0})

def wrong():
    return 3

def fails():
    raise KeyError("no")

def leaves():
    raise SystemExit(0)

def field(t, y):
    return [y[1], -y[0]]
"""


def test_a_python_file_is_executed_by_name(tmp_path):
    (tmp_path / "mine.py").write_text(MAKER)
    own = from_table({"file": "mine.py:make", "parameters": {"k": 4}, "t_end": 3}, tmp_path)
    np.testing.assert_allclose(own.f(0, np.array([1.0, 0.0])), [0, -4])
    assert own.t_span == (0.0, 3.0)
    moved = from_table({"file": "mine.py:make", "t_end": 3, "rate": "1 + q**2"}, tmp_path)
    assert moved.labels == ("q", "t", "p", "p_t") and moved.t_span == (0.0, 3.0)
    assert moved.f(0, np.array([2.0, 0.0, 1.0, -0.5]))[:2].tolist() == [5, 5]
    named = from_table({"file": "mine.py:ready", "name": "mine", "t_end": "pi"}, tmp_path)
    assert named.name == "mine" and named.t_span[1] == np.pi
    for maker, message in (("wrong", "must return a Problem"), ("fails", "raised KeyError"),
                           ("leaves", "raised SystemExit: 0"), ("none", "no function 'none'"),
                           ("field", "field of mine.py must return a Problem .* argument: 't'")):  # fmt: skip
        refused(UsageError, message, from_table, {"file": f"mine.py:{maker}"}, tmp_path)


SCENE = scene_text(
    "mine", "PROBLEM", 'kind = "accurate"\nerror = "state"\nat = 1e-6', methods=["gauss-2", "gauss-4"],
    steps=[50, 100], t_end=5, ask=["state", "energy"],
)  # fmt: skip
PENDULUM = 'H = "p**2/2 - cos(q)"\ny0 = { q = 1, p = 0 }'


def test_a_scene_executes_a_file_beside_it_only(tmp_path):
    (tmp_path / "mine.py").write_text(MAKER)
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "good.toml").write_text(SCENE.replace("PROBLEM", 'file = "mine.py:make"'))
    assert load_scene(tmp_path / "good.toml").subject.second_order
    before = plan(load_scene(tmp_path / "good.toml")).tasks[0]
    (tmp_path / "mine.py").write_text(MAKER.replace("k=1", "k=2"))
    assert plan(load_scene(tmp_path / "good.toml")).tasks[0] != before
    for file in ("../mine.py:make", str(tmp_path / "mine.py:make")):
        (inner / "bad.toml").write_text(SCENE.replace("PROBLEM", f'file = "{file}"'))
        refused(DataError, "must lie in the folder of the file", load_scene, inner / "bad.toml")


@pytest.mark.parametrize(
    ("text", "line"),
    [('H = "p**2/2 - cosh(q)"\ny0 = { q = 1, p = 0 }', 11),
     ('H = "p**2/2"\ny0 = { q = 1 }', 12),
     ('H = "p**2/2"\ny0 = { q = 1, p = 0 }\nt_ends = 3', 13)],
)  # fmt: skip
def test_a_complaint_about_an_own_problem_names_its_line(tmp_path, text, line):
    path = tmp_path / "bad.toml"
    path.write_text(SCENE.replace("PROBLEM", text))
    refused(DataError, f"line {line}: ", load_scene, path)


def test_a_scene_ends_where_its_own_problem_does(tmp_path):
    path = tmp_path / "mine.toml"
    text = SCENE.replace("t_end = 5\n", "")
    path.write_text(text.replace("PROBLEM", PENDULUM + "\nt0 = 1\nt_end = 8.5"))
    assert load_scene(path).t_end == 7.5  # counted from the beginning
    path.write_text(text.replace("PROBLEM", PENDULUM))
    refused(DataError, "`t_end` must be a positive number", load_scene, path)


def test_a_hamiltonian_of_t_is_integrated_and_nothing_of_it_is_conserved():
    driven = Problem.from_hamiltonian(
        "p**2/2 - cos(q)*(1 + a*sin(t))", {"q": 1, "p": 0}, parameters={"a": "1/10"}, t_end=5
    )
    assert driven.canonical and not driven.separable and driven.hamiltonian is None
    by_hand = Problem(f=("y[1]", "-sin(y[0])*(1 + sin(t)/10)"), y0=(1, 0), t_span=(0, 5))
    for method in ("rk4", "gauss-3"):
        ours, theirs = (solve(one, method, h=0.05).y[-1] for one in (driven, by_hand))
        np.testing.assert_allclose(ours, theirs, rtol=1e-14)
    split = [solve(driven, "stormer-verlet", h=h).y[-1] for h in (0.05, 0.025)]
    exact = solve(driven, "gauss-3", h=0.05).y[-1]
    coarse, fine = (np.abs(y - exact).max() for y in split)
    assert coarse / fine == pytest.approx(4, rel=0.05)


@pytest.mark.parametrize("extra", ["3*p", "p*sin(1)", "p/3 - p/2"])
def test_a_velocity_that_is_p_and_a_constant_is_no_second_order_form(extra):
    """q'' = g(q) takes q' = p: the derivative of q' by p does not tell p + 3 from p."""
    own = Problem.from_hamiltonian(f"p**2/2 + {extra} + q**2/2", {"q": 1, "p": 0})
    assert own.separable and not own.second_order
    slope = own.f(0.0, own.y0)[0]
    assert slope != 0 and own.dq(own.y0[1:]) == pytest.approx([slope])
    exact = solve(own, "gauss-5", h=0.05, steps=40).y[-1]
    assert solve(own, "blanes-moan-6", h=0.05, steps=40).y[-1] == pytest.approx(exact, rel=1e-9)


SPRINGS = "sum(p[i]**2/2 for i in range(n)) + sum((q[i+1] - q[i])**2/2 for i in range(n - 1))"
PLANE = (
    "sum(px[i]**2/2 for i in range(n)) + sum(py[i]**2/2 for i in range(n))"
    " - sum(m[i]/sqrt((qx[i] - qx[j])**2 + (qy[i] - qy[j])**2 + 1/10)"
    " for i in range(n) for j in range(i))"
)
NAMED = "(px0**2 + py0**2 + px1**2 + py1**2)/2 - 3/sqrt((qx1 - qx0)**2 + (qy1 - qy0)**2 + 1/10)"


def test_arrays_lists_and_formulas_of_a_start_are_one():
    n = 7
    array = np.array([np.sin(i / n) for i in range(n)])
    whole = [
        Problem.from_hamiltonian(SPRINGS, {"q": array, "p": np.zeros(n)}),
        Problem.from_hamiltonian(SPRINGS, {"q": array.tolist(), "p": [0] * n}),
        Problem.from_hamiltonian(SPRINGS, {"q": "sin(i/n)", "p": 0}, n=n),
        from_table({"H": SPRINGS, "y0": {"q": "sin(i/n)", "p": "0"}, "n": n}),
    ]
    for one in whole:
        assert one.y0.tolist() == whole[1].y0.tolist()
        assert one.second_order


def test_a_formula_of_a_start_takes_parameters_and_remainders():
    own = Problem.from_hamiltonian(
        SPRINGS, {"q": "a*(i % 2)", "p": "(-1)**i"}, parameters={"a": "3"}, n=4
    )
    assert own.y0.tolist() == [0, 3, 0, 3, 1, -1, 1, -1]


def test_bodies_in_a_plane_move_as_their_components_do():
    """Lists are the same system as a name for each component, in another order."""
    start = {"qx": [1, "-1/2"], "qy": [0, 1], "px": [0, "1/4"], "py": ["1/2", 0]}
    plane = Problem.from_hamiltonian(PLANE, start, parameters={"m": [1, 3]})
    names = {f"{k}{i}": x for k, xs in start.items() for i, x in enumerate(xs)}
    order = ["qx0", "qy0", "qx1", "qy1"]
    named = Problem.from_hamiltonian(
        NAMED, names, coordinates=order, momenta=["p" + x[1:] for x in order]
    )
    assert plane.bodies == 2 and plane.second_order and named.second_order
    assert plane.y0.tolist() == named.y0.tolist()
    y = plane.y0 + 0.25 * np.arange(8)
    assert plane.f(0.0, y) == pytest.approx(named.f(0.0, y), rel=1e-15, abs=1e-15)
    assert plane.hamiltonian(y) == pytest.approx(named.hamiltonian(y), rel=1e-15)


def test_the_kinetic_energy_of_a_plane_may_be_one_sum():
    joined = PLANE.replace(
        "sum(px[i]**2/2 for i in range(n)) + sum(py[i]**2/2 for i in range(n))",
        "sum((px[i]**2 + py[i]**2)/2 for i in range(n))",
    )
    start = {"qx": [1, 2], "qy": [0, 0], "px": [0, 0], "py": [1, 0]}
    assert Problem.from_hamiltonian(joined, start, parameters={"m": [1, 3]}).second_order
    half = PLANE.replace(" + sum(py[i]**2/2 for i in range(n))", "")  # y does not move by p_y
    assert not Problem.from_hamiltonian(half, start, parameters={"m": [1, 3]}).second_order


LONG = "x" * 9_000


@pytest.mark.parametrize(
    "call",
    [
        lambda: Problem.from_hamiltonian(LONG, {"q": 1, "p": 0}),
        lambda: Problem.from_hamiltonian(f"p**2/2 + {LONG[:999]}", {"q": 1, "p": 0}),
        lambda: Problem.from_hamiltonian(SPRINGS, {"q": np.full(5_000, np.nan), "p": [0] * 5_000}),
        lambda: Problem.from_hamiltonian("p**2/2", {LONG: 1, "p": 0}),
        lambda: Problem.from_hamiltonian("p**2/2", [LONG, 0]),
        lambda: Problem.from_equations({"x": LONG}, {"x": 1}),
        lambda: Problem.from_equations({"x": "1"}, {"x": 1, LONG: 2}),
        lambda: from_table({"file": LONG}),
        lambda: from_table({LONG: 1}),
        lambda: glmref.problem(LONG),
        lambda: glmref.load(LONG),
        lambda: glmref.compare(LONG),
        lambda: glmref.compare("kepler", methods=[LONG]),
        lambda: glmref.solve("kepler", "rk4", h=LONG),
        lambda: glmref.solve("kepler", "rk4", h=0.1, engine=LONG),
        lambda: Problem(f=("y[0]",), y0=list(range(5_000)), terms=LONG),
    ],
)  # fmt: skip
def test_no_sentence_quotes_more_than_120_characters_of_a_value(call):
    said = refused(GlmrefError, "", call)
    text = said
    assert "x" * 121 not in text
    assert len(text) <= 600, text


def test_what_is_quoted_by_mistake_is_cut_where_it_leaves():
    quoted = UsageError(f"`a` must be short, got '{LONG}' and [{', '.join('1' * 999)}]; it isn't")
    assert len(str(quoted)) < 320
    assert str(quoted).endswith("; it isn't")
    plain = f"a user's word 'one' {'is long ' * 30}'two'"
    assert str(UsageError(plain)) == plain
