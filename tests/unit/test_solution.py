"""What a person does with a solution: stop it, ask between rows, draw, save; what others call it."""

import pickle
from typing import Any

import numpy as np
import pytest

import glmref
from glmref.engine.foreign import INSTEAD
from glmref.engine.outcome import Outcome
from glmref.engine.solve import ENGINES
from glmref.errors import UsageError
from glmref.views import plot
from tests.build import refused

H = "p**2/2 - cos(q)"


def pendulum(**options: Any) -> glmref.Problem:
    return glmref.Problem.from_hamiltonian(H, y0={"q": 1, "p": 0}, **options)


# --- Ctrl-C -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
def test_ctrl_c_ends_a_loop_and_carries_what_was_computed(engine: str) -> None:
    done: list[float] = []

    def stop(steps: int, _: int) -> None:
        if steps >= 20:
            raise KeyboardInterrupt

    def loop() -> None:
        for h in (0.1, 0.05):
            glmref.solve(pendulum(), "rk4", h=h, steps=10**6, every=1, progress=stop, engine=engine)
            done.append(h)

    with pytest.raises(KeyboardInterrupt) as caught:
        loop()
    assert not done
    found = caught.value.solution  # type: ignore[attr-defined]
    assert found.outcome is Outcome.CANCELLED and found.steps >= 20
    same = glmref.solve(pendulum(), "rk4", h=0.1, steps=20, every=1, engine=engine)
    np.testing.assert_array_equal(found.y[:21], same.y)
    assert "cancelled" in str(caught.value)


def test_a_run_that_is_cancelled_by_its_caller_is_no_interrupt() -> None:
    found = glmref.solve(pendulum(), "rk4", h=0.1, steps=10**6, cancel=lambda: True)
    assert found.outcome is Outcome.CANCELLED


# --- names ------------------------------------------------------------------------------------------


def test_components_have_the_names_of_the_problem() -> None:
    found = glmref.solve(pendulum(), "gauss-2", h=0.1, steps=10, every=1)
    assert found.names == ("q", "p")
    np.testing.assert_array_equal(found["p"], found.y[:, 1])
    plane = glmref.Problem.from_hamiltonian(
        "sum((px[i]**2 + py[i]**2)/2 for i in range(n))"
        " + sum((qx[i]**2 + 2*qy[i]**2)/2 for i in range(n))",
        y0={"qx": [1, 2], "qy": [3, 4], "px": [5, 6], "py": [7, 8]},
    )
    assert plane.labels == ("qx[0]", "qy[0]", "qx[1]", "qy[1]", "px[0]", "py[0]", "px[1]", "py[1]")
    bodies = glmref.solve(plane, "stormer-verlet", h=0.1, steps=4, every=1)
    assert bodies["qy"][0].tolist() == [3.0, 4.0] and bodies["py"].shape == (5, 2)
    named = glmref.Problem.from_equations({"x": "v", "v": "-x"}, y0={"x": 1, "v": 0})
    assert named.labels == ("x", "v")
    assert glmref.Problem(f=lambda t, y: y, y0=[1.0, 2.0]).labels == ("y[0]", "y[1]")
    with pytest.raises(UsageError, match="no component is called 'w'; they are q, p"):
        found["w"]
    with pytest.raises(UsageError, match="`names` must be 1 names"):
        glmref.Problem(f=lambda t, y: y, y0=[1.0], names=("a", "b"))


# --- between the rows -------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("method", "h", "every"),
    [("gauss-4", 0.1, 7), ("ab-2", 0.01, 30), ("stormer-verlet", -0.01, 9), ("pair-6-8", 0.1, 4)],
)
def test_between_the_rows_the_solution_has_the_accuracy_of_the_run(method, h, every):
    steps = 10 * every
    found = glmref.solve(pendulum(), method, h=h, steps=steps, every=every)
    reference = glmref.solve(pendulum(), "gauss-8", h=h, steps=steps, every=1)
    own = np.abs(glmref.solve(pendulum(), method, h=h, steps=steps, every=1).y - reference.y).max()
    times = np.linspace(0, steps * h, 23)
    exact = [glmref.solve(pendulum(), "gauss-8", h=t / 100, steps=100).y[-1] for t in times[1:]]
    assert np.abs(found.at(times)[1:] - exact).max() <= 3 * own + 1e-13
    np.testing.assert_array_equal(found.at(found.t), found.y)
    assert found.at(float(times[3])).shape == (2,)


def test_what_lies_outside_of_the_rows_is_refused() -> None:
    found = glmref.solve(pendulum(), "rk4", h=0.1, steps=10, every=5)
    for t in (-0.1, 1.01):
        refused(UsageError, "within the rows kept, 0 to 1", found.at, t)
    ends = glmref.solve(pendulum(), "rk4", h=0.1, steps=10)
    refused(UsageError, "keep more with `every`", ends.at, 0.5)
    for wrong in ("soon", [0.1, None], float("nan")):
        refused(UsageError, "`t` must be", found.at, wrong)


# --- files ------------------------------------------------------------------------------------------


