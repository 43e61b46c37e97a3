"""Wrong integrators, one usual bug each, and what the suite must say of each of them.

``PLANTED`` maps a name to an adapter class with ``claim``, the only claim that may fail, and
``words``, what the message must contain.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from glmref.catalogue.lookup import load
from glmref.conformance.adapters.reference import Adapter as Reference
from glmref.engine.reference import StageSolver, Stepper
from tests.build import floats

from .real_defects import Rosenbrock

PLANTED: dict[str, type[Any]] = {}


def planted(claim: str, *words: str, methods: tuple[str, ...]) -> Any:
    """Register a wrong integrator."""

    def register(cls: type[Any]) -> type[Any]:
        cls.claim, cls.words, cls.planted_methods = claim, words, methods
        PLANTED[cls.__name__] = cls
        return cls

    return register


class Base(Reference):
    """A right integrator to spoil; offers everything but what ``without`` names."""

    planted_methods: ClassVar[tuple[str, ...]] = ("rk4",)
    without: ClassVar[tuple[str, ...]] = ()

    def __init__(self) -> None:
        super().__init__(self.planted_methods)
        for name in self.without:
            setattr(self, name, None)

    def _engine(self, method: str, problem: Any) -> Stepper:
        known = (method, id(problem)) in self._engines
        engine = super()._engine(method, problem)
        if not known:
            self.spoil(engine)
        return engine

    def spoil(self, engine: Any) -> None:
        """Change the coefficients of an engine that was just made."""


# --- coefficients and blocks --------------------------------------------------------------------

#: Name, method, claim, words, what is not offered, and what is done to the engine e.
SPOILED = [
    ("WeightDigit", "rk4", "step", "B[1][3] is 0.3334", "stages", "e.B[0, 2] = 0.3334"),
    ("CoefficientWrong", "rk4", "stages", "A[4][3] is 0.5 and must be 1", "", "e.A[3, 2] = 0.5"),
    # the embedded result of order 4 is propagated
    ("EmbeddedWeights", "dormand-prince-5", "step", "those of dormand-prince-4", "stages solve",
     "e.B[0] = [5179 / 57600, 0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40]"),
    ("FewDigits", "gsymplectic-n", "step", "6 digits only|U[2][2]", "stages",
     "e.U = np.round(e.U, 6)"),
    ("SlopesReversed", "gsymplectic-n", "step", "StagesReordered", "stages",
     "e.B[:] = e.B[:, ::-1].copy()"),
    ("LastStageFirst", "gsymplectic-n", "stages", "StagesOutOfOrder", "",
     "e.A[:] = np.diag(np.diag(e.A))"),
    ("BlocksSwapped", "gsymplectic-n", "stages", "BlocksSwapped", "",
     "e.U, e.V = e.V.copy(), e.U.copy()"),
    ("RotationBackwards", "thesis-3-8", "step", "Transposed", "", "e.V = e.V.T.copy()"),
    ("ParasiticNotCarried", "gsymplectic-p", "step", "ParasiticDropped", "", "e.V[1:] = 0.0"),
    ("AbscissaeIgnored", "gauss-2", "abscissae", "AbscissaeIgnored", "", "e.c = 0 * e.c"),
    ("AbscissaeOne", "sdirk-3", "abscissae", "AbscissaeOne", "", "e.c = 0 * e.c + 1"),
    ("PartnerStale", "symplectic-euler-a", "step", "PartnerStale", "stages",
     "e.A_hat = 0 * e.A_hat"),
    ("PartnerNotUpdated", "symplectic-euler-a", "step", "PartnerNotUpdated", "", "e.B[:] = 0.0"),
    ("WeightSign", "rk4", "step", "B[1][2] is -0.3333333333 and must be 0.3333333333", "stages",
     "e.B[0, 1] *= -1"),
    ("EntriesExchanged", "dormand-prince-5", "stages",
     "A[4][1] is -3.733333333|A[4][2] is 0.9777777778", "", "e.A[3, :2] = e.A[3, 1::-1]"),
    ("TableTransposed", "gauss-3", "step", "A[1][2] is 0.300263195 and must be -0.03597666752",
     "stages", "e.A[:] = e.A.T.copy()"),
    ("PastWeightsExchanged", "bdf-2", "step", "V[1][1] is -0.3333333333 and must be 1.333333333",
     "stages solve", "e.V[0] = e.V[0, ::-1]"),
    ("OneAbscissaWrong", "dormand-prince-5", "abscissae", "f is evaluated at times other than", "",
     "e.c[2] = 0.2"),
    # no stage equations are solved, so that rounding alone may show
    ("LastDigits", "dormand-prince-5", "step", "B[1][1] is", "stages", "e.B[0, 0] += 2e-12"),
    ("WeightOfMomentum", "lobatto-iiia-iiib-3", "step",
     "B_hat[1][2] is 0.6666 and must be 0.6666666667", "stages solve", "e.B_hat[0, 1] = 0.6666"),
    ("ValuesOfMomentumNegated", "pair-4-4", "step", "V_hat[1][1] is -1 and must be 1", "stages",
     "e.V_hat *= -1"),
    ("VelocityWeightsExchanged", "dormand-prince-rkn-4-3", "step",
     "B_hat[1][1] is 0.3950617284 and must be 0.07142857143", "stages solve",
     "e.B_hat[0, :2] = e.B_hat[0, 1::-1]"),
]  # fmt: skip
for name, method, claim, words, without, change in SPOILED:

    def spoil(self: Any, engine: Any, change: str = change) -> None:
        exec(change, {"e": engine, "np": np})

    planted(claim, *words.split("|"), methods=(method,))(
        type(name, (Base,), {"without": tuple(without.split()), "spoil": spoil})
    )


# --- what goes into a step, and what comes out --------------------------------------------------


def component_kept(new: Any, y: Any, t: float, h: float) -> Any:
    new = new.copy()
    new[..., -1] = y[-1]
    return new


def overwritten(new: Any, y: Any, t: float, h: float) -> Any:
    y[...] = new
    return y


def single(x: float) -> float:
    return float(np.float32(x))


_RANDOM = np.random.default_rng(20261124)
#: Name, methods, claim, words, what is not offered, and either what is made of (t, y, h) before a
#: step, or what is made of the new values after it.
STEPPED: list[tuple[str, str, str, str, str, Any, Any]] = [
    ("PastValuesSwapped", "bdf-2", "step", "ValuesSwapped", "", None,
     lambda new, y, t, h: new[::-1]),
    ("LastComponentForgotten", "rk4", "step", "component 2 comes out as it went in", "stages",
     None, component_kept),
    ("StepSignLost", "rk4", "backward", "StepSignLost", "", lambda t, y, h: (t, y, abs(h)), None),
    ("TimeAdvancedFirst", "rk4", "abscissae", "f is evaluated at times other than", "",
     lambda t, y, h: (t + h, y, h), None),
    ("SinglePrecision", "rk4", "step", "single precision", "stages", None,
     lambda new, y, t, h: new.astype(np.float32)),
    ("SinglePrecisionClock", "rk4 gauss-2", "abscissae", "the time is held in single precision",
     "stages", lambda t, y, h: (single(t), y, h), None),
    ("SinglePrecisionStepSize", "forest-ruth-4", "backward",
     "the step size is held in single precision", "stages", lambda t, y, h: (t, y, single(h)),
     None),
    ("RandomNumbers", "rk4", "repeatable", "another one every time, as random numbers", "", None,
     lambda new, y, t, h: new * (1 + 1e-6 * _RANDOM.random())),
    ("InputOverwritten", "rk4", "answer", "changes the array", "", None, overwritten),
    ("TimeAppended", "rk4", "answer", "must return shape (1, 2)", "", None,
     lambda new, y, t, h: np.append(new, t + h)),
    ("NotANumber", "gauss-2", "answer", "not finite", "", None, lambda new, y, t, h: new * np.nan),
]  # fmt: skip
for name, methods, claim, words, without, before, after in STEPPED:

    def step(
        self: Any, method: str, problem: Any, t: float, y: Any, h: float,
        before: Any = before, after: Any = after,
    ) -> Any:  # fmt: skip
        new = Base.step(self, method, problem, *(before(t, y, h) if before else (t, y, h)))
        return after(new, y, t, h) if after else new

    planted(claim, words, methods=tuple(methods.split()))(
        type(name, (Base,), {"without": tuple(without.split()), "step": step})
    )


@planted("stages", "another order", "StagesReordered", methods=("gauss-3",))
class StagesListedBackwards(Base):
    def stages(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().stages(method, problem, t, y, h)[::-1]


# --- values ---------------------------------------------------------------------------------------


@planted("start", "StartZeroed", methods=("gsymplectic-n",))
class StartZeroed(Base):
    def start(self, method: str, problem: Any, h: float) -> Any:
        values = super().start(method, problem, h)
        values[1:] = 0.0
        return values


@planted("start", "8 times the right ones (1/h)", methods=("thesis-3-8",))
class StartWithoutStep(Base):
    """The factor h of the starting method is forgotten."""

    power = -1

    def start(self, method: str, problem: Any, h: float) -> Any:
        values = super().start(method, problem, h)
        values[1:] *= h**self.power
        return values


@planted("start", "0.125 times the right ones (h)", methods=("thesis-3-8",))
class StartTimesStep(StartWithoutStep):
    power = 1


@planted("finish", "FinishSkipped", methods=("g4123",))
class FinishSkipped(Base):
    without = ("solve",)

    def finish(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return y[0]


@planted("finish", methods=("g4123",))
class FinishBackwards(Base):
    without = ("solve",)

    def finish(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().finish(method, problem, t, y, -h)


# --- stage equations ----------------------------------------------------------------------------


class Stopped(StageSolver):
    """Takes a few fixed-point iterations only."""

    rounds = 2

    def __call__(self, function: Any, x: Any, scale: Any, alike: Any = ()) -> Any:
        for _ in range(self.rounds):
            x = function(x)
        return x


class Loose(StageSolver):
    """Iterates until steps are small, but not small enough."""

    def __call__(self, function: Any, x: Any, scale: Any, alike: Any = ()) -> Any:
        while np.abs((new := function(x)) - x).max() > 1e-7:
            x = new
        return new


class StoppedBase(Base):
    """An engine with such a solver."""

    def _taken(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        import glmref.engine.reference as engine

        kept = engine.StageSolver
        engine.StageSolver = self.solver  # type: ignore[misc]
        try:
            return super()._taken(method, problem, t, y, h)
        finally:
            engine.StageSolver = kept  # type: ignore[misc]

    solver: ClassVar[type[StageSolver]] = Stopped


@planted("stages", "IterationStopped", methods=("gauss-2",))
class IterationStopped(StoppedBase):
    pass


class FiveRounds(Stopped):
    rounds = 5


@planted("stages", "iterated and not solved", methods=("radau-iia-2",))
class IterationStoppedLater(StoppedBase):
    """Five iterations: more than any stored result, still not enough."""

    solver = FiveRounds


@planted("stages", "the integrator does something more", methods=("gauss-2",))
class StagesSolvedLoosely(StoppedBase):
    solver = Loose


@planted("step", "NewtonStopped", methods=("gauss-2",))
class NewtonStopped(Base):
    """One Newton iteration."""

    without = ("stages",)

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        engine = self._engine(method, problem)
        from glmref.conformance.faults import _newton, _stopped

        return _stopped(engine, t, y.reshape(engine.shape), h, _newton)


# --- steps of explicit methods, written out -----------------------------------------------------


def rk4(
    problem: Any, t: float, y: Any, h: float, *, first: Any = None, c: float = 0.5,
    second: float | None = None,
) -> tuple[Any, Any]:  # fmt: skip
    """Return a step of the classical method and its last slope, with numbers that may be wrong."""
    f, k1 = problem.f, np.asarray(problem.f(t, y) if first is None else first)
    k2 = f(t + c * h, y + (h / 2 if second is None else second) * k1)
    k3 = f(t + c * h, y + h / 2 * k2)
    last = f(t + h, y + h * k3)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + last), last


def first_same_as_last(engine: Any, problem: Any, t: float, y: Any, h: float, first: Any) -> Any:
    """Return a step of Dormand and Prince's method and its slopes, the first of which is given."""
    slopes = [problem.f(t, y) if first is None else first]
    for i in range(1, 7):
        at = y + h * sum(engine.A[i, j] * k for j, k in enumerate(slopes))
        slopes.append(problem.f(t + engine.c[i] * h, at))
    return y + h * sum(b * k for b, k in zip(engine.B[0], slopes, strict=True)), slopes


