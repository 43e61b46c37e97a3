"""From a document of a pair to its square system of equations.

Read are the classes ``pair-sweep`` and ``splitting`` (the case r = r^ = 1). The file names its
unknowns and its equations:

    order T         R(T) = 0 for the two-coloured tree T (:mod:`glmref.prove.partitioned_series`)
    growth q Z      mu_q = 0 at the eigenvalue Z of V (theorem in :mod:`.partitioned_sweep`)
    growth p Z      mu_p = 0
    start T K       zeta_K(T) = 0: value K has no term at T in its starting series
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

from ..catalogue.claims import NYSTROM_ORDER, ORDER, ORDER_IDENTITY
from ..errors import DataError
from ..exact import Exact, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..method import as_matrix
from ..method.partitioned_sweep import columns, stage_word
from ..theory.trees import SEPARABLE, Tree, parse_tree, trees_up_to
from .partitioned_series import PairNumbers, PairSeries, pair_series
from .partitioned_trees import (
    SPLITTING,
    VERLET_F,
    VERLET_K,
    free_tree,
    listed,
    representatives,
    spans,
)
from .system import Affine

__all__ = ["PairEquation", "PairSystem"]

_EQUATION = re.compile(
    r"order (?P<tree>\S+)|growth (?P<half>[qp]) (?P<eigenvalue>.+)|"
    r"start (?P<start>\S+) (?P<value>[1-9]\d?)"
)


@dataclass(frozen=True)
class PairEquation:
    """One named equation: ``tree`` for order and start, ``half`` and ``eigenvalue`` for growth."""

    text: str
    kind: str
    tree: Tree | None = None
    value: int = 0
    half: str = ""
    eigenvalue: str = ""

    @classmethod
    def read(cls, text: str) -> PairEquation:
        """Read the name of an equation.

        Raises
        ------
            DataError: for a name that has no meaning.
        """
        match = _EQUATION.fullmatch(text)
        if match is None:
            raise DataError(
                f"the equation {text!r} is unknown; write 'order f[kk]', 'growth q -1', "
                f"'growth p -1' or 'start f[k] 2'"
            )
        if match["half"]:
            return cls(text, "growth", half=match["half"], eigenvalue=match["eigenvalue"])
        name = match["tree"] or match["start"]
        found = parse_tree(name)
        if found not in trees_up_to(found.order, SEPARABLE):
            raise DataError(f"{text!r} must name a tree whose colours f and k alternate")
        if match["tree"]:
            return cls(text, "order", found)
        return cls(text, "start", found, int(match["value"]) - 1)


class PairSystem:
    """The equations of a document of class ``pair-sweep`` or ``splitting``.

    Raises
    ------
        DataError: for a document that is not of these classes or names unknown equations.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.document = document
        kind = document.get("class")
        if kind not in ("pair-sweep", "splitting"):
            raise DataError(
                f"only files of class 'pair-sweep' and 'splitting' are solved for as pairs, "
                f"got {kind!r}"
            )
        self.is_splitting = kind == "splitting"
        block = document.get("enclosure", {})
        self.unknowns = tuple(document.get("unknowns", {}))
        self.equations = tuple(PairEquation.read(x) for x in block.get("equations", ()))
        self.principal = {parse_tree(t): x for t, x in block.get("xi", {}).items()}
        claims = document.get("claims", {})
        self.claimed = max((claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key)), default=0)
        self.claimed_nystrom = claims.get(NYSTROM_ORDER.key, 0)
        one = ((Exact(1),),)
        if self.is_splitting:
            self.V, self.V_hat, self.G = one, one, one
        else:
            self.V, self.V_hat, self.G = (
                as_matrix(self._matrix(x), x) for x in ("V", "V_hat", "G")
            )
        self.names = ("a", "b") if self.is_splitting else ("b", "c")
        n_P, n_Q = (len(document[x]) for x in self.names)
        self.word = stage_word(self._word(n_P, n_Q), n_P, n_Q)
        self._check()

    def _matrix(self, name: str) -> Any:
        rows = self.document[name]
        if all(isinstance(x, str) for x in rows):  # a form given by its diagonal
            return [[x if i == j else "0" for j in range(len(rows))] for i, x in enumerate(rows)]
        return rows

    def _word(self, n_P: int, n_Q: int) -> str:
        if not self.is_splitting:
            return self.document["stages"]
        letters = "PQ" if self.document["first"] == "q" else "QP"
        return (letters * max(n_P, n_Q))[: n_P + n_Q]

    def _check(self) -> None:
        """V = 1 + V_2, G = 1 + G_2 and so on, and V^T G V^ = G: what the theorems ask for."""
        for name, matrix in (("V", self.V), ("V_hat", self.V_hat), ("G", self.G)):
            border = [x for row in matrix[1:] for x in row[:1]] + list(matrix[0][1:])
            if matrix[0][0] != 1 or any(not x.is_zero() for x in border):
                raise DataError(f"the first row and column of `{name}` must be 1, 0, ..., 0")
        kept = linalg.sub(linalg.matmul(linalg.transpose(self.V), self.G, self.V_hat), self.G)
        if any(not x.is_zero() for _, _, x in linalg.entries(kept)):
            raise DataError("`V` and `V_hat` must preserve `G`: V^T G V^ = G")

    @property
    def is_one_step(self) -> bool:
        """Whether one value of q and one of p is carried."""
        return len(self.V) == len(self.V_hat) == 1

    @property
    def nystrom(self) -> bool:
        """Whether the equations are those of second-order systems: more is claimed for these."""
        return self.claimed_nystrom > self.claimed

    @property
    def order(self) -> int:
        """Order up to which series are needed by the equations."""
        return max(
            (e.tree.order + (e.kind == "start") for e in self.equations if e.tree), default=1
        )

    def read(self, values: Mapping[str, Any]) -> tuple[PairNumbers, dict[Tree, Any]]:
        """Evaluate b, X, c, Y and the free principal parts at given values of the unknowns."""
        constants: dict[str, Any] = dict(values)
        for name, text in self.document.get("constants", {}).items():
            constants[name] = parse(text, constants=constants)

        def row(texts: Sequence[str]) -> tuple[Any, ...]:
            return tuple(parse(x, constants=constants) for x in texts)

        b, c = (row(self.document[x]) for x in self.names)
        rest = [[], []] if self.is_splitting else [self.document.get(x, []) for x in ("w", "v")]
        X, Y = (
            columns([row(x) for x in rows], len(weights))
            for rows, weights in zip(rest, (b, c), strict=True)
        )
        numbers = PairNumbers(b, X, c, Y, self.V, self.V_hat, self.G, self.word)
        return numbers, {t: row([x])[0] for t, x in self.principal.items()}

    def series(
        self, numbers: PairNumbers, principal: Mapping[Tree, Any], order: int, **more: Any
    ) -> PairSeries:
        """Starting series and residuals; principal parts zero where the equations prove it."""
        more.setdefault("nystrom", self.nystrom)
        identity = self.identity_through(order - 1, nystrom=more["nystrom"])
        return pair_series(numbers, order, principal, identity=identity, **more)

    def residuals(self, values: Sequence[Any]) -> list[Any]:
        """Left minus right side of every equation, in the order of the file."""
        numbers, principal = self.read(dict(zip(self.unknowns, values, strict=True)))
        order = self.order
        wanted = [e.tree for e in self.equations if e.kind == "order" and e.tree]
        series = self.series(numbers, principal, order, wanted=wanted)
        return [self._residual(e, numbers, series) for e in self.equations]

    def _residual(self, e: PairEquation, numbers: PairNumbers, series: PairSeries) -> Any:
        if e.kind == "growth":
            return self.growth(e.half, e.eigenvalue, numbers)
        assert e.tree is not None
        if e.kind == "order":
            return series.residual[e.tree]
        return series.zeta[e.tree][e.value]

    @cached_property
    def _eigenvectors(self) -> dict[tuple[str, str], tuple[Matrix, Any]]:
        return {}

    def eigenvector(self, half: str, text: str) -> tuple[Matrix, Any]:
        """G v^ (for q; G^T v for p), real and imaginary part, and the norm n of the theorem.

        Raises
        ------
            DataError: when ``text`` is no simple eigenvalue of V and V^.
        """
        key = (half, text)
        if key not in self._eigenvectors:
            z, found = parse(text), []
            for V in (self.V, self.V_hat):
                shifted = linalg.sub(V, linalg.scale(z, linalg.identity(len(V))))
                basis = linalg.nullspace(shifted)
                if len(basis) != 1:
                    raise DataError(f"'growth {half} {text}' must name a simple eigenvalue of V")
                found.append(basis[0])
            v, v_hat = found
            norm = linalg.dot([x.conjugate() for x in v], linalg.matvec(self.G, v_hat)).conjugate()
            seen = (
                linalg.matvec(self.G, v_hat)
                if half == "q"
                else linalg.matvec(linalg.transpose(self.G), v)
            )
            parts = (tuple(x.real for x in seen), tuple(x.imag for x in seen))
            self._eigenvectors[key] = (parts, norm if half == "q" else norm.conjugate())
        return self._eigenvectors[key]

    def growth(self, half: str, text: str, numbers: PairNumbers) -> Any:
        """Coupled growth parameter of a half, by the theorem of :mod:`.partitioned_sweep`."""
        parts, norm = self.eigenvector(half, text)
        weights, matrix = (numbers.b, numbers.X) if half == "q" else (numbers.c, numbers.Y)
        total: Any = Exact(0)
        for d, column in zip(weights, linalg.transpose(matrix), strict=True):
            for part in parts:
                along = linalg.dot(column, part)
                total = total + d * along * along
        return total / norm

    # -- what holds for all values of the unknowns -------------------------------------------------

    @cached_property
    def _affine(self) -> PairNumbers:
        return self.read({name: Affine.unknown(name) for name in self.unknowns})[0]

    def signs(self) -> tuple[tuple[int, ...], tuple[int, ...]] | None:
        """Diagonals of E and E^ with X = E X P_P and Y = E^ Y P_Q for all values of the unknowns.

        ``None`` where the stages, the weights or the columns are not palindromic, or where E and E^
        do not fit G, V and V^: then the symmetry theorem of :mod:`.partitioned_sweep` says nothing.
        """
        word = [letter for letter, _ in self.word]
        p = self._affine
        if word != word[::-1] or not all(_palindromic(x) == 1 for x in (p.b, p.c)):
            return None
        signs = []
        for rows in (p.X, p.Y):
            found = [_palindromic(row) for row in rows]
            if None in found:
                return None
            signs.append(tuple(x for x in found if x is not None))
        E, E_hat = (linalg.diagonal([Exact(x) for x in s]) for s in signs)
        checks = [linalg.sub(linalg.matmul(E, self.G, E_hat), self.G)]
        for e, V in ((E, self.V), (E_hat, self.V_hat)):
            checks.append(linalg.sub(linalg.matmul(e, linalg.inverse(V), e), V))
        if any(not x.is_zero() for m in checks for _, _, x in linalg.entries(m)):
            return None
        return signs[0], signs[1]

    def identity_through(self, order: int, *, nystrom: bool = False) -> bool:
        """Whether all principal parts of order <= ``order`` are zero by the equations ``start``.

        By theorem 2 of :mod:`.pair_series` they are where ``zeta_k(t) G_kl zeta^_l(u) = 0`` for all
        k, l > 1 and |t| + |u| <= order. By symmetry zeta_k vanishes at odd trees where L keeps
        value k, and at even trees where L changes its sign; elsewhere an equation must say so.
        """
        if self.is_one_step or order < 2:
            return True
        signs = self.signs()
        if signs is None or self.principal:
            return False
        zero = {(e.tree, e.value) for e in self.equations if e.kind == "start"}
        L, L_hat = (
            linalg.matmul(linalg.inverse(V), linalg.diagonal([Exact(x) for x in s]))
            for V, s in ((self.V, signs[0]), (self.V_hat, signs[1]))
        )

        def vanishes(t: Tree, k: int, involution: Matrix) -> bool:
            if (t, k) in zero:
                return True
            off = any(not involution[k][j].is_zero() for j in range(len(involution)) if j != k)
            return not off and involution[k][k] == (-1) ** (t.order + 1)

        by_order = [t for n in range(1, order) for t in listed(n, nystrom=nystrom)]
        for t in (t for t in by_order if t.colour == "f"):
            for u in (u for u in by_order if u.colour == "k" and t.order + u.order <= order):
                for k in range(1, len(self.G)):
                    for l in range(1, len(self.G[0])):
                        if self.G[k][l].is_zero():
                            continue
                        if not vanishes(t, k, L) and not vanishes(u, l, L_hat):
                            return False
        return True

    def kind_of_flow(self) -> str | None:
        """Which Lie algebra the logarithm lies in (see :mod:`.pair_trees`); ``None`` for r > 1."""
        if not self.is_one_step:
            return None
        letters = "".join(letter for letter, _ in self.word)
        p = self._affine
        for outer, inner, kind, pattern in (
            (p.b, p.c, VERLET_F, "PQ"),
            (p.c, p.b, VERLET_K, "QP"),
        ):
            if letters != pattern * len(inner) + pattern[0]:
                continue
            steps = [Exact(0), *inner, Exact(0)]
            sums = [Affine.of(x) + y for x, y in pairwise(steps)]
            if all(
                (2 * Affine.of(x) - y).is_identically_zero()
                for x, y in zip(outer, sums, strict=True)
            ):
                return kind
        return SPLITTING

    def covered(self, order: int, *, nystrom: bool = False) -> bool:
        """Whether the equations give all conditions of an odd order, by the theorems.

        Args:
            nystrom: whether only those of second-order systems are meant.
        """
        given = {e.tree for e in self.equations if e.kind == "order" and e.tree}
        if order == 1:
            for root, weights in (("f", self._affine.b), ("k", self._affine.c)):
                if (sum(weights[1:], Affine.of(weights[0])) - 1).is_identically_zero():
                    given.add(parse_tree(root))
        kind = self.kind_of_flow()
        if kind is not None:
            return spans(order, given, kind, nystrom=nystrom)
        needed = representatives(order, nystrom=nystrom)
        return all(not given.isdisjoint(free_tree(t)) for t in needed)


def _palindromic(row: Sequence[Any]) -> int | None:
    """+1 or -1 where a row of affine expressions is its own mirror image up to this sign."""
    pairs = [(Affine.of(x), Affine.of(y)) for x, y in zip(row, row[::-1], strict=True)]
    for sign in (1, -1):
        if all((x - sign * y).is_identically_zero() for x, y in pairs):
            return sign
    return None
