"""Other people's integrators, one small adapter each, imported only when asked for.

A peer gets the same right-hand side (numpy for scipy, nodepy and CVODE, symbols for heyoka, traced
arrays for diffrax, bodies for rebound), a relative tolerance, and times at which it reports states.
Compilation and import are not timed; every run is timed as a whole, from the initial state on.

The extra ``peers`` installs scipy; the others are installed by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass
from importlib import import_module
from time import perf_counter
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..compute.records import finite
from ..errors import UsageError
from ..problems.formula import FUNCTIONS
from ..problems.model import Problem
from ..system.arguments import no_such
from .longtime import energy_deviation
from .timing import repeat
from .work_precision import SAMPLES, judged_state

#: Steps after which a peer gives up, where it can be told.
MOST_STEPS = 10_000_000


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a peer."""

    y: np.ndarray  #: (m, d) states at the times asked for.
    #: Right-hand-side evaluations, ``None`` where the peer does not count them.
    evaluations: int | None = None
    steps: int | None = None  #: Steps taken, ``None`` where it does not tell.
    message: str = ""  #: Why it ended early, ``""`` where it did not.


#: ``runner(problem, tolerance, times) -> Run``; what can be prepared is prepared before.
Runner = Callable[[], Run]
Adapter = Callable[[Problem, float, np.ndarray, str], Runner]


def _scipy(problem: Problem, tolerance: float, times: np.ndarray, method: str) -> Runner:
    integrate = import_module("scipy.integrate")
    options: dict[str, Any] = {"rtol": max(tolerance, 2.3e-14), "atol": tolerance * _floor(problem)}
    if method in ("Radau", "BDF") and problem.jacobian is not None:
        options["jac"] = problem.jacobian

    def run() -> Run:
        span = (float(problem.t_span[0]), float(times[-1]))
        solved = integrate.solve_ivp(
            problem.f, span, problem.y0, method=method, t_eval=times, **options
        )
        return Run(solved.y.T, int(solved.nfev), None, "" if solved.success else solved.message)

    return run


def _floor(problem: Problem) -> float:
    """Return absolute tolerance per unit of relative tolerance: the size of the initial state."""
    return float(np.max(np.abs(problem.y0))) or 1.0


def names_of(module: Any, *, mpf: Callable[[Any], Any] = float, **renamed: str) -> SimpleNamespace:
    """Return a module's functions as the context a problem's functions are evaluated in."""
    found = {name: getattr(module, renamed.get(name, name)) for name in FUNCTIONS}
    return SimpleNamespace(mpf=mpf, pi=math.pi, **found)


def _sundae(problem: Problem, tolerance: float, times: np.ndarray, method: str) -> Runner:
    cvode = import_module("sksundae.cvode")

    def slope(t: float, y: np.ndarray, out: np.ndarray) -> None:
        out[:] = problem.f(t, y)

    solver = cvode.CVODE(
        slope, method=method, rtol=tolerance, atol=tolerance * _floor(problem),
        max_num_steps=MOST_STEPS,
    )  # fmt: skip
    # two times are asked of it as the ends of a span, at whose own steps it then reports
    inner = times if len(times) > 1 else np.array([(problem.t_span[0] + times[0]) / 2, times[0]])
    asked = np.concatenate([[float(problem.t_span[0])], inner])

    def run() -> Run:
        solved = solver.solve(asked, np.array(problem.y0, dtype=float))
        rows = np.asarray(solved.y)[1:][-len(times) :]
        return Run(rows, int(solved.nfev), None, "" if solved.success else str(solved.message))

    return run


def heyoka_system(problem: Problem) -> list[tuple[Any, Any]]:
    """Return the right-hand side of expressions or loops as heyoka has it, by variable."""
    heyoka, f = import_module("heyoka"), problem.f
    names = [f"y{i}" for i in range(problem.dimension)]
    symbols = np.array(heyoka.make_vars(*names), dtype=object).reshape(-1)
    slopes = f.on(names_of(heyoka))(heyoka.time, symbols)  # type: ignore[union-attr]
    return [(x, heyoka.expression(0.0) + s) for x, s in zip(symbols, slopes, strict=True)]


def _heyoka(problem: Problem, tolerance: float, times: np.ndarray, method: str) -> Runner:
    heyoka = import_module("heyoka")
    if not hasattr(problem.f, "on"):
        raise UsageError(f"{method} needs {problem.name} as expressions or loops, not a function")
    system = heyoka_system(problem)
    start, y0 = float(problem.t_span[0]), [float(x) for x in problem.y0]
    integrator = heyoka.taylor_adaptive(system, y0, time=start, tol=tolerance)

    def run() -> Run:
        integrator.time = start
        integrator.state[:] = y0
        outcome, _, _, steps, *_, states = integrator.propagate_grid([start, *times.tolist()])
        done = outcome == heyoka.taylor_outcome.time_limit
        return Run(np.array(states)[1:], None, int(steps), "" if done else str(outcome))

    return run


