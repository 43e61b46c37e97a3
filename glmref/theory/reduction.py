"""Whether a method carries values it could do without: reachable and observable values.

A component is a linear machine with the slopes as inputs, the values as state and the stages as
outputs: for q of a partitioned method, f(P), q (r values) and Q.
Values outside the span of u and of the columns of B, V B, V^2 B, .. stay zero once the
start leaves them zero (*never reached*); values in the common kernel of U, U V, U V^2, .. never
enter a stage (*never seen*). A machine all of whose values are reached and seen is minimal, and
minimal machines with the same answers have equally many values (Kalman 1963). So a pair in which
every value is reached and seen is not a partitioned Runge-Kutta method in disguise, however many
stages that may have; one that is carries one value of each component.

References
----------
    Kalman, "Mathematical description of linear dynamical systems", J. SIAM Control 1 (1963),
    152-192; Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 503.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..exact import Exact, linalg
from ..exact.judging import consulted, inward, outward
from ..exact.linalg import Matrix
from ..method import Method, PartitionedGLM
from ..method.preconsistency import Block, preconsistency_vector
from .judged import judged_component


@dataclass(frozen=True)
class Reduction:
    """Which values of a method are needed."""

    #: Whether some value is never reached or never seen; ``None`` where balls leave the ranks open.
    reducible: bool | None
    #: Dimensions for each component.
    reached: tuple[int, ...]
    seen: tuple[int, ...]
    witness: str = ""  #: One sentence naming what can be left out, or ``""``.


def reached_rows(m: Block) -> Matrix:
    """Return rows that span the values a run can reach from the solution."""
    with consulted() as judge:
        u = preconsistency_vector(m)
        return outward(judge.rules_structure.reached_rows(judged_component(m), inward(u)))


def observed_rows(m: Block) -> Matrix:
    """Return rows U, U V, U V^2, ..: what the stages see of the values."""
    with consulted() as judge:
        return outward(judge.rules_structure.seen_rows(judged_component(m)))


#: What the values of a component are called, by its colour.
_NAMES = {"o": "", "f": " of q", "k": " of p"}


def reduction(m: Method) -> Reduction:
    """Count the values that are reached and seen, in every component."""
    reached, seen, faults, certain = [], [], [], False
    for c in m.components:
        r, whose = len(c.V), _NAMES.get(c.colour, f" of part {c.colour}")
        for what, rows, found in (
            ("reached", reached_rows(c), reached),
            ("seen by a stage", observed_rows(c), seen),
        ):
            found.append(len(linalg.independent_rows(rows, r)))
            if found[-1] < r:
                faults.append(f"{found[-1]} of the {r} values{whose} are ever {what}")
                certain = certain or all(isinstance(x, Exact) for row in rows for x in row)
    reducible = certain if certain or not faults else None
    witness = "only " + "; ".join(faults) if faults else ""
    return Reduction(reducible, tuple(reached), tuple(seen), witness)


def without_idle_stages(m: PartitionedGLM) -> PartitionedGLM | None:
    """Return a separable pair without the stages whose slopes are not used.

    A stage Q of the first part gives the slope that the columns of A^ and B^ multiply, a stage P
    that of A and B. ``None`` where the system is not separable, or every slope is used.
    """
    if not m.separable:
        return None
    q, p = m.components
    read, n = sorted(m.read_stages()), len(q.A)  # those of Q come first
    kept = [[i for i in read if i < n], [i - n for i in read if i >= n]]
    if len(read) == n + len(p.A) or not all(kept):
        return None
    blocks = [
        (tuple(tuple(c.A[i][j] for j in kept[1 - n]) for i in kept[n]),
         tuple(c.U[i] for i in kept[n]),
         tuple(tuple(row[j] for j in kept[1 - n]) for row in c.B), c.V)
        for n, c in enumerate((q, p))
    ]  # fmt: skip
    return PartitionedGLM(*blocks[0], *blocks[1], name=m.name, separable=True)