def kick_drift_kick(problem: Any, y: Any, h: float, sign: int) -> Any:
    q, p = np.split(y, 2)
    p = p + sign * h / 2 * problem.dp(q)
    q = q + h * problem.dq(p)
    return np.concatenate([q, p + sign * h / 2 * problem.dp(q)])


def drift_kick_drift(problem: Any, y: Any, *sizes: float) -> Any:
    """Steps of position Verlet, one after the other."""
    q, p = np.split(y, 2)
    for h in sizes:
        q = q + h / 2 * problem.dq(p)
        p = p + h * problem.dp(q)
        q = q + h / 2 * problem.dq(p)
    return np.concatenate([q, p])


def raised(problem: Any, t: float, y: Any, h: float) -> Any:
    if problem.dimension == 4:
        raise ZeroDivisionError("radius")
    return rk4(problem, t, y, h)[0]


#: Sizes of the three steps of a method of order 4 (Forest and Ruth; Yoshida): outer, inner.
OUTER, INNER = 1 / (2 - 2 ** (1 / 3)), 1 - 2 / (2 - 2 ** (1 / 3))


def out_of_order(problem: Any, t: float, y: Any, h: float) -> Any:
    return drift_kick_drift(problem, y, OUTER * h, OUTER * h, INNER * h)


