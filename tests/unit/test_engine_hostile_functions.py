"""Right-hand sides that compute in place, share buffers, lose digits, vary, raise or are no state."""

import itertools
import math
import sys

import numpy as np
import pytest

from glmref import Interrupted, Problem, UsageError, solve
from glmref.engine.outcome import Outcome
from glmref.problems.user_functions import FunctionFailed
from tests.build import in_place, refused, sharing

QUICK = ("reference", "interpreted")
ENGINES = [*QUICK, pytest.param("compiled", marks=pytest.mark.slow)]  # numba takes a second each
WHOLE = ["rk4", "gauss-2", "gauss-3", "tr-bdf2", "s4-symmetric"]
PAIRS = ["stormer-verlet", "pair-rkn-6-8b"]


def good(t, y):
    return np.array([y[1], -y[0]])


def spoils(t, y):
    out = np.array([y[1], -y[0]])
    y[0] = 1e30
    y[1] = -1e30
    return out


def listed(t, y):
    return [y[1], -y[0]]


def matrix(t, y):
    return np.array([[0.0, 1.0], [-1.0, 0.0]]) @ y


BENIGN = {
    "in place": in_place, "spoils": spoils, "one buffer": sharing(np.zeros(2)), "list": listed,
    "matrix": matrix,
}  # fmt: skip


def oscillator(f):
    return Problem(f=f, y0=(1.0, 0.0), name="given")


def dp_in_place(q):
    q *= -1
    return q


def dq_spoils(p):
    out = p.copy()
    p[:] = 1e30
    return out


@pytest.mark.sampled(2, besides=("s4-", "gauss-3", "tr-bdf2"))
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", WHOLE)
def test_a_function_that_means_well_is_stepped_right(method, engine):
    options = {"h": 0.1, "steps": 100, "engine": engine}
    expected = solve(oscillator(("y[1]", "-y[0]")), method, **options)
    chosen = list(BENIGN) if engine != "compiled" else ["in place", "spoils"]
    again = solve(oscillator(good), method, **options)
    for name in chosen:
        f = BENIGN[name]
        run = solve(oscillator(f), method, **options)
        assert run.completed, (name, run.message)
        # gauss and the diagonally implicit methods may solve their stages in another way
        assert np.abs(run.y - expected.y).max() < 2e-14, name
        # some functions are recorded as formulas, whose kernels may add in another order
        np.testing.assert_allclose(run.y, again.y, rtol=0, atol=1e-15, err_msg=name)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", [*PAIRS, "gauss-2"])
def test_parts_that_compute_in_place_are_stepped_right(method, engine):
    options = {"h": 0.1, "steps": 100, "engine": engine}
    expected = solve(Problem(force=("-q[0]",), y0=(1, 0)), method, **options)
    for given in ({"dq": dq_spoils, "dp": dp_in_place}, {"force": dp_in_place}):
        run = solve(Problem(**given, y0=(1.0, 0.0)), method, **options)
        assert run.completed, run.message
        assert np.abs(run.y - expected.y).max() < 2e-14


def test_given_functions_keep_the_caller_s_arrays():
    problem = Problem(
        f=in_place, y0=(1.0, 0.0), jacobian=lambda t, y: np.full((2, 2), y.fill(0)),
        hamiltonian=lambda y: float(y.sort() or y[0]), invariants={"I": lambda y: y.fill(3) or 1.0},
        exact=lambda t, y0: y0.fill(7) or y0,
    )  # fmt: skip
    y = np.array([2.0, 1.0])
    results = [
        problem.f(0.0, y), problem.hamiltonian(y), problem.invariants["I"](y), problem.exact(0, y)
    ]  # fmt: skip
    assert y.tolist() == [2.0, 1.0]
    assert not any(np.shares_memory(y, x) for x in results)
    shared = oscillator(sharing(np.zeros(2)))
    first, second = shared.f(0.0, y), shared.f(0.0, 3 * y)
    assert first.tolist() == [1.0, -2.0] and second.tolist() == [3.0, -6.0]
    columns = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    norms = Problem(f=lambda t, y: -y * np.linalg.norm(y), y0=(1.0, 0.0))
    for k, column in enumerate(columns.T):
        np.testing.assert_array_equal(norms.f(0.0, columns)[:, k], norms.f(0.0, column))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", ["rk4", "gauss-2"])