def test_a_solution_is_saved_and_read_again(tmp_path) -> None:
    found = glmref.solve(pendulum(), "ab-2", h=0.1, steps=20, every=3, history=True)
    again = glmref.Solution.load(found.save(tmp_path / "run.npz"))
    for key in ("t", "y", "values", "history"):
        np.testing.assert_array_equal(getattr(again, key), getattr(found, key))
    assert repr(again) == repr(found) and again.names == found.names
    assert (again.outcome, again.notices, again.h) == (found.outcome, found.notices, found.h)
    with np.load(tmp_path / "run.npz") as arrays:  # by numpy alone, too
        np.testing.assert_array_equal(arrays["y"], found.y)
    refused(UsageError, "keep more rows", again.at, 0.15)
    assert pickle.loads(pickle.dumps(found)).origin is None


def test_what_is_no_solution_is_refused(tmp_path) -> None:
    found = glmref.solve(pendulum(), "rk4", h=0.1, steps=2)
    refused(UsageError, r"such as run\.npz", found.save, tmp_path / "run.csv")
    (tmp_path / "text.npz").write_text("not numpy's")
    np.savez(tmp_path / "other.npz", t=np.zeros(2))
    np.savez(tmp_path / "objects.npz", facts=np.array([{}], dtype=object))
    for name in ("text", "other", "objects"):
        refused(UsageError, "no solution", glmref.Solution.load, tmp_path / f"{name}.npz")
    refused(UsageError, "cannot be read", glmref.Solution.load, tmp_path / "missing.npz")
    precise = glmref.solve(pendulum(), "rk4", h=0.1, steps=2, digits=30, engine="reference")
    refused(UsageError, "numbers of mpmath", precise.save, tmp_path / "run.npz")


# --- pictures ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "labels"), [("energy", ["t", "(H - H(0)) / |H(0)|"]), ("phase", ["q", "p"])]
)
def test_a_picture_of_each_kind(kind: str, labels: list[str]) -> None:
    found = glmref.solve(pendulum(), "rk4", h=0.1, steps=50, every=1)
    lines, axes = plot.KINDS[kind](found, None)
    assert list(axes) == labels and len(lines) == 1
    drawn = found.plot(kind)
    assert drawn.startswith("<svg") and found.plot(kind) == drawn
    if kind == "energy":
        (error,) = (y for _, y in lines.values())
        first = -np.cos(1.0)
        assert error == pytest.approx(
            (found["p"] ** 2 / 2 - np.cos(found["q"]) - first) / abs(first), abs=1e-15
        )


def test_an_orbit_is_drawn_of_every_body() -> None:
    kepler = glmref.solve("kepler", "gauss-3", h=0.1, steps=20, every=1)
    lines, axes = plot.KINDS["orbit"](kepler, None)
    assert list(lines) == ["q[0], q[1]"] and axes == ("q[0]", "q[1]")
    assert kepler.plot("orbit").startswith("<svg")
    outer = glmref.solve("outer-solar-system", "stormer-verlet", h=10, steps=3, every=1)
    lines, _ = plot.KINDS["orbit"](outer, None)
    assert len(lines) == 6
    for place, (x, y) in enumerate(lines.values()):
        np.testing.assert_array_equal(x, outer.y[:, 3 * place])
        np.testing.assert_array_equal(y, outer.y[:, 3 * place + 1])


def test_what_cannot_be_drawn_is_refused_in_one_sentence() -> None:
    found = glmref.solve(pendulum(), "rk4", h=0.1, steps=5, every=1)
    stiff = glmref.solve("robertson", "radau-iia-3", h=1e-3, steps=5, every=1)
    for solution, kind, said in (
        (found, "orbit", "two coordinates"),
        (stiff, "energy", "gives its Hamiltonian"),
        (stiff, "phase", r"states \(q, p\)"),
        (found, "spiral", "`kind` must be one of time, energy, phase, orbit"),
        (found, ["time"], "`kind` must be one of"),
    ):
        refused(UsageError, said, solution.plot, kind)
    refused(UsageError, "must be two, got 1", found.plot, "orbit", components=["q"])


# --- arguments of others ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*INSTEAD, "tolerance"])
def test_arguments_of_other_solvers_are_refused_with_what_to_give(name: str) -> None:
    with pytest.raises(UsageError, match=rf"^`solve` has no argument `{name}`: \S") as found:
        glmref.solve("kepler", "rk4", h=0.1, steps=1, **{name: 1})
    assert "\n" not in str(found.value)


def test_progress_is_shown_on_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    glmref.solve("kepler", "rk4", h=0.1, steps=100, progress=True)
    shown = capsys.readouterr().err
    assert shown.endswith("\r100 % of 100 steps\n") and shown.count("\n") == 1
    glmref.solve("kepler", "rk4", h=0.1, steps=100, progress=False)
    assert capsys.readouterr().err == ""


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_the_exception_of_a_right_hand_side_is_named(engine: str) -> None:
    def f(t: Any, y: Any) -> list[float]:
        return [1 / (0 if t > 0.12 else 1)]  # in the second half of the second step

    found = glmref.solve(glmref.Problem(f=f, y0=[1.0]), "rk4", h=0.1, steps=3, engine=engine)
    assert found.outcome is Outcome.NOT_FINITE and found.steps == 1
    assert "`f` raised ZeroDivisionError: division by zero at t = 0.15" in found.message
