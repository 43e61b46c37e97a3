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


# --- coefficients -------------------------------------------------------------------------------


@planted("step", "B[1][3] is 0.3334", methods=("rk4",))
class WeightDigit(Base):
    without = ("stages",)

    def spoil(self, engine: Any) -> None:
        engine.B[0, 2] = 0.3334


@planted("stages", "A[4][3] is 0.5 and must be 1", methods=("rk4",))
class CoefficientWrong(Base):
    def spoil(self, engine: Any) -> None:
        engine.A[3, 2] = 0.5


@planted("step", "those of dormand-prince-4", methods=("dormand-prince-5",))
class EmbeddedWeights(Base):
    """Propagates the embedded result of order 4."""

    without = ("stages", "solve")

    def spoil(self, engine: Any) -> None:
        engine.B[0] = np.array(
            [5179 / 57600, 0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40]
        )


@planted("step", "6 digits only", "U[2][2]", methods=("gsymplectic-n",))
class FewDigits(Base):
    """Coefficients typed with six digits."""

    without = ("stages",)

    def spoil(self, engine: Any) -> None:
        engine.U = np.round(engine.U, 6)


# --- order of the stages, blocks ----------------------------------------------------------------


@planted("step", "StagesReordered", methods=("gsymplectic-n",))
class SlopesReversed(Base):
    without = ("stages",)

    def spoil(self, engine: Any) -> None:
        engine.B = engine.B[:, ::-1].copy()


@planted("stages", "StagesOutOfOrder", methods=("gsymplectic-n",))
class LastStageFirst(Base):
    def spoil(self, engine: Any) -> None:
        engine.A = np.diag(np.diag(engine.A))


@planted("stages", "another order", "StagesReordered", methods=("gauss-3",))
class StagesListedBackwards(Base):
    def stages(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().stages(method, problem, t, y, h)[::-1]


@planted("stages", "BlocksSwapped", methods=("gsymplectic-n",))
class BlocksSwapped(Base):
    def spoil(self, engine: Any) -> None:
        engine.U, engine.V = engine.V.copy(), engine.U.copy()


@planted("step", "Transposed", methods=("thesis-3-8",))
class RotationBackwards(Base):
    def spoil(self, engine: Any) -> None:
        engine.V = engine.V.T.copy()


# --- values -------------------------------------------------------------------------------------


@planted("step", "ParasiticDropped", methods=("gsymplectic-p",))
class ParasiticNotCarried(Base):
    def spoil(self, engine: Any) -> None:
        engine.V[1:] = 0.0


@planted("step", "ValuesSwapped", methods=("bdf-2",))
class PastValuesSwapped(Base):
    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().step(method, problem, t, y, h)[::-1]


@planted("step", "component 2 comes out as it went in", methods=("rk4",))
class LastComponentForgotten(Base):
    without = ("stages",)

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        new = super().step(method, problem, t, y, h).copy()
        new[..., -1] = y[-1]
        return new


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


# --- time ---------------------------------------------------------------------------------------


@planted("abscissae", "AbscissaeIgnored", methods=("gauss-2",))
class AbscissaeIgnored(Base):
    def spoil(self, engine: Any) -> None:
        engine.c = 0 * engine.c


@planted("abscissae", "AbscissaeOne", methods=("sdirk-3",))
class AbscissaeOne(Base):
    def spoil(self, engine: Any) -> None:
        engine.c = 0 * engine.c + 1


@planted("backward", "StepSignLost", methods=("rk4",))
class StepSignLost(Base):
    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().step(method, problem, t, y, abs(h))


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


# --- pairs --------------------------------------------------------------------------------------


@planted("step", "PartnerStale", methods=("symplectic-euler-a",))
class PartnerStale(Base):
    without = ("stages",)

    def spoil(self, engine: Any) -> None:
        engine.A_hat = 0 * engine.A_hat


@planted("step", "PartnerNotUpdated", methods=("symplectic-euler-a",))
class PartnerNotUpdated(Base):
    def spoil(self, engine: Any) -> None:
        engine.B = 0 * engine.B


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
