"""From a method document of class ``"sweep"`` to its square system of equations.

The file names its unknowns and its equations; this module gives them their meaning. The equations
are

    order T             R(T) = 0 for the rooted tree T (:mod:`glmref.prove.equations`)
    growth Z            sum_i d_i |x_i^* G v|^2 / (v^* G v) = 0, v the eigenvector of V to Z
    explicit I          d_i (X^T G X)_ii / 2 = 0: stage I and its mirror image need no solve
    defect I            eta_I([o]) - eta_I(o)^2 / 2 = 0: stage I has stage order 2
    defect I [oo]       eta_I([oo]) - eta_I(o)^3 / 3 = 0: with the former, stage order 3
    abscissa I = Q      eta_I(o) = Q
    start K             zeta_K(o) = 0: value K starts as O(h^2)
    start K [o]         zeta_K([o]) = 0
    identity T          zeta_1(T) = 0: no conjugation at the even tree T
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from ..errors import DataError
from ..exact import Ball, Exact, ball, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..method import as_matrix
from ..method.sweep import explicit_stages, sweep_blocks
from ..theory.trees import Tree, parse_tree, single, tree
from .classes import reduce_tree
from .equations import Blocks, Series, starting_series

__all__ = ["Affine", "Equation", "SweepSystem"]

_EQUATION = re.compile(
    r"(?P<kind>order|growth|explicit|defect|abscissa|start|identity) "
    r"(?P<what>[^=]+?)(?: = (?P<value>.+))?"
)


class Affine:
    """An affine expression ``c_0 + sum c_i x_i`` in the unknowns, with exact coefficients.

    It lets an identity between entries of D and X be decided for *all* values of the unknowns.
    """

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Mapping[str, Exact]) -> None:
        self.coefficients = dict(coefficients)

    @classmethod
    def unknown(cls, name: str) -> Affine:
        """The unknown itself."""
        return cls({name: Exact(1)})

    @classmethod
    def of(cls, value: Any) -> Affine:
        """A constant, or an affine expression passed through."""
        return value if isinstance(value, Affine) else cls({"": Exact(0) + value})

    def __add__(self, other: Any) -> Affine:
        result = dict(self.coefficients)
        for name, value in Affine.of(other).coefficients.items():
            result[name] = result.get(name, Exact(0)) + value
        return Affine(result)

    __radd__ = __add__

    def __neg__(self) -> Affine:
        return Affine({name: -value for name, value in self.coefficients.items()})

    def __sub__(self, other: Any) -> Affine:
        return self + (-Affine.of(other))

    def __rsub__(self, other: Any) -> Affine:
        return (-self) + other

    def __mul__(self, other: Any) -> Affine:
        if isinstance(other, Affine):
            if not other._is_constant():
                if not self._is_constant():
                    raise DataError(
                        "`D` and `X` must be affine in the unknowns, and a product of two of them "
                        "stands there; give the product a name of its own"
                    )
                return other * self
            other = other.coefficients.get("", Exact(0))
        return Affine({name: value * other for name, value in self.coefficients.items()})

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Affine:
        if isinstance(other, Affine):
            if not other._is_constant():
                raise DataError("`D` and `X` must be affine in the unknowns; one is a divisor")
            other = other.coefficients.get("", Exact(0))
        return self * (Exact(1) / other)

    def __rtruediv__(self, other: Any) -> Affine:
        return Affine.of(other) / self

    def _is_constant(self) -> bool:
        return all(name == "" or value.is_zero() for name, value in self.coefficients.items())

    def is_identically_zero(self) -> bool:
        """Whether the expression vanishes for all values of the unknowns."""
        return all(value.is_zero() for value in self.coefficients.values())


@dataclass(frozen=True)
class Equation:
    """One named equation of a file."""

    text: str
    kind: str
    what: str
    value: str = "0"

    @classmethod
    def read(cls, text: str) -> Equation:
        """Read the name of an equation.

        Raises
        ------
            DataError: for a name that has no meaning.
        """
        match = _EQUATION.fullmatch(text)
        if match is None or (match["value"] is not None) != (match["kind"] == "abscissa"):
            raise DataError(
                f"the equation {text!r} is unknown; write 'order [oo]', 'growth -1', "
                f"'explicit 1', 'defect 1', 'start 2', 'identity [o]' or 'abscissa 1 = 1/3'"
            )
        return cls(text, match["kind"], match["what"], match["value"] or "0")


def defect_tree(equation: Equation) -> Tree:
    """The tree of an equation ``defect``: [o] where none is named."""
    return parse_tree(f"{equation.what} [o]".split()[1])


class SweepSystem:
    """The unknowns and equations of one document, evaluated over any scalar.

    Attributes
    ----------
        unknowns: names, in the order of the file.
        equations: the equations, in the order of the file.
        V, G: (r, r) exact.

    Raises
    ------
        DataError: for a document whose V, G or equations are not what the theorems ask for.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.document = document
        self.unknowns: tuple[str, ...] = tuple(document.get("unknowns", {}))
        enclosure = document.get("enclosure", {})
        self.equations = tuple(Equation.read(x) for x in enclosure.get("equations", ()))
        self.principal: Mapping[str, str] = enclosure.get("xi", {})
        self.V: Matrix = as_matrix(document["V"], "V")
        self.G: Matrix = as_matrix(document["G"], "G")
        self.s, self.r = len(document["D"]), len(self.V)
        self._check_blocks()

    def _check_blocks(self) -> None:
        for name, matrix in (("V", self.V), ("G", self.G)):
            for k in range(self.r):
                for i, j in ((0, k), (k, 0)):
                    if matrix[i][j] != (1 if i == j else 0):
                        raise DataError(
                            f"the first row and column of `{name}` must be 1, 0, ..., 0"
                        )
        preserved = linalg.matmul(linalg.transpose(self.V), self.G, self.V)
        if any(not x.is_zero() for _, _, x in linalg.entries(linalg.sub(preserved, self.G))):
            raise DataError(
                "`V` must preserve `G`: V^T G V = G is what makes the form G-symplectic"
            )

    def index(self, equation: Equation) -> int:
        """Stage (or value, for ``start``) of an equation, from 0.

        Raises
        ------
            DataError: when there is no such stage or value.
        """
        top, what = (self.r, "value") if equation.kind == "start" else (self.s, "stage")
        number = equation.what.split()[0]
        if not number.isdigit() or not 1 <= int(number) <= top:
            raise DataError(f"{equation.text!r} must name a {what} from 1 to {top}")
        return int(number) - 1

    @property
    def explicit(self) -> frozenset[int]:
        """Stages (from 1) whose diagonal entry is zero by an equation of the file, mirrored."""
        return explicit_stages(self.document.get("enclosure", {}), self.s)

    @property
    def order(self) -> int:
        """Order up to which series are needed by the equations."""
        orders = [parse_tree(e.what).order for e in self.equations if e.kind == "order"]
        inner = [parse_tree(e.what).order + 1 for e in self.equations if e.kind == "identity"]
        inner += [defect_tree(e).order + 1 for e in self.equations if e.kind == "defect"]
        return max(orders + inner, default=2)

    @cached_property
    def stage_order(self) -> int:
        """Stage order that the equations ``defect`` give: for the stages up to the middle suffice.

        The middle stage needs no equation for a tree of odd order (theorem 3 of
        :mod:`glmref.prove.equations`).
        """
        have = {(self.index(e), defect_tree(e)) for e in self.equations if e.kind == "defect"}
        q = 1
        while True:
            t = tree([single()] * q)
            half = self.s // 2 if t.order % 2 else (self.s + 1) // 2
            if not all((i, t) in have for i in range(half)):
                return q
            q += 1

    def read(self, values: Mapping[str, Any]) -> tuple[list[Any], Matrix, dict[Tree, Any]]:
        """Evaluate D, X and the free principal parts at given values of the unknowns."""
        constants: dict[str, Any] = dict(values)
        for name, text in self.document.get("constants", {}).items():
            constants[name] = parse(text, constants=constants)

        def entry(text: str) -> Any:
            return parse(text, constants=constants)

        D = [entry(x) for x in self.document["D"]]
        X = tuple(tuple(entry(x) for x in row) for row in self.document["X"])
        return D, X, {parse_tree(t): entry(x) for t, x in self.principal.items()}

    @cached_property
    def _balls(self) -> tuple[Matrix, Matrix]:
        """V and G with irrational entries as balls, converted once."""

        def convert(matrix: Matrix) -> Matrix:
            return tuple(tuple(_number(x) for x in row) for row in matrix)

        return convert(self.V), convert(self.G)

    def blocks(
        self, D: Sequence[Any], X: Matrix, *, explicit: frozenset[int] = frozenset()
    ) -> Blocks:
        """A, U, B, V and G from D and X."""
        V, G = self._balls
        A, U, B = sweep_blocks(D, X, V, G, explicit=explicit)
        return Blocks(A, U, B, V, G)

    def residuals(self, values: Sequence[Any]) -> list[Any]:
        """Left minus right side of every equation, in the order of the file."""
        D, X, principal = self.read(dict(zip(self.unknowns, values, strict=True)))
        blocks = self.blocks(D, X)
        named = (parse_tree(e.what) for e in self.equations if e.kind == "order")
        wanted = [reduce_tree(t, self.stage_order)[0] for t in named]
        series = starting_series(
            blocks, self.order, principal, stage_order=self.stage_order, wanted=wanted
        )
        return [self._residual(e, D, X, blocks, series) for e in self.equations]

    def _residual(
        self, equation: Equation, D: Sequence[Any], X: Matrix, blocks: Blocks, series: Series
    ) -> Any:
        if equation.kind == "order":
            reduced, factor = reduce_tree(parse_tree(equation.what), self.stage_order)
            return series.residual[reduced] * factor
        if equation.kind == "identity":
            reduced, factor = reduce_tree(parse_tree(equation.what), self.stage_order)
            return series.zeta[reduced][0] * factor
        if equation.kind == "growth":
            return self.growth(equation.what, D, X)
        i = self.index(equation)
        if equation.kind == "explicit":
            return blocks.A[i][i]
        if equation.kind == "start":
            return series.zeta[parse_tree(f"{equation.what} o".split()[1])][i]
        abscissa = series.eta[single()][i]
        if equation.kind == "abscissa":
            return abscissa - parse(equation.value)
        t = defect_tree(equation)
        power: Any = Exact(1)
        for _ in range(t.order):
            power = power * abscissa
        return series.eta[t][i] - power * Fraction(1, t.density)

    @cached_property
    def _eigenvectors(self) -> dict[str, tuple[list[Any], list[Any], Any]]:
        return {}

    def eigenvector(self, text: str) -> tuple[list[Any], list[Any], Any]:
        """G Re v, G Im v and v^* G v for the eigenvector v of a simple eigenvalue of V.

        Raises
        ------
            DataError: when ``text`` is no simple eigenvalue of V.
        """
        if text not in self._eigenvectors:
            z = parse(text)
            shifted = linalg.sub(self.V, linalg.scale(z, linalg.identity(self.r)))
            basis = linalg.nullspace(shifted)
            if len(basis) != 1:
                raise DataError(
                    f"'growth {text}' must name a simple eigenvalue of V, and the eigenspace "
                    f"has dimension {len(basis)}"
                )
            v = basis[0]
            norm = linalg.dot([x.conjugate() for x in v], linalg.matvec(self.G, v)).real
            parts = [
                [_number(x) for x in linalg.matvec(self.G, part)]
                for part in ([x.real for x in v], [x.imag for x in v])
            ]
            self._eigenvectors[text] = (parts[0], parts[1], _number(norm))
        return self._eigenvectors[text]

    def growth(self, text: str, D: Sequence[Any], X: Matrix) -> Any:
        """Growth parameter of an eigenvalue of V, by the theorem of :mod:`glmref.method.sweep`."""
        real, imaginary, norm = self.eigenvector(text)
        total: Any = Exact(0)
        for d, column in zip(D, linalg.transpose(X), strict=True):
            for part in (real, imaginary):
                along = linalg.dot(column, part)
                total = total + d * along * along
        return total / norm

    def signs(self) -> tuple[int, ...] | None:
        """Signs e_k with ``X = E X P`` and ``P D P = D`` for all values of the unknowns.

        Returns ``None`` when the pattern is not palindromic, or when E does not commute with G or
        reverse V: then the symmetry theorem of :mod:`glmref.method.sweep` does not apply.
        """
        D, X, _ = self.read({name: Affine.unknown(name) for name in self.unknowns})
        if not all(
            (Affine.of(x) - y).is_identically_zero() for x, y in zip(D, D[::-1], strict=True)
        ):
            return None
        found: list[int] = []
        for row in X:
            pairs = [(Affine.of(x), y) for x, y in zip(row, row[::-1], strict=True)]
            if all((x - y).is_identically_zero() for x, y in pairs):
                found.append(1)
            elif all((x + y).is_identically_zero() for x, y in pairs):
                found.append(-1)
            else:
                return None
        E = linalg.diagonal([Exact(x) for x in found])
        commutes = linalg.sub(linalg.matmul(E, self.G, E), self.G)
        reverses = linalg.sub(linalg.matmul(E, linalg.inverse(self.V), E), self.V)
        if any(not x.is_zero() for m in (commutes, reverses) for _, _, x in linalg.entries(m)):
            return None
        return tuple(found)


def _number(value: Exact | Ball) -> Exact | Ball:
    """Keep a rational as it is, turn another exact number into a ball once."""
    if isinstance(value, Exact) and value.as_fraction() is None:
        return ball(value)
    return value