#: Name, method, words, step. Neither stages nor runs are offered.
WRITTEN: list[tuple[str, str, str, Any]] = [
    ("DriftKickDrift", "stormer-verlet", "UpdatesExchanged",
     lambda problem, t, y, h: drift_kick_drift(problem, y, h)),
    ("KickSign", "stormer-verlet", "B_hat[1][1] is -0.5 and must be 0.5",
     lambda problem, t, y, h: kick_drift_kick(problem, y, h, -1)),
    ("CompositionOutOfOrder", "forest-ruth-4", "A[2][2] is 1.351207192 and must be -0.175603596",
     out_of_order),
    # h squared in one of the stages
    ("StepSquared", "rk4", "the integrator does something more",
     lambda problem, t, y, h: rk4(problem, t, y, h, second=h * h / 2)[0]),
    ("RaisesInTwoDimensions", "rk4", "raised ZeroDivisionError", raised),
]  # fmt: skip
for name, method, words, taken in WRITTEN:

    def step(
        self: Any, method: str, problem: Any, t: float, y: Any, h: float, taken: Any = taken
    ) -> Any:
        return taken(problem, t, y, h)

    planted("step", words, methods=(method,))(
        type(name, (Base,), {"without": ("stages", "solve"), "step": step})
    )


@planted("repeatable", "keeps something from call to call", methods=("dormand-prince-5",))
class LastSlopeKept(Base):
    """First same as last, but the slope of the last call is used whatever the new input is."""

    without = ("stages", "solve")
    kept: ClassVar[int] = -1

    def __init__(self) -> None:
        super().__init__()
        self.last: Any = (None, None)

    def fits(self, y: Any) -> bool:
        return self.last[0] is not None and len(self.last[0]) == len(y)

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        first = self.last[1] if self.fits(y) else None
        engine = self._engine(method, problem)
        new, slopes = first_same_as_last(engine, problem, t, y, h, first)
        self.last = (new.copy(), slopes[self.kept])
        return new