@pytest.mark.parametrize("kind", [np.float32, np.float16, np.int64])
def test_lost_digits_are_noticed(kind, method, engine):
    def f(t, y):
        return np.array([y[1], -y[0]]).astype(kind)

    run = solve(oscillator(f), method, h=0.1, steps=10, engine=engine)
    (notice,) = [x for x in run.notices if "compile" not in x]
    assert notice.startswith("`f` returns") and kind.__name__ in notice


def test_32_bit_entries_of_a_list_are_noticed():
    run = solve(
        oscillator(lambda t, y: [np.float32(y[1]), -y[0]]), "rk4", h=0.1, steps=3,
        engine="interpreted",
    )  # fmt: skip
    assert any("float32" in x for x in run.notices)


class NoArray:
    """What numpy asks for an array, and does not get one."""

    def __array__(self, dtype=None, copy=None):
        raise RuntimeError("no array")


class NoNumber:
    def __init__(self, x):
        self.x = x

    def __float__(self):
        raise OSError("no number")


def ends_a_generator(t, y):
    raise GeneratorExit


def complex_(t, y):
    return [1j * y[1], -y[0]]


NOT_A_STATE = {
    "None": (lambda t, y: None, "got None"),
    "scalar": (lambda t, y: y[0], r"must return shape \(2,\), got \(\)"),
    "generator": (lambda t, y: (x for x in y), "an iterator"),
    "string": (lambda t, y: "ab", "a str"),
    "words": (lambda t, y: ["a", "b"], "must return numbers"),
    "short": (lambda t, y: y[:1], r"got \(1,\)"),
    "column": (lambda t, y: y[:, None], r"got \(2, 1\)"),
    "ragged": (lambda t, y: [[1.0], [1.0, 2.0]], "rows of different lengths"),
    "objects": (lambda t, y: [None, 1.0], "an entry None"),
    "complex": (complex_, "got complex ones"),
    "masked": (lambda t, y: np.ma.array(y, mask=[False, True]), "got masked entries"),
    "set": (lambda t, y: {1.0, 2.0}, "a set"),
    "map": (lambda t, y: map(float, y), "an iterator"),
    "no array": (lambda t, y: NoArray(), "`f` raised RuntimeError: no array"),
    "no number": (lambda t, y: [NoNumber(1), NoNumber(2)], "`f` raised OSError: no number"),
    "generator exit": (ends_a_generator, "`f` raised GeneratorExit at t = 0"),
    "key": (lambda t, y: {}["rate"], "`f` raised KeyError: 'rate' at t = 0"),
    "name": (lambda t, y: rate * y, "`f` raised NameError: name 'rate' is not"),  # noqa: F821
    "exit": (lambda t, y: sys.exit(0), "`f` raised SystemExit: 0 at t = 0"),
    "recursion": (lambda t, y: recursive(t, y), "`f` raised RecursionError"),
}  # fmt: skip


def recursive(t, y):
    return recursive(t, y)


@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
@pytest.mark.parametrize("case", NOT_A_STATE)
def test_what_is_no_state_is_refused_in_one_sentence_at_the_start(case, engine):
    f, says = NOT_A_STATE[case]
    for method in ("rk4", "gauss-2"):
        refused(UsageError, says, solve, oscillator(f), method, h=0.1, steps=10, engine=engine)


@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
@pytest.mark.parametrize("part", ["dq", "dp"])
def test_parts_that_are_no_state_are_refused_by_name(part, engine):
    parts = {"dq": lambda p: p, "dp": lambda q: -q}
    parts[part] = lambda x: None
    for method in ("stormer-verlet", "gauss-2"):
        with pytest.raises(UsageError, match=f"`{part}` must return shape"):
            solve(Problem(**parts, y0=(1.0, 0.0)), method, h=0.1, steps=3, engine=engine)


def test_a_coroutine_is_said_to_be_one():
    async def waits(t, y):
        return y

    coroutine = waits(0.0, (1.0, 0.0))
    with pytest.raises(UsageError, match="got a coroutine"):
        solve(oscillator(lambda t, y: coroutine), "rk4", h=0.1, steps=1, engine="interpreted")
    coroutine.close()


