"""From a method document to its square system of equations.

Read are the classes of methods in the sweep form (:mod:`glmref.method.sweep`): ``sweep`` (one
component, D and X), ``pair-sweep`` (two: b and w, c and v) and ``splitting`` (a and b; the case r =
r^ = 1 of two). The file names its unknowns and its equations; this module gives them their meaning:

    order T             R(T) = 0 for the tree T (:mod:`glmref.prove.equations`)
    identity T          zeta_1(T) = 0: no conjugation at the even tree T
    start K             zeta_K(o) = 0: value K starts as O(h^2)
    start K T           zeta_K(T) = 0; of two components ``start T K``, T saying which of them
    growth Z            the growth parameter of Z is zero, Z a simple eigenvalue of V
    growth q Z          of two components: that of the first, p Z: of the second
    explicit I          d_i (X^T G X)_ii / 2 = 0: stage I and its mirror image need no solve
    defect I            eta_I([o]) - eta_I(o)^2 / 2 = 0: stage I has stage order 2
    defect I [oo]       eta_I([oo]) - eta_I(o)^3 / 3 = 0: with the former, stage order 3
    abscissa I = Q      eta_I(o) = Q

``identity`` and the last four are for one component only.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from ..catalogue.claims import NYSTROM_ORDER, ORDER, ORDER_IDENTITY
from ..errors import DataError
from ..exact import Ball, Exact, ball, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..method import as_matrix
from ..method.sweep import SweepForm, columns, stage_word
from ..theory.trees import Tree, parse_tree, single, tree
from .classes import Family, classes, reduce_tree
from .equations import Series, starting_series

#: The names of the weights in a file, by its class: one component or two.
_WEIGHTS = {"sweep": ("D",), "pair-sweep": ("b", "c"), "splitting": ("a", "b")}

_TREE, _NUMBER = r"(?P<tree>\S+)", r"(?P<number>[1-9]\d{0,5})"
#: What follows the kind of an equation, by the number of components.
_FORMS: Mapping[int, Mapping[str, str]] = {
    1: {
        "order": _TREE,
        "identity": _TREE,
        "start": rf"{_NUMBER}( {_TREE})?",
        "growth": "(?P<value>.+)",
        "explicit": _NUMBER,
        "defect": rf"{_NUMBER}( {_TREE})?",
        "abscissa": rf"{_NUMBER} = (?P<value>.+)",
    },
    2: {
        "order": _TREE,
        "start": rf"{_TREE} {_NUMBER}",
        "growth": "(?P<half>[qp]) (?P<value>.+)",
    },
}
_EXAMPLES = {
    1: "'order [oo]', 'growth -1', 'explicit 1', 'defect 1', 'start 2', 'identity [o]' or "
    "'abscissa 1 = 1/3'",
    2: "'order f[kk]', 'growth q -1', 'growth p -1' or 'start f[k] 2'",
}


class Affine:
    """An affine expression ``c_0 + sum c_i x_i`` in the unknowns, with exact coefficients.

    It lets an identity between entries be decided for *all* values of the unknowns.
    """

    __slots__ = ("coefficients",)

    def __init__(self, coefficients: Mapping[str, Exact]) -> None:
        self.coefficients = dict(coefficients)

    @classmethod
    def unknown(cls, name: str) -> Affine:
        """Return the unknown itself."""
        return cls({name: Exact(1)})

    @classmethod
    def of(cls, value: Any) -> Affine:
        """Return a constant, or an affine expression passed through."""
        if isinstance(value, Affine):
            return value
        return cls({"": value if isinstance(value, Exact) else Exact(0) + value})

    def __add__(self, other: Any) -> Affine:
        result = dict(self.coefficients)
        for name, value in Affine.of(other).coefficients.items():
            result[name] = result[name] + value if name in result else value
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
                        "the entries must be affine in the unknowns; give the product of two of "
                        "them a name of its own"
                    )
                return other * self
            other = other.coefficients.get("", Exact(0))
        return Affine({name: value * other for name, value in self.coefficients.items()})

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Affine:
        if isinstance(other, Affine):
            if not other._is_constant():
                raise DataError("the entries must be affine in the unknowns; one is a divisor")
            other = other.coefficients.get("", Exact(0))
        return self * (Exact(1) / other)

    def __rtruediv__(self, other: Any) -> Affine:
        return Affine.of(other) / self

    def _is_constant(self) -> bool:
        return all(name == "" or value.is_zero() for name, value in self.coefficients.items())

    def is_identically_zero(self) -> bool:
        """Return whether the expression vanishes for all values of the unknowns."""
        return all(value.is_zero() for value in self.coefficients.values())


@dataclass(frozen=True)
class Equation:
    """One named equation of a file.

    Attributes
    ----------
    text : str
        Its name.
    kind : str
        Its first word.
    tree : Tree or None
        Where it names one or means one.
    number : int
        Of the value or stage, from 0.
    colour : str
        Of the component whose growth is meant.
    value : str
        The eigenvalue or the abscissa.
    """

    text: str
    kind: str
    tree: Tree | None = None
    number: int = 0
    colour: str = "o"
    value: str = "0"

    @classmethod
    def read(cls, text: str, components: int = 1) -> Equation:
        """Read the name of an equation of a method of one component or two.

        Raises
        ------
        DataError
            For a name that has no meaning.
        """
        kind, _, rest = text.partition(" ")
        match = re.fullmatch(_FORMS[components].get(kind, r"(?!)"), rest)
        if match is None:
            raise DataError(f"the equation {text[:60]!r} is unknown; write {_EXAMPLES[components]}")
        found = match.groupdict()
        name = found.get("tree") or {"start": "o", "defect": "[o]"}.get(kind)
        t = parse_tree(name) if name else None
        family = Family.ROOTED if components == 1 else Family.SEPARABLE
        if t is not None and t not in family:
            raise DataError(
                f"{text[:60]!r} must name a tree of "
                f"{'one colour' if components == 1 else 'which the colours f and k alternate'}"
            )
        colour = {"q": "f", "p": "k"}.get(found.get("half") or "", "o")
        number = int(found.get("number") or 1) - 1
        return cls(text, kind, t, number, colour, found.get("value") or "0")


def row_reader(
    document: Mapping[str, Any], values: Mapping[str, Any]
) -> Callable[[Sequence[str]], tuple[Any, ...]]:
    """Return what reads entries of a document at given values of its unknowns."""
    constants: dict[str, Any] = dict(values)
    for name, text in document.get("constants", {}).items():
        constants[name] = parse(text, constants=constants)
    return lambda texts: tuple(parse(x, constants=constants) for x in texts)


class SweepSystem:
    """The unknowns and equations of one document, evaluated over any scalar.

    Attributes
    ----------
    unknowns
        Names, in the order of the file. equations: in the order of the file.
    principal
        The free principal parts that the file names, by tree.
    colours
        Of the components. V: (r, r) by colour; G: (r, r) or (r, r^); exact.
    word
        The stages in their order. claimed, claimed_second_order: orders that the file claims.

    Raises
    ------
    DataError
        For a document of another class, or whose V, G or equations are not what the theorems ask
        for.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        kind = document.get("class")
        if kind not in _WEIGHTS:
            raise DataError(
                f"only files of class 'sweep', 'pair-sweep' and 'splitting' are solved for, "
                f"got {kind!r}"
            )
        self.document, self.names = document, _WEIGHTS[kind]
        self.colours = ("o",) if len(self.names) == 1 else ("f", "k")
        self.unknowns: tuple[str, ...] = tuple(document.get("unknowns", {}))
        enclosure = document.get("enclosure", {})
        texts = enclosure.get("equations", ())
        self.equations = tuple(Equation.read(x, len(self.colours)) for x in texts)
        self.principal = {parse_tree(t): x for t, x in enclosure.get("xi", {}).items()}
        claims = document.get("claims", {})
        self.claimed = max(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key))
        self.claimed_second_order = claims.get(NYSTROM_ORDER.key, 0) if self.is_partitioned else 0
        self.V, self.G = self._forms(kind)
        self.word = self._stages(kind)
        self._check_blocks()
        for e in self.equations:
            self._check_number(e)

    def _forms(self, kind: str) -> tuple[dict[str, Matrix], Matrix]:
        if kind == "splitting":
            one: Matrix = ((Exact(1),),)
            return {"f": one, "k": one}, one
        names = ("V", "V_hat")[: len(self.colours)]
        V = {c: as_matrix(self.document[x], x) for c, x in zip(self.colours, names, strict=True)}
        rows = self.document["G"]
        if all(isinstance(x, str) for x in rows):  # a form given by its diagonal
            rows = [[x if i == j else "0" for j in range(len(rows))] for i, x in enumerate(rows)]
        return V, as_matrix(rows, "G")

    def _stages(self, kind: str) -> tuple[tuple[str, int], ...]:
        sizes = [len(self.document[x]) for x in self.names]
        if kind == "sweep":
            return tuple(("o", i) for i in range(sizes[0]))
        if kind == "pair-sweep":
            return stage_word(self.document["stages"], *sizes)
        letters = "PQ" if self.document["first"] == "q" else "QP"
        return stage_word((letters * max(sizes))[: sum(sizes)], *sizes)

    def _check_blocks(self) -> None:
        """Check V = 1 + V_2, G = 1 + G_2 and V^T G V = G, which the theorems require."""
        names = {"V": self.V[self.colours[0]], "V_hat": self.V[self.colours[-1]], "G": self.G}
        for name, matrix in names.items():
            border = [x for row in matrix[1:] for x in row[:1]] + list(matrix[0][1:])
            if matrix[0][0] != 1 or any(not x.is_zero() for x in border):
                raise DataError(f"the first row and column of `{name}` must be 1, 0, ..., 0")
        preserved = linalg.matmul(linalg.transpose(names["V"]), self.G, names["V_hat"])
        if any(not x.is_zero() for _, _, x in linalg.entries(linalg.sub(preserved, self.G))):
            both, hat = ("`V` and `V_hat`", "^") if self.is_partitioned else ("`V`", "")
            raise DataError(
                f"{both} must preserve `G`: V^T G V{hat} = G is what makes the form G-symplectic"
            )

    def _check_number(self, e: Equation) -> None:
        top, what = self.s, "stage"
        if e.kind == "start" and e.tree is not None:
            top, what = len(self.V[e.tree.colour]), "value"
        if e.number >= top:
            raise DataError(f"{e.text!r} must name a {what} from 1 to {top}")

    @property
    def is_partitioned(self) -> bool:
        """Whether there are two components."""
        return len(self.colours) == 2

    @property
    def is_one_step(self) -> bool:
        """Whether each component carries one value."""
        return all(len(V) == 1 for V in self.V.values())

    @property
    def s(self) -> int:
        """Number of stages (of the first component)."""
        return len(self.document[self.names[0]])

    @property
    def families(self) -> tuple[tuple[int, Family], ...]:
        """The orders claimed, each with the trees that count for it."""
        whole = Family.SEPARABLE if self.is_partitioned else Family.ROOTED
        found = ((self.claimed, whole), (self.claimed_second_order, Family.SECOND_ORDER))
        return tuple((order, family) for order, family in found if order)

    @property
    def family(self) -> Family:
        """Trees of the equations: those of second-order systems where more is claimed for these."""
        return (
            max(self.families, key=lambda x: x[0])[1]
            if self.families
            else (Family.SEPARABLE if self.is_partitioned else Family.ROOTED)
        )

    @property
    def order(self) -> int:
        """Order up to which series are needed by the equations."""
        orders = [e.tree.order + (e.kind != "order") for e in self.equations if e.tree]
        return max([2, *orders])

    @cached_property
    def stage_order(self) -> int:
        """Stage order that the equations ``defect`` give: for the stages up to the middle suffice.

        The middle stage needs no equation for a tree of odd order (theorem 3 of
        :mod:`glmref.prove.equations`).
        """
        have = {(e.number, e.tree) for e in self.equations if e.kind == "defect"}
        q = 1
        while True:
            t = tree([single()] * q)
            half = self.s // 2 if t.order % 2 else (self.s + 1) // 2
            if not all((i, t) in have for i in range(half)):
                return q
            q += 1

    def read(self, values: Mapping[str, Any]) -> tuple[SweepForm, dict[Tree, Any]]:
        """Evaluate the form and the free principal parts at given values of the unknowns."""
        row = row_reader(self.document, values)

        D = {c: row(self.document[x]) for c, x in zip(self.colours, self.names, strict=True)}
        if self.is_partitioned:
            rest = [self.document.get(x, []) if self.names[0] == "b" else [] for x in ("w", "v")]
            X = {
                c: columns([row(x) for x in rows], len(D[c]))
                for c, rows in zip(self.colours, rest, strict=True)
            }
        else:
            X = {"o": tuple(row(x) for x in self.document["X"])}
        V, G = self._numbers
        principal = {t: row([x])[0] for t, x in self.principal.items()}
        return SweepForm(D, X, V, G, self.word), principal

    @cached_property
    def _numbers(self) -> tuple[dict[str, Matrix], Matrix]:
        """V and G with irrational entries as balls, converted once."""

        def convert(matrix: Matrix) -> Matrix:
            return tuple(tuple(_number(x) for x in row) for row in matrix)

        return {c: convert(V) for c, V in self.V.items()}, convert(self.G)

    def series(
        self, form: SweepForm, principal: Mapping[Tree, Any], order: int, **more: Any
    ) -> Series:
        """Return starting series and residuals; principal parts zero where the equations prove it.

        Parameters
        ----------
        form, principal
            As :meth:`read` gives them.
        order : int
            Of the last residuals.
        more : Any
            ``family`` and ``wanted`` of :func:`~glmref.prove.equations.starting_series`.
        """
        family = more.setdefault("family", self.family)
        identity = self.identity_through(order - 1, family)
        return starting_series(
            form.blocks, form.G, order, principal, stage_order=self.stage_order, identity=identity,
            **more,
        )  # fmt: skip

    def residuals(self, values: Sequence[Any]) -> list[Any]:
        """Return the left minus right side of every equation, in the order of the file."""
        form, principal = self.read(dict(zip(self.unknowns, values, strict=True)))
        named = (e.tree for e in self.equations if e.kind == "order" and e.tree)
        wanted = [reduce_tree(t, self.stage_order)[0] for t in named]
        series = self.series(form, principal, self.order, wanted=wanted)
        return [self._residual(e, form, series) for e in self.equations]

    def _residual(self, e: Equation, form: SweepForm, series: Series) -> Any:
        if e.kind == "growth":
            return self.growth(e, form)
        if e.kind == "explicit":
            return form.blocks[0].A[e.number][e.number]
        if e.kind == "abscissa":
            return series.eta[single()][e.number] - parse(e.value)
        assert e.tree is not None
        if e.kind == "start":
            return series.zeta[e.tree][e.number]
        if e.kind == "defect":
            power: Any = Exact(1)
            for _ in range(e.tree.order):
                power = power * series.eta[single()][e.number]
            return series.eta[e.tree][e.number] - power * Fraction(1, e.tree.density)
        reduced, factor = reduce_tree(e.tree, self.stage_order)
        if e.kind == "identity":
            return series.zeta[reduced][0] * factor
        return series.residual[reduced] * factor

    @cached_property
    def _eigenvectors(self) -> dict[tuple[str, str], tuple[list[list[Any]], Any]]:
        return {}

    def eigenvector(self, e: Equation) -> tuple[list[list[Any]], Any]:
        """Return G v, real and imaginary part, and n of the theorem on growth parameters.

        Raises
        ------
        DataError
            When the equation names no simple eigenvalue of V (and of V^).
        """
        key = e.colour, e.value
        if key not in self._eigenvectors:
            z, found = parse(e.value), {}
            for c, V in self.V.items():
                shifted = linalg.sub(V, linalg.scale(z, linalg.identity(len(V))))
                basis = linalg.nullspace(shifted)
                if len(basis) != 1:
                    raise DataError(
                        f"{e.text!r} must name a simple eigenvalue of V, and the eigenspace has "
                        f"dimension {len(basis)}"
                    )
                found[c] = basis[0]
            exact = SweepForm(self.V, {}, self.V, self.G, ())  # for its forms
            other = exact.partner(e.colour)
            seen = linalg.matvec(exact.form(other), found[other])
            norm = linalg.dot([x.conjugate() for x in found[e.colour]], seen).conjugate()
            parts = [[_number(x.real) for x in seen], [_number(x.imag) for x in seen]]
            self._eigenvectors[key] = parts, _number(norm.real if norm.is_real() else norm)
        return self._eigenvectors[key]

    def growth(self, e: Equation, form: SweepForm) -> Any:
        """Return growth parameter of an equation, by the theorem of :mod:`glmref.method.sweep`."""
        parts, norm = self.eigenvector(e)
        total: Any = Exact(0)
        for d, column in zip(form.D[e.colour], linalg.transpose(form.X[e.colour]), strict=True):
            for part in parts:
                along = linalg.dot(column, part)
                total = total + d * along * along
        return total / norm

    # -- what holds for all values of the unknowns

    @cached_property
    def affine(self) -> SweepForm:
        """The form with its entries as affine expressions in the unknowns."""
        return self.read({name: Affine.unknown(name) for name in self.unknowns})[0]

    def signs(self) -> tuple[tuple[int, ...], ...] | None:
        """Return diagonals of E, by component: ``X = E X P`` and ``P D P = D`` for all values.

        ``None`` where the stages, the weights or the columns are not palindromic, or where E does
        not fit G and V: then the symmetry theorem of :mod:`glmref.method.sweep` says nothing.
        """
        word = [colour for colour, _ in self.word]
        form = self.affine
        if word != word[::-1] or not all(_palindromic(x) == 1 for x in form.D.values()):
            return None
        signs: dict[str, tuple[int, ...]] = {}
        for c, rows in form.X.items():
            found = [_palindromic(row) for row in rows]
            if None in found:
                return None
            signs[c] = tuple(x for x in found if x is not None)
        E = {c: linalg.diagonal([Exact(x) for x in s]) for c, s in signs.items()}
        first, last = self.colours[0], self.colours[-1]
        checks = [linalg.sub(linalg.matmul(E[first], self.G, E[last]), self.G)]
        for c, V in self.V.items():
            checks.append(linalg.sub(linalg.matmul(E[c], linalg.inverse(V), E[c]), V))
        if any(not x.is_zero() for m in checks for _, _, x in linalg.entries(m)):
            return None
        return tuple(signs.values())

    @cached_property
    def involutions(self) -> Mapping[str, Matrix]:
        """L = V^-1 E of each component, by colour; empty without :meth:`signs`."""
        return {
            c: linalg.matmul(linalg.inverse(V), linalg.diagonal([Exact(x) for x in s]))
            for (c, V), s in zip(self.V.items(), self.signs() or (), strict=False)
        }

    def start_vanishes(self, t: Tree, k: int) -> bool:
        """Return whether zeta_k(t) = 0, k from 1 (0 is the first value), by ``start`` or by parity.

        By symmetry zeta_k vanishes at odd trees where L keeps value k, and at even trees where L
        changes its sign.
        """
        if any(e.kind == "start" and (e.tree, e.number) == (t, k) for e in self.equations):
            return True
        if not self.involutions:
            return False
        # row k of L is +- e_k, with the sign that makes the value vanish at this order
        row = self.involutions[t.colour][k]
        return all(x == (j == k) * (-1) ** (t.order + 1) for j, x in enumerate(row))

    @cached_property
    def _identities(self) -> dict[tuple[int, Family], bool]:
        return {}

    def identity_through(self, order: int, family: Family) -> bool:
        """Return whether principal parts of order <= ``order`` are 0 by equations ``start``.

        By theorem 2 of :mod:`glmref.prove.equations` they are where ``zeta_k(t) G_kl zeta_l(u) =
        0`` for all k, l > 1 and |t| + |u| <= order.
        """
        key = order, family
        if key not in self._identities:
            self._identities[key] = self._is_identity(order, family)
        return self._identities[key]

    def _is_identity(self, order: int, family: Family) -> bool:
        if self.is_one_step or order < 2:
            return True
        if self.principal or not self.involutions:
            return False
        listed = [t for n in range(1, order) for t in classes(n, 1, family)]
        left = [t for t in listed if t.colour == self.colours[0]]
        right = [t for t in listed if t.colour == self.colours[-1]]
        coupled = [(k, l) for k, l, x in linalg.entries(self.G) if k > 0 and not x.is_zero()]
        return all(
            self.start_vanishes(t, k) or self.start_vanishes(u, l)
            for k, l in coupled
            for t in left
            for u in right
            if t.order + u.order <= order
        )


def _palindromic(row: Sequence[Any]) -> int | None:
    """Return +1 or -1 where a row of affine expressions is its mirror image up to this sign."""
    mirrored = [(Affine.of(x), Affine.of(y)) for x, y in zip(row, row[::-1], strict=True)]
    for sign in (1, -1):
        if all((x - sign * y).is_identically_zero() for x, y in mirrored):
            return sign
    return None


def _number(value: Exact | Ball) -> Exact | Ball:
    """Keep a rational as it is, turn another exact number into a ball once."""
    if isinstance(value, Exact) and value.as_fraction() is None:
        return ball(value)
    return value
