"""How a run ended, and what it left: where a NaN or an exception becomes a named outcome."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from enum import StrEnum
from io import BytesIO
from pathlib import Path
from typing import Any, ClassVar
from zipfile import BadZipFile

import numpy as np

from ..errors import UsageError, did_you_mean
from ..problems.user_functions import FunctionFailed, NoValue
from ..system.arguments import place, shown
from ..system.files import write_bytes
from ..system.shown import Drawing, Shown, above
from .gauge import Gauge

LARGEST_EXPONENT = 65536


class StartFailed(UsageError):
    """A start or finish whose equations could not be solved, or whose values are not finite."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run.

    Attributes
    ----------
    solution : Solution or EnsembleSolution
        What was computed before; its outcome is ``cancelled``.
    """

    def __init__(self, solution: Any) -> None:
        super().__init__(getattr(solution, "message", "interrupted"))
        self.solution = solution


class Outcome(StrEnum):
    """How a run ended; in every case what was computed before stays in the solution."""

    COMPLETED = "completed"
    STAGE_SOLVE_FAILED = "stage solve failed"
    NOT_FINITE = "not finite"
    STEP_LIMIT = "step limit"
    CANCELLED = "cancelled"
    FUNCTION_FAILED = "right-hand side failed"


#: Codes a kernel returns, in this order; the last stands for an exception that came through it.
KERNEL_OUTCOMES = (
    Outcome.COMPLETED,
    Outcome.STAGE_SOLVE_FAILED,
    Outcome.NOT_FINITE,
    Outcome.FUNCTION_FAILED,
)


def is_finite(x: Any) -> bool:
    """Return whether a number is no NaN and not infinite, as one of mpmath above 2^65536 counts.

    A run that diverges squares its numbers from round to round, and the sine of one with a million
    digits before the point takes minutes.
    """
    parts = getattr(x, "_mpf_", None)
    if parts is None:
        return bool(x == x and abs(x) != math.inf)
    _, mantissa, exponent, bits = parts
    return exponent + bits <= LARGEST_EXPONENT if mantissa else not exponent


def all_finite(values: np.ndarray) -> bool:
    """Return whether every number is finite, in double precision or of mpmath."""
    if values.dtype == object:
        return all(is_finite(x) for x in values.ravel())
    return bool(np.isfinite(values).all())


def outcome_of(error: Exception) -> tuple[Outcome, str]:
    """Return how a run ends in which ``error`` was raised, and what there is to say of it."""
    if isinstance(error, StartFailed):
        return Outcome.STAGE_SOLVE_FAILED, ""
    if isinstance(error, FunctionFailed) and not isinstance(error, NoValue):
        return Outcome.FUNCTION_FAILED, f": {error}"
    return Outcome.NOT_FINITE, f": {error}"


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Shown):
    """What a run computed.

    Attributes
    ----------
    t : np.ndarray
        (m,) times of the rows kept.
    y : np.ndarray
        (m, d) solution at these times (finishing method applied).
    outcome : Outcome
        How the run ended.
    message : str
        One sentence on the outcome; says what to do where it is not ``completed``.
    steps : int
        Number of steps completed.
    values : np.ndarray
        (r, d) the values carried, after the last completed step, in the method's own basis; for a
        pair (max(r, r^), d), q in the first half of the columns and p in the second.
    history : np.ndarray or None
        (m, r, d) the same at every time in ``t``, or ``None`` where not asked for.
    evaluations : int
        Right-hand-side evaluations of the steps. For a separable problem the evaluations of p' =
        dp(q), the expensive half; see ``velocity_evaluations``.
    velocity_evaluations : int
        Evaluations of q' = dq(p) where it is counted apart, else 0.
    iterations : int
        Rounds of the stage solver, summed over stages and steps.
    factorisations : int
        Newton matrices factored.
    seconds : float
        Wall clock time of the steps alone (no compilation, no start).
    start_evaluations, finish_evaluations : int
        Right-hand-side evaluations of start and finish.
    build_seconds : float
        Time to generate, compile or load the kernel.
    method, problem, h
        What was run.
    kernel : str
        What was built: engine, form, solver and arithmetic in words.
    notices : tuple[str, ...]
        Sentences worth knowing, such as a fallback that was taken.
    renewals : int
        How often the values were renewed, see ``renew`` of :func:`glmref.solve`.
    suspect : float or None
        Time at which a parasitic part that takes over was found in a run with an explicit multistep
        pair on a system that is not separable, see docs/nonseparable.md; else ``None``.
    gauge : Gauge or None
        What ``gauge="auto"`` found, and whether the run was done in other coordinates.
    names : tuple[str, ...]
        (d,) names of the components, such as ``q`` and ``p`` where H names them.
    origin : Any
        Problem and method, from which :meth:`at` and plots of the energy compute; ``None`` of a
        solution that was loaded from a file or comes from another process.
    """

    t: np.ndarray
    y: np.ndarray
    outcome: Outcome
    message: str
    steps: int
    values: np.ndarray
    history: np.ndarray | None
    evaluations: int
    velocity_evaluations: int
    iterations: int
    factorisations: int
    seconds: float
    start_evaluations: int
    finish_evaluations: int
    build_seconds: float
    method: str
    problem: str
    h: float
    kernel: str
    notices: tuple[str, ...] = ()
    renewals: int = 0
    suspect: float | None = None
    gauge: Gauge | None = None
    names: tuple[str, ...] = ()
    origin: Any = field(default=None, compare=False)

    _ARRAYS: ClassVar = ("t", "y", "values", "history")

    def __getstate__(self) -> dict[str, Any]:
        """Leave the functions of the problem behind: they need not be of a kind that can go."""
        return {**self.__dict__, "origin": None}

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the values (m,) of a component, or (m, n) of the list of components of a name.

        Raises
        ------
        UsageError
            Where no component has the name.
        """
        if name in self.names:
            return self.y[:, self.names.index(name)]
        of_list = [k for k, x in enumerate(self.names) if x.partition("[")[0] == name]
        if not of_list:
            near = did_you_mean(name, self.names, "; ")
            known = shown(", ".join(self.names), str, 120)
            raise UsageError(f"no component is called {shown(name)}; they are {known}{near}")
        return self.y[:, of_list]

    def at(self, t: Any) -> np.ndarray:
        """Return the solution between the rows that were kept.

        From the last row before t the method takes shorter steps, so that the result has the
        accuracy of the run. Every time costs a short run: for thousands of times keep more rows.

        Parameters
        ----------
        t : float or Sequence[float]
            Times (m,) within the run, or one.

        Returns
        -------
        np.ndarray
            (m, d), or (d,) for one time.

        Raises
        ------
        UsageError
            For a time outside of the rows, and for a solution without its problem.
        """
        return above("engine.between", "at")(self, t)

    def modified_energy(self, order: int) -> np.ndarray:
        """Return the modified energy of the rows kept, (m,): H drifts as h^p, it as h^order.

        Parameters
        ----------
        order : int
            Largest order of a tree; terms of h^order and more are left out.

        Raises
        ------
        UsageError
            As :meth:`glmref.Modified.energy_at`, for an order that the method does not reach, and
            for a solution without its problem.
        """
        return above("scenes.modified", "modified_energy")(self, order)

    def save(self, path: str | Path) -> Path:
        """Write all arrays and facts to an ``.npz`` file, which :meth:`load` and numpy read.

        Raises
        ------
        UsageError
            For another ending, numbers of mpmath, and where the file cannot be written.
        """
        file = place("path", path)
        if file.suffix != ".npz":
            name = shown(file.stem, str)
            raise UsageError(f"a solution is written as .npz; give a name such as {name}.npz")
        if self.y.dtype == object:
            raise UsageError("numbers of mpmath are not written; save the texts of solution.y")
        arrays = {k: x for k in self._ARRAYS if (x := getattr(self, k)) is not None}
        facts = {
            x.name: getattr(self, x.name)
            for x in fields(self)
            if x.name not in (*self._ARRAYS, "origin", "gauge")
        }
        facts["gauge"] = None if self.gauge is None else asdict(self.gauge)
        content = BytesIO()
        np.savez(content, facts=np.array(json.dumps(facts)), **arrays)
        write_bytes(file, content.getvalue())
        return file

    @classmethod
    def load(cls, path: str | Path) -> Solution:
        """Read what :meth:`save` wrote; the functions of the problem are not in the file.

        Raises
        ------
        UsageError
            Where the file is missing, or something else.
        """
        file = place("path", path)
        try:
            with np.load(file, allow_pickle=False) as found:
                facts = json.loads(str(found["facts"]))
                arrays = {k: found[k] for k in cls._ARRAYS if k in found}
            facts["outcome"] = Outcome(facts["outcome"])
            for key in ("notices", "names"):
                facts[key] = tuple(facts[key])
            if facts["gauge"] is not None:
                facts["gauge"] |= {"G": tuple(map(tuple, facts["gauge"]["G"]))}
                facts["gauge"] = Gauge(**facts["gauge"])
            return cls(**{"history": None, **arrays, **facts})
        except OSError as error:
            raise UsageError(f"{shown(str(file), str)} cannot be read: {error.strerror}") from None
        except (ValueError, KeyError, TypeError, BadZipFile):
            raise UsageError(
                f"{shown(str(file), str)} is no solution; give a file that Solution.save wrote"
            ) from None

    def __repr__(self) -> str:
        return (
            f"<Solution of {self.problem} by {self.method or '(unnamed)'}: {self.outcome}, "
            f"{self.steps} steps, "
            f"t = {self.t[-1] if len(self.t) else float('nan'):g}>"
        )

    def plot(self, kind: str = "time", *, components: Sequence[int | str] | None = None) -> Drawing:
        """Draw the solution.

        Parameters
        ----------
        kind : str
            ``"time"``, the components against time; ``"energy"``, the relative error of the
            Hamiltonian against time; ``"phase"``, p over q of each coordinate; ``"orbit"``, the
            path of each body in the plane of its first two coordinates.
        components : Sequence[int or str] or None
            Names or numbers of the components, from 0; of a plot against time the first six by
            default, of an orbit two.

        Returns
        -------
        Drawing
            A picture in SVG: a notebook shows it, and ``save(path)`` writes it.

        Raises
        ------
        UsageError
            Where fewer than two rows were kept: say ``every`` or ``times``; where the problem has
            no Hamiltonian or no such coordinates.
        """
        return above("views.plot", "plot_solution")(self, kind, components)

    @property
    def completed(self) -> bool:
        """Whether every requested step was taken."""
        return self.outcome is Outcome.COMPLETED

    @property
    def total_evaluations(self) -> int:
        """Right-hand-side evaluations of start, steps and finish together."""
        return self.start_evaluations + self.evaluations + self.finish_evaluations