@pytest.mark.parametrize("method", ["ars-1-2-2", "rk4"])
def test_terms_are_looked_at_like_f(method):
    def summed(term, **more):
        problem = Problem(terms=(lambda t, y: 0 * y, term), y0=(1.0, 0.0), **more)
        return solve(problem, method, h=0.1, steps=4, engine="reference")

    random = np.random.default_rng(1)
    with pytest.raises(UsageError, match=r"`terms\[2\]` gives two different values"):
        summed(lambda t, y: y * random.random())
    with pytest.raises(UsageError, match=r"`terms\[2\]` must return shape \(2,\), got None"):
        summed(lambda t, y: None)
    single = summed(lambda t, y: good(t, y).astype("f4"))
    assert any("`terms[2]` returns float32" in x for x in single.notices)
    calls = itertools.count()
    late = summed(lambda t, y: good(t, y) * (1.0 if next(calls) < 6 else 1.01))
    assert any("`terms[2]` gives another value" in x for x in late.notices)
    assert not [x for x in summed(in_place).notices if "terms" in x]
    with pytest.raises(UsageError, match="`f` and its `terms` disagree at the start: component 1"):
        summed(lambda t, y: good(t, y), f=lambda t, y: 2 * good(t, y))
    assert summed(good, f=good).completed


def test_an_ensemble_asks_for_a_state_before_it_compiles(monkeypatch):
    # numba ends the process where it links a function that returns a map
    from glmref.engine import runners
    from glmref.engine.ensemble import solve_ensemble

    monkeypatch.setattr(runners, "prepare", None)
    with pytest.raises(UsageError, match="an iterator, which can be read only once"):
        solve_ensemble(oscillator(lambda t, y: map(float, y)), "rk4", [[1, 0]] * 2, h=0.1, steps=2)


@pytest.mark.slow
def test_an_ensemble_of_infinite_slopes_warns_of_nothing():
    from glmref.engine.ensemble import solve_ensemble

    steep = oscillator(lambda t, y: [math.inf, 1.0])
    found = solve_ensemble(steep, "rk4", [[1.0, 0.0]] * 2, h=0.1, steps=2)
    assert {str(x) for x in found.outcomes} == {"not finite"}


def counting(number):
    """A function that differs slightly at every call."""
    calls = itertools.count()
    return lambda t, y: np.array([y[1], -y[0]]) * (1 + number * next(calls))


@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
@pytest.mark.parametrize("method", ["rk4", "gauss-2", "g6245"])
def test_a_random_or_counting_function_is_refused(method, engine):
    random = np.random.default_rng(1)
    for f in (lambda t, y: y + 1e-6 * random.standard_normal(2), counting(1e-9)):
        with pytest.raises(UsageError, match="two different values at the same point"):
            solve(oscillator(f), method, h=0.1, steps=10, engine=engine)


@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
def test_random_parts_are_refused(engine):
    random = np.random.default_rng(1)
    chance = Problem(dq=lambda p: p, dp=lambda q: -q * random.random(), y0=(1.0, 0.0))
    for method in ("stormer-verlet", "gauss-2"):
        with pytest.raises(UsageError, match="`dp` gives two different values"):
            solve(chance, method, h=0.1, steps=3, engine=engine)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
def test_what_varies_later_in_the_run_is_noticed_at_its_end(engine):
    random = np.random.default_rng(1)
    calls, clock = itertools.count(), itertools.count()  # a clock that no other work moves
    late = {
        "clock": lambda t, y: [y[1], -y[0] * (1 + 1e-3 * max(0, next(clock) - 10))],
        "chance after t = 1/2": lambda t, y: [y[1], -y[0] * (1 + (t > 0.5) * random.random())],
        "from the tenth call": lambda t, y: [y[1], -y[0] * (1 + (next(calls) > 10))],
    }
    for name, f in late.items():
        run = solve(oscillator(f), "rk4", h=0.01, steps=100, engine=engine)
        assert any("gives another value" in x for x in run.notices), name


def test_round_off_that_varies_is_no_reason_to_refuse():
    calls = itertools.count()
    f = lambda t, y: [y[1], -y[0] * (1 + 2.0**-52 * (next(calls) % 2))]  # noqa: E731
    run = solve(oscillator(f), "rk4", h=0.1, steps=10, engine="interpreted")
    assert run.completed and any("round-off" in x for x in run.notices)


def raises_later(t, y):
    if t > 0.5:
        raise RuntimeError("the model ends here")
    return [y[1], -y[0]]


def short_later(t, y):
    return y[:1] if t > 0.5 else np.array([y[1], -y[0]])


