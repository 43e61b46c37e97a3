"""The record a scene file becomes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..catalogue.claims import EXPLICIT, G_SYMPLECTIC, PARASITISM_FREE, SYMMETRIC, SYMPLECTIC

if TYPE_CHECKING:
    from ..problems import Problem

FORMAT = "glmref-scene-1"

#: What a scene can ask, and what is recorded for it.
ASK: Mapping[str, str] = {
    "state": "error of the last state, against a closed form or a reference",
    "energy": "largest error of the Hamiltonian over 64 samples",
    "limit": "step size up to which the tableau predicts stability along the solution",
    "invariants": "drift of the conserved quantities and of their G-forms",
    "parasitic": "when the values beyond the solution outgrow it, and when that is predicted",
    "orbit": "at most 400 points of the path in a plane",
    "law": "by which law the conserved quantity deviates, with its exponent",
    "picture": "a log-log picture, as SVG",
}
#: How the one-line answer is made from the records, and what it needs to have been asked.
ANSWERS: Mapping[str, tuple[str, ...]] = {
    "fastest": (),
    "conserved": ("invariants",),
    "lost": ("parasitic",),
    "ended": (),
    "accurate": (),
    "order": ("state",),
    "law": ("law",),
}
#: Answers that are about run time: only for these is a run repeated.
TIMED = ("fastest",)
#: Answers that judge an error, and so need it asked.
JUDGING = ("fastest", "accurate")
#: Groups of methods by what their files claim.
KINDS = tuple(x.key for x in (EXPLICIT, G_SYMPLECTIC, PARASITISM_FREE, SYMMETRIC, SYMPLECTIC))
STARTS = ("zero", "enhanced")


def subject_of(
    name: str, parameters: Mapping[str, Any], definition: Mapping[str, Any] | None
) -> Problem:
    """Return a shipped problem, or the user's own from its table and the folder noted in it.

    Tasks of one scene share the problem, and with it its computed references.
    """
    return _subject(json.dumps([name, dict(parameters), definition], default=str, sort_keys=True))


@lru_cache(maxsize=16)
def _subject(key: str) -> Problem:
    from ..problems import problem
    from ..problems.table import from_table

    name, parameters, definition = json.loads(key)
    if definition is None:
        return problem(name, **parameters)
    table = {k: v for k, v in definition.items() if k not in ("folder", "sha256")}
    return from_table(table, Path(definition["folder"]))


@dataclass(frozen=True)
class Answer:
    """How a scene's one-line answer is computed."""

    kind: str  #: One of :data:`ANSWERS`.
    #: For ``"fastest"`` and ``"accurate"``, which error: ``"state"`` or ``"energy"``.
    error: str = "state"
    #: For these two the error to reach, for ``"conserved"`` the drift that counts as kept.
    at: float = 1e-9


@dataclass(frozen=True)
class Scene:
    """A question about methods on a problem."""

    #: For the reader.
    name: str
    title: str
    question: str
    problem: str  #: Name of the problem.
    methods: tuple[str, ...]  #: Names of shipped methods, or paths of files, in order.
    t_end: float  #: Final time.
    answer: Answer  #: How the answer is computed.
    ask: tuple[str, ...] = ("state",)  #: What is measured, of :data:`ASK`.
    parameters: Mapping[str, Any] = field(default_factory=dict)  #: Its parameters.
    h: tuple[float, ...] = ()  #: Step sizes; empty where ``steps`` is given.
    steps: tuple[int, ...] = ()  #: Numbers of steps to ``t_end``.
    repeats: int = 3  #: Runs to time, where the answer is about time.
    budget: float = 10.0  #: Seconds after which a run is cancelled.
    start: str | None = None  #: ``"zero"``, ``"enhanced"`` or ``None`` for the method's own.
    renew: int = 0  #: Steps after which methods with several values renew them, 0 for never.
    peers: tuple[str, ...] = ()  #: Other integrators.
    tolerances: tuple[float, ...] = ()  #: Relative tolerances they run at.
    file: str = ""  #: Where it was read, for messages.
    #: An own problem as the table of :mod:`glmref.problems.table`, else ``None``.
    definition: Mapping[str, Any] | None = None

    @property
    def subject(self) -> Problem:
        """The problem, built."""
        return subject_of(self.problem, self.parameters, self.definition)

    @property
    def grid(self) -> tuple[tuple[float, int], ...]:
        """Pairs (h, number of steps) that are run, coarsest first as in the file."""
        if self.steps:
            return tuple((self.t_end / n, n) for n in self.steps)
        return tuple((h, round(self.t_end / h)) for h in self.h)