@planted("trajectory", methods=("dormand-prince-5",))
class LastSlopeOfWrongStage(LastSlopeKept):
    """First same as last, only where the input is the last output; stage 6 is kept and not 7."""

    kept = 5

    def fits(self, y: Any) -> bool:
        return self.last[0] is not None and np.array_equal(self.last[0], y)


# --- runs ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Run:
    """A run as the suite asks for it."""

    right: Reference
    method: str
    problem: Any
    h: float
    steps: int
    start: Any

    def t(self, n: int) -> float:
        """Return the time after n steps."""
        return self.problem.t_span[0] + n * self.h

    def step(self, n: int, values: Any) -> np.ndarray:
        """Take step n + 1 as it is right."""
        return self.right.step(self.method, self.problem, self.t(n), values, self.h)

    def rows(self, **changes: Any) -> np.ndarray:
        """Return the rows of the right integrator, for this run or one with changes."""
        run = replace(self, **changes)
        return self.right.solve(run.method, run.problem, run.h, run.steps, run.start)


def time_not_advanced(run: Run) -> np.ndarray:
    rows = [np.array(run.problem.y0)]
    for _ in range(run.steps):
        rows.append(run.step(0, rows[-1])[0])
    return np.array(rows)


def without_start(run: Run) -> np.ndarray:
    y0 = np.array(run.problem.y0)
    return run.rows(start=np.stack([y0, 0 * y0]))