def value_later(t, y):
    if t > 0.5:
        raise ValueError("no root")
    return [y[1], -y[0]]


@pytest.mark.sampled(1, besides=("reference", "gauss-2"))
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("method", ["rk4", "gauss-2", "tr-bdf2"])
@pytest.mark.parametrize("f", [raises_later, short_later, value_later])
def test_a_function_that_fails_on_the_way_keeps_the_good_part(f, method, engine):
    h = 2.0**-10
    run = solve(oscillator(f), method, h=h, steps=2000, every=1, engine=engine)
    whole = solve(oscillator(good), method, h=h, steps=2000, every=1, engine=engine)
    named = Outcome.NOT_FINITE if f is value_later else Outcome.FUNCTION_FAILED
    assert run.outcome is named, run.message
    says = {raises_later: "RuntimeError: the model ends here", value_later: "ValueError: no root"}
    assert says.get(f, "return") in run.message and "\n" not in run.message
    # every step within t <= 1/2 is there, and is that of the run that goes on
    assert 510 <= run.steps <= 512 and len(run.t) == run.steps + 1
    np.testing.assert_array_equal(run.y, whole.y[: len(run.y)])
    np.testing.assert_array_equal(run.values[0], run.y[-1])


@pytest.mark.sampled(1)
@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
def test_no_value_at_the_very_start_is_no_reason_to_refuse(engine):
    # the Gauss points lie inside the step: 1/sqrt(t) is integrated from 0
    root = Problem(f=lambda t, y: [1 / math.sqrt(t)], y0=(0.0,), name="root")
    run = solve(root, "gauss-2", h=0.1, steps=10, engine=engine)
    assert run.completed and abs(run.y[-1, 0] - 2) < 0.2
    explicit = solve(root, "rk4", h=0.1, steps=10, engine=engine)
    assert explicit.outcome is Outcome.NOT_FINITE and explicit.steps == 0
    # the reference rounds an abscissa 0 of rk4 to a number beside it
    # compiled code says that there is no number, the interpreter what was raised
    native = explicit.kernel.startswith("native")
    assert native or "raised" in explicit.message or "division by zero" in explicit.message


@pytest.mark.slow
def test_an_ensemble_looks_at_functions_too():
    from glmref.engine.ensemble import solve_ensemble

    table = {"k": 1.0}

    def ends(t, y):  # which numba refuses, so that the trajectories are stepped by the interpreter
        if y[1] < -2.5:
            raise RuntimeError("too fast")
        return [y[1], -table["k"] * y[0]]

    random = np.random.default_rng(1)
    with pytest.raises(UsageError, match="two different values at the same point"):
        solve_ensemble(
            oscillator(lambda t, y: y * random.random()), "rk4", [[1, 0]], h=0.1, steps=2
        )
    found = solve_ensemble(oscillator(ends), "rk4", [[1.0, 0.0], [3.0, 0.0]], h=0.1, steps=40)
    assert [str(x) for x in found.outcomes] == ["completed", "right-hand side failed"]
    assert found.steps[0] == 40 and 5 < found.steps[1] < 15
    assert np.isfinite(found.y).all()


@pytest.mark.slow
def test_an_ensemble_says_what_is_doubtful_of_a_function():
    from glmref.engine.ensemble import solve_ensemble

    def lost(t, y):
        return np.array([y[1], -y[0]]).astype(np.float32)

    calls = iter(range(10**9))

    def tired(t, y):
        return [y[1], -y[0] * (1.0 if next(calls) < 8 else 1.01)]

    for function, words in ((lost, "float32"), (tired, "do not trust this run")):
        found = solve_ensemble(oscillator(function), "rk4", [[1.0, 0.0]] * 2, h=0.1, steps=4)
        assert [x for x in found.notices if words in x], found.notices
    fine = solve_ensemble(oscillator(good), "rk4", [[1.0, 0.0]] * 2, h=0.1, steps=4)
    assert not [x for x in fine.notices if "`f`" in x]


def test_a_loop_body_that_spoils_its_argument_is_refused():
    from glmref.problems.loops import Loops

    spoiled = Problem(f=Loops(spoiling_body, (2,)), y0=(1.0, 0.0))
    refused(UsageError, "writes into its argument", solve, spoiled, "gauss-2", h=0.1, steps=3)


