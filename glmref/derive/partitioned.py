"""Symmetric explicit pairs: what to look for, free parameters, and complete, proved documents.

An ansatz is a pair in the sweep form (:mod:`glmref.method.sweep`) with V = V^ = diag(1, -1),
G = diag(1, g), stages P Q P .. P or Q P Q .. Q and palindromic

    b, c    weights                                b1, b2, ..   c1, c2, ..
    w, v    couplings, antisymmetric               w1, w2, ..   v1, v2, ..

The last of b1, b2, .. that is not fixed follows from sum b_i = 1, likewise for c. The equations are
one tree of every free tree of odd order below the order (:mod:`glmref.prove.equations`), both
growth parameters, and as many starts as make every principal part zero. Scaling q_2 by a number and
p_2 by its inverse changes nothing but w and v: one parameter is always free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ..catalogue.writer import SYMMETRIC, fill
from ..errors import UsageError
from ..exact import Exact
from ..judge.trees import gamma
from ..prove.enclosure import Enclosure, conditions_of, gaps_of, prove
from ..prove.equations import one_of_each
from ..system.arguments import shown
from .ansatz import mirrored, remainder
from .polish import polish

if TYPE_CHECKING:
    import numpy as np

    from .search import Found

#: Values of zeta that are asked to vanish, by number: none, one of them, or both.
STARTS = {
    "": (),
    "q": ("start f[k] 2",),
    "p": ("start k[f] 2",),
    "qp": ("start f[k] 2", "start k[f] 2"),
}


@dataclass(frozen=True)
class PairAnsatz:
    """What to look for."""

    name: str  #: Name of the method to be.
    n: int  #: Stages Q, that is evaluations of k in a step.
    order: int  #: even.
    nystrom: bool = False  #: Whether it is meant for second-order systems only.
    outer: str = "P"  #: ``"P"`` (n + 1 stages P) or ``"Q"`` (n - 1 stages P).
    g: int = 1  #: +1 or -1, the second entry of G.
    #: ``"q"``, ``"p"``, ``"qp"`` or ``""``: whose first starting value is asked to vanish.
    starts: str = ""
    #: Exact expressions for some of the unknowns.
    fixed: Mapping[str, str] = field(default_factory=dict)
    title: str = ""  #: One line for the file.

    def __post_init__(self) -> None:
        if not 2 <= self.n <= 40:
            raise UsageError(f"`n` must lie between 2 and 40, got {self.n}")
        if self.order not in (2, 4, 6, 8):
            raise UsageError(f"`order` must be 2, 4, 6 or 8, got {shown(self.order)}")
        for key, allowed in (("outer", "PQ"), ("g", (1, -1)), ("starts", STARTS)):
            if getattr(self, key) not in allowed:
                raise UsageError(f"`{key}` must be one of {', '.join(map(str, allowed))}")

    @property
    def stages(self) -> str:
        """The word of the stages."""
        inner = "Q" if self.outer == "P" else "P"
        outer = self.n + 1 if self.outer == "P" else self.n
        return (self.outer + inner) * (outer - 1) + self.outer

    def _row(self, name: str, parity: int) -> list[str]:
        return mirrored(name, self.stages.count("P" if name in "bw" else "Q"), parity)

    def equations(self) -> list[str]:
        """Return names of the equations, see :mod:`glmref.judge.enclosed_pair`."""
        orders = range(3, self.order, 2)
        trees = [t for n in orders for t in one_of_each(n, nystrom=self.nystrom)]
        return [*(f"order {t}" for t in trees), "growth q -1", "growth p -1", *STARTS[self.starts]]

    def document(self) -> dict[str, Any]:
        """Return the method document: entries, unknowns (their values empty), equations.

        Raises
        ------
        UsageError
            When a fixed name is not in the ansatz.
        """
        rows = {name: self._row(name, 1 if name in "bc" else -1) for name in "bwcv"}
        names = [x for row in rows.values() for x in dict.fromkeys(row) if x[0].isalpha()]
        for name in self.fixed:
            if name not in names:
                raise UsageError(f"`fixed` names {name!r}, and the ansatz has {', '.join(names)}")
        constants = dict(self.fixed)
        for name in "bc":
            free = [x for x in dict.fromkeys(rows[name]) if x not in self.fixed]
            if free:
                constants[free[-1]] = remainder(free[-1], rows[name])
        signs = [["1", "0"], ["0", "-1"]]
        claims = (
            {"order": 4, "nystrom-order": self.order} if self.nystrom else {"order": self.order}
        )
        return {
            "format": "glmref-method-1",
            "name": self.name,
            "title": self.title,
            "class": "pair-sweep",
            "constants": constants,
            "unknowns": {x: "" for x in names if x not in constants},
            "stages": self.stages,
            "b": rows["b"],
            "w": [rows["w"]],
            "c": rows["c"],
            "v": [rows["v"]],
            "V": signs,
            "V_hat": signs,
            "G": ["1", str(self.g)],
            "enclosure": {"equations": self.equations(), "radius": "1e-60"},
            "claims": claims,
        }


def complete_pair(
    ansatz: PairAnsatz,
    start: Sequence[str | float],
    *,
    source: Mapping[str, Any],
    claims: Mapping[str, Any] | None = None,
    notes: Sequence[str] = (),
) -> tuple[dict[str, Any], Enclosure]:
    """Polish, prove and complete one pair of as many unknowns as equations.

    ``start`` holds about ten digits of each unknown, in the order of the document; ``claims`` are
    those besides the usual ones, or instead of them.

    Raises
    ------
    ConvergenceError, ExactnessError
        When the start leads to no root, or the proof fails.
    """
    document = ansatz.document()
    values = [Exact(Fraction(str(x))) for x in start]
    document = fill(document, polish(conditions_of(document).residuals, values))
    enclosure = prove(document)
    orders: dict[str, Any] = dict(document["claims"])
    if enclosure.identity:
        orders["order-identity"] = orders["order"]
    document["claims"] = {
        **orders,
        # odd orders vanish by symmetry, and order 2 where both starts are equations
        "starting-order": 3 if ansatz.starts == "qp" else 1,
        **SYMMETRIC,
        "explicit": True,
        "growth": ["0", "0"],
        "reducible": False,
        **(claims or {}),
    }
    document["source"] = dict(source)
    if notes:
        document["notes"] = list(notes)
    return document, enclosure


def search_pairs(
    ansatz: PairAnsatz,
    *,
    seed: int,
    starts: int,
    first: int = 0,
    iterations: int = 200,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[Found]:
    """Solve the equations from random starts, reproducibly (:func:`glmref.derive.search.search`).

    A start has weights of both signs and couplings scaled so that ``sum b_i w_i^2 = sum c_j v_j^2 =
    0`` nearly holds: with positive weights only w = v = 0 would, which is a splitting method and a
    singular point of the equations.
    """
    import numpy as np

    from .search import search

    document = ansatz.document()
    gaps, equations = gaps_of(document), conditions_of(document).equations
    names = list(document["unknowns"])
    rows = {"b": document["b"], "c": document["c"]}
    # R(T) is of the size of 1 / gamma(T): without weights high orders would hardly count
    weights = [gamma(e[1]) if e[0] == "order" else 1 for e in equations]

    def weighted(values: Sequence[Any]) -> list[Any]:
        return [x * w for x, w in zip(gaps(values), weights, strict=True)]

    def draw(generator: np.random.Generator) -> np.ndarray:
        values: dict[str, float] = {}
        for weight, coupling in (("b", "w"), ("c", "v")):
            size = len(rows[weight])
            for x in dict.fromkeys(rows[weight]):
                values[x] = 1 / size + generator.normal() * float(generator.choice([0.1, 0.35]))
            for i in range(size // 2):
                values[f"{coupling}{i + 1}"] = generator.normal()
            _balance(values, weight, coupling, size)
        return np.array([values[x] for x in names])

    return search(
        weighted,
        draw,
        seed=seed,
        starts=starts,
        first=first,
        iterations=iterations,
        progress=progress,
    )


def _balance(values: dict[str, float], weight: str, coupling: str, size: int) -> None:
    """Scale the couplings so that positive and negative weights balance in sum b_i w_i^2."""
    parts = {1: 0.0, -1: 0.0}
    signs = {i: 1 if values[f"{weight}{i + 1}"] > 0 else -1 for i in range(size // 2)}
    for i, sign in signs.items():
        parts[sign] += abs(values[f"{weight}{i + 1}"]) * values[f"{coupling}{i + 1}"] ** 2
    if min(parts.values()) <= 0:
        return
    ratio = min((parts[1] / parts[-1]) ** 0.25, 3.0)
    for i, sign in signs.items():
        values[f"{coupling}{i + 1}"] *= ratio if sign < 0 else 1 / ratio
