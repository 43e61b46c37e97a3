"""What every method is made of: k components, coupled by the colours of their right-hand sides.

A component is one right-hand side f_c with the block (A, U, B, V) that it drives::

    X^c = h A F^c + U x^c        x^c+ = h B F^c + V x^c        F^c_j = f_c at stage j

The *colour* c of a component is the root of the trees that belong to it, and the *palette* says at
which stages f_c is evaluated: at those of the components named ``palette[c]``, which are also the
colours that the children of a vertex c may have. So

* a general linear method has one component ``o`` with the palette ``{"o": "o"}``;
* a partitioned method for q' = f(q, p), p' = k(q, p) has two, ``f`` and ``k``, with all colours
  below each; on separable systems, q' = f(p), p' = k(q), colours alternate and the stages Q (of the
  component f) and P (of k) are two sets;
* an additive method for y' = f_1(y) + .. + f_k(y) has k components with all colours below each,
  and they share their values and stages: U and V are the same, and ``Y = U y + h sum A^c F^c``. In
  the series of trees this is the partitioned method for y = y^1 + .. + y^k; no condition differs.

Starting and finishing methods are of the same kind, with one value going in or coming out.

References
----------
Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), section III.2; Araujo, Murua,
Sanz-Serna, "Symplectic methods based on decompositions", SIAM J. Numer. Anal. 34 (1997), 1926-1947;
Sandu, Günther, "A generalized-structure approach to additive Runge-Kutta methods", SIAM J. Numer.
Anal. 53 (2015), 17-42.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..exact import Exact
from ..exact.linalg import Matrix, Vector

#: Colours with the colours that children of a vertex may have.
Palette = Mapping[str, str]

ROOTED: Palette = MappingProxyType({"o": "o"})
GENERAL: Palette = MappingProxyType({"f": "fk", "k": "fk"})
SEPARABLE: Palette = MappingProxyType({"f": "k", "k": "f"})


def additive_palette(k: int) -> Palette:
    """Return the palette of an additive method of k parts: the digits 1 to k, each below each."""
    colours = "123456789"[:k]
    return MappingProxyType(dict.fromkeys(colours, colours))


@dataclass(frozen=True, eq=False)
class Component:
    """One right-hand side of a method with its block."""

    colour: str  #: Root of the trees that belong to it.
    A: Matrix  #: (n, m) stages from slopes.
    U: Matrix  #: (n, r) stages from values.
    B: Matrix  #: (r', m) values from slopes.
    #: (r', r) values from values. In a method r' = r; a start makes r' values of one, a finish one
    #: of one.
    V: Matrix
    #: (r,) functional that reads the solution off the values, ``None`` where the method says
    #: nothing: see :mod:`glmref.method.preconsistency`.
    output: Vector | None = None

    @property
    def matrices(self) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        """A, U, B and V."""
        return self.A, self.U, self.B, self.V

    @property
    def is_exact(self) -> bool:
        """Whether every coefficient is exact (no published decimal among them)."""
        return all(isinstance(x, Exact) for m in self.matrices for row in m for x in row)