def without_finish(run: Run) -> np.ndarray:
    values = run.right.start(run.method, run.problem, run.h)
    for n in range(run.steps):
        values = run.step(n, values)
    return values[0]


def past_not_carried(run: Run) -> np.ndarray:
    """The slope of the first step is used in all steps."""
    values = np.array(run.start)
    rows = [values[0]]
    for n in range(run.steps):
        values = np.array([run.step(n, values)[0], *values[1:]])
        rows.append(values[0])
    return np.array(rows)


def history_reversed(run: Run) -> np.ndarray:
    """Starts by Runge-Kutta steps, and keeps their slopes in the wrong order."""
    f, h, t, y = run.problem.f, run.h, run.t(0), np.array(run.problem.y0)
    rows, slopes = [y], [f(t, y)]
    for n in range(run.steps):
        if n < 3:
            y = rk4(run.problem, t, y, h)[0]
        else:
            y = y + h / 24 * np.array([55, -59, 37, -9]) @ np.array(slopes)
        t += h
        rows.append(y)
        slopes = [*slopes, f(t, y)] if n < 3 else [f(t, y), *slopes[:3]]
    return np.array(rows)


#: Name, method, claim, words, rows of a run. Nothing but runs is offered.
RUNS: list[tuple[str, str, str, str, Any]] = [
    ("TimeNotAdvanced", "rk4", "trajectory", "TimeNotAdvanced", time_not_advanced),
    ("StepMissing", "gauss-2", "trajectory", "StepMissing",
     lambda run: run.rows(steps=run.steps - 1)[-1]),
    ("StepHalved", "rk4", "trajectory", "StepHalved",
     lambda run: run.rows(h=run.h / 2, steps=2 * run.steps)[::2]),
    # the error of a step is below what the vectors show as wrong
    ("AccurateStepHalved", "dormand-prince-5", "trajectory", "StepHalved",
     lambda run: run.rows(h=run.h / 2, steps=2 * run.steps)[-1]),
    ("RunWithoutStart", "gsymplectic-n", "trajectory", "StartZeroed", without_start),
    ("RunWithoutFinish", "g4123", "trajectory", "FinishSkipped", without_finish),
    ("PastNotCarried", "ab-2", "trajectory", "", past_not_carried),
    ("HistoryReversed", "ab-4", "order", "falls like h^2|these give order 2", history_reversed),
]  # fmt: skip
for name, method, claim, words, wrong in RUNS:

    def solve(
        self: Any, method: str, problem: Any, h: float, steps: int, start: Any = None,
        wrong: Any = wrong,
    ) -> np.ndarray:  # fmt: skip
        return wrong(Run(Reference(self.methods), method, problem, h, steps, start))

    offered = {"starts": "own"} if name == "HistoryReversed" else {}
    planted(claim, *filter(None, words.split("|")), methods=(method,))(type(name, (Base,), {
        **offered, "solve": solve, "without": ("step", "stages", "start", "finish"),
    }))  # fmt: skip


