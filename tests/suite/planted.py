"""Wrong integrators, one usual bug each, and what the suite must say of each of them.

``PLANTED`` maps a name to an adapter class with ``claim``, the only claim that may fail, and
``words``, what the message must contain.
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from glmref.conformance.adapters.reference import Adapter as Reference
from glmref.engine.reference import StageSolver, Stepper

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
     "e.B = e.B[:, ::-1].copy()"),
    ("LastStageFirst", "gsymplectic-n", "stages", "StagesOutOfOrder", "",
     "e.A = np.diag(np.diag(e.A))"),
    ("BlocksSwapped", "gsymplectic-n", "stages", "BlocksSwapped", "",
     "e.U, e.V = e.V.copy(), e.U.copy()"),
    ("RotationBackwards", "thesis-3-8", "step", "Transposed", "", "e.V = e.V.T.copy()"),
    ("ParasiticNotCarried", "gsymplectic-p", "step", "ParasiticDropped", "", "e.V[1:] = 0.0"),
    ("AbscissaeIgnored", "gauss-2", "abscissae", "AbscissaeIgnored", "", "e.c = 0 * e.c"),
    ("AbscissaeOne", "sdirk-3", "abscissae", "AbscissaeOne", "", "e.c = 0 * e.c + 1"),
    ("PartnerStale", "symplectic-euler-a", "step", "PartnerStale", "stages",
     "e.A_hat = 0 * e.A_hat"),
    ("PartnerNotUpdated", "symplectic-euler-a", "step", "PartnerNotUpdated", "", "e.B = 0 * e.B"),
    ("WeightSign", "rk4", "step", "B[1][2] is -0.3333333333 and must be 0.3333333333", "stages",
     "e.B[0, 1] *= -1"),
    ("EntriesExchanged", "dormand-prince-5", "stages",
     "A[4][1] is -3.733333333|A[4][2] is 0.9777777778", "", "e.A[3, :2] = e.A[3, 1::-1]"),
    ("TableTransposed", "gauss-3", "step", "A[1][2] is 0.300263195 and must be -0.03597666752",
     "stages", "e.A = e.A.T.copy()"),
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

    def start(self, method: str, problem: Any, h: float) -> Any:
        values = super().start(method, problem, h)
        values[1:] /= h
        return values


@planted("finish", "FinishSkipped", methods=("g4123",))
class FinishSkipped(Base):
    without = ("solve",)

    def finish(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return y[0]


# --- stage equations ----------------------------------------------------------------------------


class Stopped(StageSolver):
    """Takes a few fixed-point iterations only."""

    rounds = 2

    def __call__(self, function: Any, x: Any, scale: Any, alike: Any = ()) -> Any:
        for _ in range(self.rounds):
            x = function(x)
        return x


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


@planted("step", "NewtonStopped", methods=("gauss-2",))
class NewtonStopped(Base):
    """One Newton iteration."""

    without = ("stages",)

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        engine = self._engine(method, problem)
        from glmref.conformance.faults import _newton, _stopped

        return _stopped(engine, t, y.reshape(engine.shape), h, _newton)


@planted("step", "UpdatesExchanged", methods=("stormer-verlet",))
class DriftKickDrift(Base):
    """Position Verlet sold as Störmer-Verlet."""

    without = ("stages", "solve")

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        m = len(y) // 2
        q, p = y[:m], y[m:]
        q = q + h / 2 * problem.dq(p)
        p = p + h * problem.dp(q)
        return np.concatenate([q + h / 2 * problem.dq(p), p])