@pytest.mark.parametrize("spoiled", ["dq", "dp"])
def test_a_loop_body_of_a_half_is_given_that_half(spoiled):
    """The body reads and spoils the last place of its own half, of two states of each."""
    from glmref.problems.loops import Loops

    parts = {name: Loops(body_of_half, (2,)) for name in ("dq", "dp")}
    fine = Problem(**parts, y0=(1.0, 0.0, 0.0, 1.0))
    assert solve(fine, "stormer-verlet", h=0.1, steps=3, engine="reference").completed
    parts[spoiled] = Loops(spoiling_body_of_half, (2,))
    with pytest.raises(UsageError, match=f"loop body of `{spoiled}` writes into its argument"):
        solve(Problem(**parts, y0=(1.0, 0.0, 0.0, 1.0)), "stormer-verlet", h=0.1, steps=3)


def body_of_half(x, params, out):
    out[0] = x[0]
    out[1] = x[1]


def spoiling_body_of_half(x, params, out):
    body_of_half(x, params, out)
    x[1] += 1.0


def spoiling_body(t, y, params, out):
    out[0] = y[1]
    out[1] = -y[0]
    y[0] = 0.0


def test_a_jacobian_of_another_shape_is_refused():
    wrong = Problem(f=listed, y0=(1.0, 0.0), jacobian=lambda t, y: np.eye(3))
    with pytest.raises(FunctionFailed, match=r"`jacobian` must return shape \(2, 2\)"):
        solve(wrong, "gauss-2", h=0.1, steps=3, engine="interpreted")


@pytest.mark.slow
def test_compiled_code_that_computes_something_else_is_not_used():
    def f(t, y):
        return [y[1], -y[0] * (3**40 * 3 // 3**40) / 3]  # 3**41 does not fit 64 bits

    run = solve(oscillator(f), "rk4", h=0.1, steps=10)
    exact = solve(oscillator(good), "rk4", h=0.1, steps=10)
    np.testing.assert_allclose(run.y, exact.y, rtol=1e-13)


def test_extended_precision_calls_on_copies_too():
    expected = solve(
        oscillator(("y[1]", "-y[0]")), "rk4", h=0.1, steps=5, engine="reference", digits=30
    )
    for f in (in_place, sharing([0, 0])):
        run = solve(oscillator(f), "rk4", h=0.1, steps=5, engine="reference", digits=30)
        assert max(abs(a - b) for a, b in zip(run.y[-1], expected.y[-1], strict=True)) < 1e-28


def test_parts_that_are_not_f_are_refused_by_their_worst_component():
    def problem_of(last):
        return Problem(
            f=lambda t, y: [y[1], -y[0] * last], dq=lambda p: [p[0]], dp=lambda q: [-q[0]],
            y0=(1.0, 2.0),
        )  # fmt: skip

    assert solve(problem_of(1 + 1e-7), "rk4", h=0.1, steps=1, engine="reference").completed
    with pytest.raises(UsageError) as found:
        solve(problem_of(1.5), "rk4", h=0.1, steps=1, engine="reference")
    assert str(found.value) == (
        "`f` and its parts `dq`, `dp` disagree at the start: component 1 is -1.5 in f and -1 in the "
        "parts"
    )


@pytest.mark.parametrize("engine", ["reference", "interpreted"])
def test_an_interrupt_after_the_last_step_loses_no_solution(engine):
    left = [10**6]

    def f(t, y):
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt
        return -y

    own = Problem(f=f, y0=(1.0,))
    good = solve(own, "rk4", h=0.1, steps=5, engine=engine)
    for last in (1, 2, 3):  # of the calls after the run
        left[0] = 10**6 - left[0] - last + 1
        with pytest.raises(Interrupted) as caught:
            solve(own, "rk4", h=0.1, steps=5, engine=engine)
        found = caught.value.solution
        assert found.completed and np.array_equal(found.values, good.values)
        assert found.notices[-1:] == ("the calls of the functions after the run were interrupted",)
        left[0] = 10**6
        solve(own, "rk4", h=0.1, steps=5, engine=engine)


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("engine", ["reference", "interpreted", "compiled"])
def test_digits_lost_late_in_the_run_are_noticed(engine):
    def f(t, y):
        return (-y).astype(np.float32) if t > 0.35 else -y

    found = solve(Problem(f=f, y0=(1.0,)), "rk4", h=0.1, steps=5, engine=engine)
    assert found.completed and any("float32" in x for x in found.notices)