def traced_by_jax(problem: Problem) -> Callable[[Any, Any, Any], Any]:
    """Return the right-hand side of expressions or loops as a function that jax can trace."""
    numpy = import_module("jax.numpy")
    f: Any = problem.f
    f = f.on(names_of(numpy, atan2="arctan2"))

    def slope(t: Any, y: Any, _: Any) -> Any:
        state = np.empty(problem.dimension, dtype=object)
        for i in range(problem.dimension):
            state[i] = y[i]
        return numpy.stack([numpy.asarray(x) for x in f(t, state)])

    return slope


def _diffrax(problem: Problem, tolerance: float, times: np.ndarray, method: str) -> Runner:
    jax, diffrax = import_module("jax"), import_module("diffrax")
    jax.config.update("jax_enable_x64", True)
    numpy = import_module("jax.numpy")
    if not hasattr(problem.f, "on"):
        raise UsageError(f"{method} needs {problem.name} as expressions or loops, not a function")
    slope = traced_by_jax(problem)

    @jax.jit
    def integrate(y0: Any) -> Any:
        solved = diffrax.diffeqsolve(
            diffrax.ODETerm(slope), getattr(diffrax, method)(), float(problem.t_span[0]),
            float(times[-1]), None, y0, saveat=diffrax.SaveAt(ts=times), throw=False,
            stepsize_controller=diffrax.PIDController(
                rtol=tolerance, atol=tolerance * _floor(problem)
            ),
            max_steps=MOST_STEPS, adjoint=diffrax.ForwardMode(),
        )  # fmt: skip
        return solved.ys, solved.stats["num_steps"], solved.result == diffrax.RESULTS.successful

    y0 = numpy.asarray(problem.y0)
    jax.block_until_ready(integrate(y0))  # compile

    def run() -> Run:
        y, steps, done = jax.block_until_ready(integrate(y0))
        return Run(np.array(y), None, int(steps), "" if bool(done) else "the solver gave up")

    return run


def _rebound(problem: Problem, tolerance: float, times: np.ndarray, method: str) -> Runner:
    rebound = import_module("rebound")
    gravity, masses, space = _bodies(problem)
    d = problem.dimension

    def run() -> Run:
        simulation = rebound.Simulation()
        simulation.G, simulation.integrator = gravity, method
        y0 = np.array(problem.y0, dtype=float)
        if problem.name == "kepler":
            y0 = np.concatenate([[0.0, 0.0], y0[:2], [0.0, 0.0], y0[2:]])
        half = len(y0) // 2
        for k, mass in enumerate(masses):
            axes = slice(space * k, space * (k + 1))
            place = dict(zip("xyz", y0[:half][axes], strict=False))
            speed = dict(zip(("vx", "vy", "vz"), y0[half:][axes], strict=False))
            simulation.add(m=mass, **place, **speed)
        # version 4 keeps the settings of IAS15 apart, version 5 with the integrator itself
        settings: Any = getattr(simulation, "ri_ias15", None) or simulation.integrator
        settings.epsilon = tolerance
        rows = []
        for t in times - float(problem.t_span[0]):
            simulation.integrate(float(t))
            moving = list(simulation.particles)[1 if problem.name == "kepler" else 0 :]
            q = [getattr(body, axis) for body in moving for axis in "xyz"[:space]]
            p = [getattr(body, f"v{axis}") for body in moving for axis in "xyz"[:space]]
            rows.append(q + p)
        return Run(np.array(rows).reshape(-1, d), None, int(simulation.steps_done))

    return run


def _bodies(problem: Problem) -> tuple[float, list[float], int]:
    """Return the gravity constant, masses and dimension of space of a gravitational problem."""
    if problem.name == "kepler":
        return 1.0, [1.0, 0.0], 2
    body = getattr(getattr(problem, "force", None), "body", None)
    spaces = {"gravity_2_into": 2, "gravity_3_into": 3}
    space = spaces.get(getattr(body, "__name__", ""))
    if space is None:
        raise UsageError(f"rebound integrates gravitating bodies; {problem.name} has none")
    gravity, *masses = (float(x) for x in problem.params)
    return gravity, masses, space