# --- claims of integrators outside the catalogue ------------------------------------------------


class Foreign:
    """A method the catalogue lacks, with claims of its own."""

    methods: ClassVar = {"mine": {"order": 4}}

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return rk4(problem, t, y, h)[0]


#: Name, claim, words, claims beside order 4, and what is made of (problem, t, y, h) in a step.
CLAIMED: list[tuple[str, str, str, dict[str, Any], Any]] = [
    ("OrderOverclaimed", "order", "falls like h^|not h^5", {"order": 5}, None),
    ("SymplecticityOverclaimed", "symplectic", "M^T J M", {"symplectic": True}, None),
    ("SymmetryOverclaimed", "symmetric", "one back miss the beginning", {"symmetric": True}, None),
    ("SinglePrecisionClaimed", "order", "every number is a single precision number", {},
     lambda *given: rk4(*given)[0].astype(np.float32)),
    ("CompositionClaimed", "order", "its coefficients have order 3|nearest is forest-ruth-4",
     {"symplectic": True}, out_of_order),
    # right for y' = f(y) only
    ("TimesClaimed", "order", "at the times at which f is called misses", {},
     lambda *given: rk4(*given, c=1 / 3)[0]),
    ("InputOverwrittenForeign", "answer", "changes the array", {},
     lambda problem, t, y, h: overwritten(rk4(problem, t, y, h)[0], y, t, h)),
]  # fmt: skip
for name, claim, words, claims, taken in CLAIMED:

    def step(
        self: Any, method: str, problem: Any, t: float, y: Any, h: float, taken: Any = taken
    ) -> Any:
        return taken(problem, t, y, h)

    members = {"methods": {"mine": {"order": 4, **claims}}, **({"step": step} if taken else {})}
    members |= {"problems": ("pendulum", "kepler")} if name == "CompositionClaimed" else {}
    planted(claim, *words.split("|"), methods=("mine",))(type(name, (Foreign,), members))


@planted("repeatable", "keeps something from call to call", methods=("mine",))
class LastSlopeKeptForeign(Foreign):
    """First same as last, whatever the new input is; of a method the catalogue lacks."""

    def __init__(self) -> None:
        self.last: Any = None

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        known = self.last is not None and len(self.last) == len(y)
        new, self.last = rk4(problem, t, y, h, first=self.last if known else None)
        return new


@planted("symplectic", "M^T J M", methods=("mine",))
class RunNotSymplectic(Foreign):
    """A claim of one that shows its runs only; it was not looked at."""

    methods: ClassVar = {"mine": {"order": 4, "symplectic": True}}

    def __init__(self) -> None:
        self.single, self.step = self.step, None  # type: ignore[method-assign]

    def solve(self, method: str, problem: Any, h: float, steps: int) -> Any:
        y, t = np.array(problem.y0), problem.t_span[0]
        for n in range(steps):
            y = self.single(method, problem, t + n * h, y, h)
        return y


class Grk4t(Rosenbrock):
    """Kaps and Rentrop's method, with its table."""

    methods: ClassVar = {"mine": {"order": 4}}

    def __init__(self) -> None:
        known: Any = load("grk4t")
        self.b = np.array([float(x) for x in known.b])
        self.A, self.G = (floats(rows) for rows in (known.alpha, known.gamma))


@planted("order", "falls like h^1", methods=("mine",))
class JacobianTransposed(Grk4t):
    def jacobian(self, problem: Any, t: float, y: Any) -> Any:
        return problem.jacobian(t, y).T


@planted("order", "falls like h^1.00", methods=("mine",))
class OtherGamma(Grk4t):
    def __init__(self) -> None:
        super().__init__()
        np.fill_diagonal(self.G, 0.25)


@planted("order", "falls like h^0.98", methods=("mine",))
class NoDerivativeByTime(Grk4t):
    def by_time(self, problem: Any, t: float, y: Any) -> Any:
        return 0.0
