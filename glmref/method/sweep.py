"""The sweep form: G-symplectic methods of k components, from the few numbers that are free.

A method of this form has for each component c the weights ``D_c`` (n_c numbers), the columns
``X_c`` (r_c, n_c) and ``V_c`` (r_c, r_c); one matrix G; and an order of all stages. With one
component, y' = f(y), G is (r, r) and Hermitian and the stages stand in their order. With two, q' =
f(p) and p' = k(q) (a separable system), G is (r, r^) and pairs the values of q with those of p; at
a stage P the function f is evaluated, at a stage Q the function k, and their order is a word such
as ``PQP``. Write d for the component whose values the stages of c read (c itself, or the other one)
and ``G_dc`` for G or G^*, whichever has r_d rows and r_c columns. Then

    B_c = X_c diag(D_c)      U_c = X_d^* G_dc V_c      (A_c)_ji = D_ci (X_d^* G_dc X_c)_ji

where stage i of c comes before stage j of d; half of it where they are the same stage (one
component only); and 0 where it comes after. One step needs neither A nor U::

    w = V y                                  q <- V q;  p <- V^ p
    for i = 1..s:                            letter by letter:
        L = h f(x_i^* G (w + d_i x_i L/2))       P:  q += h b_i x_i f(x_i^* G p)
        w += d_i x_i L                           Q:  p += h c_j y_j k(y_j^* G^* q)
    y+ = w

with x_i, y_j the columns of X and of Y = X^. A pair in this form is explicit; a splitting method of
T(p) + V(q) is r = r^ = 1, X and Y ones, V = V^ = G = 1.

**Theorem (G-symplectic by construction).** If ``V_d^* G_dc V_c = G_dc`` and the weights are real,
the method is G-symplectic with G and the D_c, whatever X and D are.  Proof: write S = X_d^* G_dc
X_c. ``D_d U_c = B_d^* G_dc V_c``. ``D_d A_c + A_d^* D_c`` has at (j, i) the number D_dj D_ci S_ji:
of stage i of c and stage j of d exactly one comes first, or they are one stage and both terms are
a half; and that is ``(B_d^* G_dc B_c)_ji``. Conversely a G-symplectic method whose stages have an
order in which each needs those before it (and itself, with a real diagonal of A), with nonsingular
real D_c, has this form: the identities, solved for U and A, are the definitions above, and leave
open only the imaginary part of the diagonal.

**Theorem (symmetric by construction).** Let the order of the stages read the same backwards, let
P_c reverse the stages of c and let E_c = diag(+-1). If ``P_c D_c P_c = D_c``, ``X_c = E_c X_c
P_c``, ``E_d G_dc E_c = G_dc``, ``E_c V_c^-1 E_c = V_c`` and ``V_d^* G_dc V_c = G_dc``, the method
is symmetric with the stage reversals P_c and the involutions L_c = V_c^-1 E_c, so that ``V_c L_c =
E_c``.  Proof: L^2 = V^-1 (E V^-1 E) = I and L V^-1 L = V^-1 (E V^-2 E) = V^-1 V^2 = V. ``B = V L B
P`` is ``X D = E X D P``. ``U_c = P_d U_c L_c V_c``: since L V = V^-1 E V = V^-2 E, the right side
is ``P_d X_d^* G_dc V_c^-1 E_c = P_d X_d^* G_dc E_c V_c = X_d^* G_dc V_c``. ``A_c + P_d A_c P_c =
U_c V_c^-1 B_c``: S is unchanged when the stages of both are reversed, and reversal turns "before"
into "after", so that the left side is ``S D_c = X_d^* G_dc V_c V_c^-1 X_c D_c``.

**Theorem (growth parameters).** With the identities above, let ``V_c v_c = z v_c`` and ``V_d v_d =
z v_d``, |z| = 1, ``n = v_d^* G_dc v_c`` not 0.  Then ``v_d^* G_dc`` is a left eigenvector of V_c
(from V_d^* G_dc V_c = G_dc), and the growth parameter of c, ``z^-1 v_d^* G_dc B_c (U_d v_d) / n``,
is ``mu_c = sum_i D_ci |x_i^* G_cd v_d|^2 / n``, x_i the columns of X_c: z itself has cancelled. For
V = V^ = diag(1, -1), G = diag(1, g), X = (1, w), Y = (1, v) these are ``g sum b_i w_i^2`` and ``g
sum c_j v_j^2``: two conditions on b, w and c, v apart.

References
----------
    Khan (2018), equations (3.10) to (3.15); Butcher, Habib, Hill, Norton, "The control of
    parasitism in G-symplectic methods", SIAM J. Numer. Anal. 52 (2014), 2440-2465; Hairer, Lubich,
    Wanner, "Geometric Numerical Integration" (2006), theorem VI.4.6, for pairs with r = 1.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from ..errors import DataError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from .component import Component
from .glm import GLM, PartitionedGLM

_LONGEST_WORD = 400


@dataclass(frozen=True, eq=False)
class SweepForm:
    """The numbers of a method in the sweep form, over any scalar of :mod:`glmref.exact`."""

    D: Mapping[str, Sequence[Any]]  #: (n,) weights by colour.
    X: Mapping[str, Matrix]  #: (r, n) columns by colour.
    V: Mapping[str, Matrix]  #: (r, r) by colour.
    #: (r, r), of two components (r, r^): rows for the first colour, columns for the last.
    G: Matrix
    #: All stages in their order, each the colour evaluated there and its number from 0.
    word: Sequence[tuple[str, int]]
    #: Numbers (from 1) of the stages whose diagonal entry of A is known to be zero; it is then
    #: written as an exact zero, not as a ball around it.
    explicit: Collection[int] = ()

    def partner(self, colour: str) -> str:
        """Return the colour at whose stages the values of a component are read."""
        first, *_, last = (*self.D, *self.D)
        return last if colour == first else first

    def form(self, colour: str) -> Matrix:
        """Return G_dc: G with the values of the component as its columns."""
        return self.G if colour == (*self.D,)[-1] else linalg.conjugate_transpose(self.G)

    @cached_property
    def blocks(self) -> tuple[Component, ...]:
        """A, U, B and V of every component."""
        return tuple(self._component(colour) for colour in self.D)

    def _component(self, colour: str) -> Component:
        other = self.partner(colour)
        place = {stage: at for at, stage in enumerate(self.word)}
        reads = linalg.matmul(linalg.conjugate_transpose(self.X[other]), self.form(colour))
        updates = linalg.transpose(self.X[colour])

        def entry(j: int, i: int) -> Any:
            before, at = place[colour, i], place[other, j]
            if before > at or (before == at and i + 1 in self.explicit):
                return Exact(0)
            found = linalg.dot(reads[j], updates[i]) * self.D[colour][i]
            return found * Fraction(1, 2) if before == at else found

        A = tuple(tuple(entry(j, i) for i in range(len(updates))) for j in range(len(reads)))
        U = linalg.matmul(reads, self.V[colour])
        B = tuple(
            tuple(x * d for x, d in zip(row, self.D[colour], strict=True)) for row in self.X[colour]
        )
        return Component(colour, A, U, B, self.V[colour])

    def check_preserved(self) -> None:
        """Check ``V_d^* G V_c = G``, what makes the form G-symplectic.

        Raises
        ------
        DataError
            Naming the first entry that differs.
        """
        first, *_, last = (*self.V.values(), *self.V.values())
        kept = linalg.sub(linalg.matmul(linalg.conjugate_transpose(first), self.G, last), self.G)
        for i, j, x in linalg.entries(kept):
            if x.is_zero() is not True:
                names, hat = ("`V` and `V_hat`", "^") if len(self.V) > 1 else ("`V`", "")
                raise DataError(
                    f"{names} must preserve `G` exactly, but V^* G V{hat} - G is "
                    f"{complex(x):.3g} at ({i + 1}, {j + 1}); the sweep form is G-symplectic only "
                    f"then"
                )


def explicit_stages(enclosure: object, s: int) -> frozenset[int]:
    """Return stages (from 1) whose diagonal entry is 0 by an equation ``explicit I`` of the file.

    The pattern of such a file is palindromic, so that stage ``s + 1 - I`` is explicit as well.
    """
    equations = enclosure.get("equations", ()) if isinstance(enclosure, Mapping) else ()
    names = (str(x) for x in equations) if isinstance(equations, list | tuple) else ()
    stages = {int(x.split()[1]) for x in names if re.fullmatch(r"explicit \d{1,3}", x)}
    return frozenset(stages | {s + 1 - i for i in stages})


def columns(rows: Sequence[Sequence[Any]], size: int) -> Matrix:
    """Return X (or Y) from its rows 2..r: a first row of ones is put on top."""
    return ((Exact(1),) * size, *(tuple(row) for row in rows))


def stage_word(text: str, n_P: int, n_Q: int) -> tuple[tuple[str, int], ...]:
    """Return the stages of a pair in their order: colour evaluated (f at P, k at Q) and number.

    Raises
    ------
    DataError
        When the word has other letters, or not n_P times P and n_Q times Q.
    """
    if len(text) > _LONGEST_WORD or not re.fullmatch(r"[PQ]+", text):
        raise DataError("`stages` must be a word in the letters P and Q, such as 'PQP'")
    if (text.count("P"), text.count("Q")) != (n_P, n_Q):
        raise DataError(
            f"`stages` must have one P for each of the {n_P} entries of `b` and one Q for each of "
            f"the {n_Q} entries of `c`, got {text.count('P')} and {text.count('Q')}"
        )
    colours = {"P": "f", "Q": "k"}
    return tuple((colours[x], text[:at].count(x)) for at, x in enumerate(text))


def _check_shapes(shapes: Mapping[str, tuple[Matrix, tuple[int, int]]], hint: str = "") -> None:
    for name, (matrix, shape) in shapes.items():
        if (len(matrix), len(matrix[0])) != shape:
            raise DataError(
                f"`{name}` must have shape {shape}, got ({len(matrix)}, {len(matrix[0])}){hint}"
            )


def build(
    D: Vector,
    X: Matrix,
    V: Matrix,
    G: Matrix,
    *,
    explicit: Collection[int] = (),
) -> GLM:
    """Build the method of a data file of class ``"sweep"``, with its G and D.

    Parameters
    ----------
    D : Vector
        (s,).
    X : Matrix
        (r, s).
    V : Matrix
        (r, r).
    G : Matrix
        (r, r) Hermitian.
    explicit : Collection[int]
        See :class:`SweepForm`.

    Raises
    ------
    DataError
        For a wrong shape, or when V does not preserve G.
    """
    r, s = len(X), len(D)
    _check_shapes({"X": (X, (r, s)), "V": (V, (r, r)), "G": (G, (r, r))})
    form = SweepForm({"o": D}, {"o": X}, {"o": V}, G, [("o", i) for i in range(s)], explicit)
    form.check_preserved()
    (block,) = form.blocks
    return GLM(A=block.A, U=block.U, B=block.B, V=V, G=G, D=D)


def build_partitioned(
    b: Vector,
    c: Vector,
    *,
    w: Matrix = (),
    v: Matrix = (),
    V: Matrix,
    V_hat: Matrix,
    G: Matrix,
    stages: str,
) -> PartitionedGLM:
    """Build the method of a data file of class ``"pair-sweep"``, with its G, D_P and D_Q.

    Args:
        b: (n_P,) and c: (n_Q,) weights. w: (r - 1, n_P) rows 2..r of X. v: (r^ - 1, n_Q) rows
        2..r^ of Y. V, V_hat, G: as in the module docstring. stages: their order, such as "PQP".

    Raises
    ------
    DataError
        For a wrong shape, or when V and V^ do not preserve G.
    """
    r, r_hat = len(w) + 1, len(v) + 1
    _check_shapes(
        {
            "w": (w or ((),), (r - 1, len(b)) if w else (1, 0)),
            "v": (v or ((),), (r_hat - 1, len(c)) if v else (1, 0)),
            "V": (V, (r, r)),
            "V_hat": (V_hat, (r_hat, r_hat)),
            "G": (G, (r, r_hat)),
        },
        "; `w` and `v` have one row for each value carried beyond the first",
    )
    form = SweepForm(
        {"f": b, "k": c},
        {"f": columns(w, len(b)), "k": columns(v, len(c))},
        {"f": V, "k": V_hat},
        G,
        stage_word(stages, len(b), len(c)),
    )
    form.check_preserved()
    of_q, of_p = form.blocks
    return PartitionedGLM(
        A=of_q.A,
        U=of_q.U,
        B=of_q.B,
        V=V,
        A_hat=of_p.A,
        U_hat=of_p.U,
        B_hat=of_p.B,
        V_hat=V_hat,
        G=G,
        D_P=tuple(b),
        D_Q=tuple(c),
        separable=True,
    )