def _nodepy(problem: Problem, tolerance: float, times: np.ndarray, method: str) -> Runner:
    rk, ivp = import_module("nodepy.runge_kutta_method"), import_module("nodepy.ivp")
    pair = rk.loadRKM(method)
    evaluations = 0

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        evaluations += 1
        return np.asarray(problem.f(t, y))

    def run() -> Run:
        nonlocal evaluations
        evaluations = 0
        y, start, rows = np.array(problem.y0, dtype=float), float(problem.t_span[0]), []
        for end in times.tolist():  # one call each: with several output times 1.1.1 loses some
            task = ivp.IVP(f=slope, u0=y, t0=start, T=end)
            first = (end - start) / 20
            reached, states = pair(task, start, dt=first, errtol=tolerance, max_steps=MOST_STEPS)
            if abs(reached[-1] - end) > 1e-9 * max(1.0, abs(end)):
                return Run(np.array(rows), evaluations, None, "the solver gave up")
            y, start = np.array(states[-1]), end
            rows.append(y)
        return Run(np.array(rows), evaluations)

    return run


_ADAPTERS: dict[str, tuple[str, Adapter, str]] = {
    "scipy-bdf": ("scipy", _scipy, "BDF"),
    "scipy-dop853": ("scipy", _scipy, "DOP853"),
    "scipy-lsoda": ("scipy", _scipy, "LSODA"),
    "scipy-radau": ("scipy", _scipy, "Radau"),
    "scipy-rk45": ("scipy", _scipy, "RK45"),
    "heyoka": ("heyoka", _heyoka, "heyoka"),
    "cvode-adams": ("sksundae", _sundae, "Adams"),
    "cvode-bdf": ("sksundae", _sundae, "BDF"),
    "diffrax-dopri5": ("diffrax", _diffrax, "Dopri5"),
    "diffrax-dopri8": ("diffrax", _diffrax, "Dopri8"),
    "rebound-ias15": ("rebound", _rebound, "ias15"),
    "nodepy-bs5": ("nodepy", _nodepy, "BS5"),
    "nodepy-dp5": ("nodepy", _nodepy, "DP5"),
}
NAMES = tuple(sorted(_ADAPTERS))
#: Names under which packages are installed, where it is not the one they are imported by.
_INSTALLED = {"sksundae": "scikit-sundae"}


def package_of(name: str) -> str:
    """Return the package a peer comes from.

    Raises
    ------
    UsageError
        For an unknown peer.
    """
    if name not in _ADAPTERS:
        raise no_such("peer", name, NAMES)
    return _ADAPTERS[name][0]


def runner(name: str, problem: Problem, *, tolerance: float, times: np.ndarray) -> Runner:
    """Prepare a peer: import, translate and compile; each call of the result is one run.

    Raises
    ------
    UsageError
        For an unknown peer, one that is not installed, or a problem it cannot take.
    """
    package = package_of(name)
    _, adapter, method = _ADAPTERS[name]
    try:
        return adapter(problem, float(tolerance), np.asarray(times, dtype=float), method)
    except ImportError:
        wanted = _INSTALLED.get(package, package)
        raise UsageError(f"{wanted} is not installed; pip install {wanted}") from None


def measure_peer(
    name: str,
    problem: Problem,
    *,
    tolerance: float,
    t_end: float,
    ask: Collection[str] = ("state",),
    repeats: int = 3,
    budget: float = 10.0,
) -> dict[str, Any]:
    """Run a peer and return a record with the fields of :class:`.work_precision.Work`.

    Raises
    ------
    UsageError
        As :func:`runner`.
    """
    end = float(problem.t_span[0]) + t_end
    count = SAMPLES if "energy" in ask else 1
    times = np.linspace(float(problem.t_span[0]), end, count + 1)[1:]
    begun = perf_counter()
    one = runner(name, problem, tolerance=tolerance, times=times)
    build_seconds = perf_counter() - begun
    with np.errstate(all="ignore"):
        run, timing = repeat(one, repeats=repeats, budget=budget)
    finished = not run.message and len(run.y) == len(times) and bool(np.isfinite(run.y).all())
    record: dict[str, Any] = {
        "method": name,
        "problem": problem.name,
        "tolerance": tolerance,
        "steps": run.steps,
        "t_end": end,
        "outcome": "completed" if finished else "not finite" if not run.message else "gave up",
        "message": run.message,
        "seconds": timing.as_json(),
        "evaluations": run.evaluations,
        "build_seconds": build_seconds,
        "notices": [],
    }
    if finished and "state" in ask:
        record |= judged_state(problem, run.y[-1], end)
    if finished and "energy" in ask and problem.hamiltonian is not None:
        deviation = energy_deviation(problem, np.vstack([problem.y0, run.y]))
        record["energy_error"] = finite(float(np.max(deviation)))
    return record
