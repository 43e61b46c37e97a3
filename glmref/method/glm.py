"""Methods as frozen records: general linear, partitioned, starting and finishing.

Arrays carry the letters of the literature. Entries are :mod:`glmref.exact` numbers; the one place
where they are rounded to floating point is :meth:`GLM.to_float`, which keeps the rounding residue.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from ..errors import DataError, ExactnessError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from ..system.arguments import shown
from . import preconsistency
from .base import Own
from .component import GENERAL, SEPARABLE, Palette
from .embedded import EmbeddedRow, quoted
from .entries import Entries, Rows, as_matrix, as_vector, check_fields, check_shape
from .model import PAIR, Method
from .rounding import FloatGLM, float_arrays
from .starting import FinishingMethod, PairStartingMethod, StartingMethod


def check_embedded(method: Method) -> None:
    """Refuse embedded rows that do not fit the stages and the values.

    Raises
    ------
    DataError
        Naming the row.
    """
    rows = method.embedded
    if not isinstance(rows, tuple) or not all(isinstance(row, EmbeddedRow) for row in rows):
        raise DataError(f"`embedded` must be a tuple of embedded rows, got {shown(rows)}")
    for row in rows:
        if row.values is None and not method.is_one_step:
            raise DataError(
                f"`embedded` {quoted(row.name)} needs weights `v` of the {method.carried} values "
                f"carried"
            )
        if row.values is not None and len(row.values) != method.carried:
            raise DataError(
                f"`embedded` {quoted(row.name)} must have r = {method.carried} entries in `v`, got "
                f"{len(row.values)}"
            )
        for weights, component in zip(row.weights, method.components, strict=True):
            if len(weights) != len(component.B[0]):
                raise DataError(
                    f"`embedded` {quoted(row.name)} must have s = {len(component.B[0])} entries, "
                    f"got {len(weights)}"
                )


def _take_output(method: GLM | PartitionedGLM, name: str, r: int) -> None:
    """Turn a declared output into a vector and check its length."""
    declared = getattr(method, name)
    if declared is None:
        return
    object.__setattr__(method, name, as_vector(declared, name))
    if len(declared) != r:
        raise DataError(f"`{name}` must have {r} entries, one for each value, got {len(declared)}")


def _moved_output(m: preconsistency.Block, back: Matrix) -> Vector | None:
    """Return the output ``w T^-1`` after a change of values.

    ``None`` where there is no solution to read.

    Written down even where the method declares none, because the rule that finds an undeclared one
    looks at the values by number.
    """
    if m.output is None and preconsistency.preconsistency_vector(m) is None:
        return None
    return linalg.vecmat(preconsistency.output(m), back)


def _without_file(method: Any, outputs: Mapping[str, str], changes: Mapping[str, Any]) -> Any:
    """Return a copy with other coefficients, and without whatever else a file may give.

    The outputs, by the letter of the values that they read, stay where their sizes do.
    """
    kept = {"name", "separable", "system", *outputs.values()}
    empty = {x.name: None for x in fields(method) if x.default is None and x.name not in kept}
    empty |= {x: MappingProxyType({}) for x in ("claims", "source")}
    for letter, output in outputs.items():
        rows = getattr(method, letter)
        if len(changes.get(letter, rows)) != len(rows):
            empty[output] = None
    return replace(method, **{**empty, "embedded": (), **changes})


def _transformation(T: Rows, name: str, r: int, letter: str) -> Matrix:
    matrix = as_matrix(T, name)
    check_shape(name, matrix, r, r, f"({letter}, {letter})")
    return matrix


def _transformed(method: GLM | PartitionedGLM, *changes: tuple[Matrix, Matrix]) -> dict[str, Any]:
    """Return what T y in place of y changes, T and its inverse given for each component."""
    found: dict[str, Any] = {"claims": method.claims}
    for c, (T, back) in zip(method.components, changes, strict=True):
        hat = method.LETTERS[c.colour]
        found[f"U{hat}"] = linalg.matmul(c.U, back)
        found[f"B{hat}"] = linalg.matmul(T, c.B)
        found[f"V{hat}"] = linalg.matmul(T, c.V, back)
        found[f"output{hat}"] = _moved_output(c, back)
    if method.G is not None:
        left = linalg.conjugate_transpose(changes[0][1])
        found["G"] = linalg.matmul(left, method.G, changes[-1][1])
    if method.starting is not None:
        found["starting"] = method.starting.transform(*(T for T, _ in changes))
    return found


def _renumbered(method: GLM | PartitionedGLM, *orders: Sequence[int]) -> dict[str, Any]:
    """Return what another order of the stages changes, given for each component."""
    found: dict[str, Any] = {x: getattr(method, x) for x in ("G", "claims", "starting")}
    for c, rows, columns in zip(method.components, orders, orders[::-1], strict=True):
        hat = method.LETTERS[c.colour]
        found[f"A{hat}"] = tuple(tuple(c.A[i][j] for j in columns) for i in rows)
        found[f"U{hat}"] = tuple(c.U[i] for i in rows)
        found[f"B{hat}"] = tuple(tuple(row[j] for j in columns) for row in c.B)
    return found


def _permutation(order: Sequence[int], name: str, size: int) -> Sequence[int]:
    if sorted(order) != list(range(size)):
        raise DataError(f"`{name}` must be a permutation of 0..{size - 1}, got {list(order)}")
    return order


@dataclass(frozen=True, eq=False, repr=False)
class GLM(Own, Method):
    """A general linear method: ``Y = h A f(Y) + U y``, ``y+ = h B f(Y) + V y``.

    Attributes
    ----------
    A : Matrix
        (s, s) stages on stages.
    U : Matrix
        (s, r) values on stages.
    B : Matrix
        (r, s) stages on values.
    V : Matrix
        (r, r) values on values.
    name : str
        The name its file gives it.
    G : Matrix or None
        (r, r) quadratic form its source gives, or ``None``; a claim, checked like the rest.
    D : Vector or None
        (s,) diagonal its source gives, or ``None``.
    starting : StartingMethod or None
        Starting method, or ``None``.
    finishing : FinishingMethod or None
        Finishing method, or ``None`` where the output is the solution itself.
    output : Vector or None
        (r,) functional w: the solution is ``w y``, what a finishing method begins from. ``None``:
        the first value that carries the solution, see :mod:`glmref.method.preconsistency`.
    claims : Mapping[str, Any]
        What its file claims, by key; empty for a method that was computed. A change of values or of
        the order of stages keeps them.
    source : Mapping[str, Any]
        Citation, place and status, as in the file.
    document : Mapping[str, Any] or None
        The file's JSON object, ``None`` for a method that was computed.
    multistep : tuple[Vector, Vector] or None
        (alpha, beta) of a multistep or one-leg method, as its file gives them.
    embedded : tuple[EmbeddedRow, ...]
        Further weights of a method that carries one value.
    abscissae_given : Vector or None
        (s,) where f is evaluated in time, ``None`` for c = A 1 + U v.
    dense : Matrix or None
        (s, d) coefficients of ``b_i(theta) = sum_m dense[i][m] theta^(m+1)``, or ``None``.

    The constructor takes strings, numbers and arrays and checks shapes. A floating point number
    stands for the shortest decimal that gives it: 0.1 is 1/10.

    Raises
    ------
    DataError
        For a wrong shape or an entry that cannot be read.

    References
    ----------
        Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section 502.
    """

    A: Matrix
    U: Matrix
    B: Matrix
    V: Matrix
    name: str = ""
    G: Matrix | None = None
    D: Vector | None = None
    starting: StartingMethod | None = None
    finishing: FinishingMethod | None = None
    claims: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    source: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    document: Mapping[str, Any] | None = field(default=None, repr=False)
    multistep: tuple[Vector, Vector] | None = field(default=None, repr=False)
    output: Vector | None = None
    embedded: tuple[EmbeddedRow, ...] = ()
    abscissae_given: Vector | None = None
    dense: Matrix | None = None

    if TYPE_CHECKING:  # what is taken is wider than what is kept

        def __init__(
            self,
            A: Rows,
            U: Rows,
            B: Rows,
            V: Rows,
            name: str = "",
            G: Rows | None = None,
            D: Entries | None = None,
            starting: StartingMethod | None = None,
            finishing: FinishingMethod | None = None,
            claims: Mapping[str, Any] = ...,
            source: Mapping[str, Any] = ...,
            document: Mapping[str, Any] | None = None,
            multistep: tuple[Vector, Vector] | None = None,
            output: Entries | None = None,
            embedded: tuple[EmbeddedRow, ...] = (),
            abscissae_given: Vector | None = None,
            dense: Matrix | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_fields(self, starting=StartingMethod, finishing=FinishingMethod)
        for letter in "AUBV":
            object.__setattr__(self, letter, as_matrix(getattr(self, letter), letter))
        s, r = len(self.A), len(self.V)
        check_shape("A", self.A, s, s, "(s, s)")
        check_shape("V", self.V, r, r, "(r, r)")
        check_shape("U", self.U, s, r, "(s, r)")
        check_shape("B", self.B, r, s, "(r, s)")
        if self.G is not None:
            object.__setattr__(self, "G", as_matrix(self.G, "G"))
            check_shape("G", self.G, r, r, "(r, r)")
        if self.D is not None:
            object.__setattr__(self, "D", as_vector(self.D, "D"))
            if len(self.D) != s:
                raise DataError(f"`D` must have s = {s} entries, got {len(self.D)}")
        _take_output(self, "output", r)
        check_embedded(self)
        if self.abscissae_given is not None:
            object.__setattr__(self, "abscissae_given", as_vector(self.abscissae_given, "c"))
        if self.dense is not None:
            object.__setattr__(self, "dense", as_matrix(self.dense, "dense"))
        for name, given in (("c", self.abscissae_given), ("dense", self.dense)):
            if given is not None and len(given) != s:
                raise DataError(f"`{name}` must have s = {s} entries, got {len(given)}")

    SIZES: ClassVar[Sequence[str]] = ("s", "r")

    @property
    def times(self) -> tuple[Vector, ...]:
        """Where in a step the stages stand: c, as it is given or as it follows from A."""
        return super().times if self.abscissae_given is None else (self.abscissae_given,)

    def weighted(self, B: tuple[Matrix, ...]) -> GLM:
        """Return the method with other weights, for one of its embedded rows."""
        one = ((Exact(1),),)
        return self.bare(
            B=B[0], U=one * self.s, V=one, output=None, abscissae_given=self.abscissae_given
        )

    def with_row(self, row: EmbeddedRow) -> Method:
        """Return the method with an embedded solution in the place of its own.

        Where several values are carried, those after a step are moved along u, so that their
        output is the embedded solution: ``B + u (b - w B)`` and ``V + u (v - w V)``.

        Raises
        ------
        ExactnessError
            Where there is no u with V u = u and U u = 1, or more than one.
        """
        if row.values is None:
            return super().with_row(row)
        found, w = preconsistency.preconsistency_of(self), preconsistency.output(self)
        if (u := found.u) is None or not found.unique:
            count = "more than one" if u else "none"
            raise ExactnessError(
                f"an embedded solution needs the u with V u = u and U u = 1: there is {count}"
            )

        def moved(M: Matrix, own: Vector) -> Matrix:
            (read,) = linalg.matmul((w,), M)
            gap = tuple(x - y for x, y in zip(own, read, strict=True))
            return tuple(
                tuple(x + k * y for x, y in zip(r, gap, strict=True))
                for k, r in zip(u, M, strict=True)
            )

        return self.bare(B=moved(self.B, row.weights[0]), V=moved(self.V, row.values))

    @property
    def in_time(self) -> Method:
        """The method for y' = f(t, y): itself where c = A 1, else a pair of y and t.

        ``t' = 1`` has no arguments: the stages of t are t_n + c_i h.
        """
        c = self.abscissae_given
        sums = linalg.matvec(self.A, (Exact(1),) * self.s)
        if c is None or linalg.sub((sums,), (c,)) == linalg.zeros(1, self.s):
            return self
        one, rest = ((Exact(1),),), (Exact(0),) * (self.s - 1)
        return PartitionedGLM(
            self.A, self.U, self.B, self.V,
            tuple((x, *rest) for x in c), one * self.s, ((Exact(1), *rest),), one, system="time",
        )  # fmt: skip

    @property
    def s(self) -> int:
        """Number of stages."""
        return len(self.A)

    @property
    def r(self) -> int:
        """Number of values carried from step to step."""
        return len(self.V)

    @property
    def diagonals(self) -> tuple[Vector | None, ...]:
        """D alone."""
        return (self.D,)

    def bare(self, **changes: Any) -> Self:
        """Return a copy with other coefficients and without claims, source, start or finish.

        The output stays where the number of values does.
        """
        return _without_file(self, {"V": "output"}, changes)

    def transform(self, T: Rows) -> Self:
        """Carry the values ``T y`` instead of ``y``: an equivalent method.

        What belongs to the method goes along: the starting method gives ``T B`` and ``T u``, the
        output becomes ``w T^-1``, the quadratic form ``T^-* G T^-1``. The finishing method begins
        from the output and stays as it is, and so do the claims: what is claimed of a method does
        not depend on the values it carries.

        Parameters
        ----------
        T : Rows
            (r, r) nonsingular.

        Raises
        ------
        ExactnessError
            When T is singular.
        """
        T = _transformation(T, "T", self.r, "r")
        back = linalg.inverse(T)
        return self.bare(
            **_transformed(self, (T, back)),
            D=self.D,
            finishing=self.finishing,
            multistep=self.multistep,
            embedded=tuple(row.transformed(back) for row in self.embedded),
            abscissae_given=self.abscissae_given,
            dense=self.dense,
        )

    def permute_stages(self, order: Sequence[int]) -> Self:
        """Renumber the stages: the new stage i is the old stage ``order[i]`` (from 0).

        Starting and finishing methods have stages of their own and stay as they are.
        """
        order = _permutation(order, "order", self.s)
        return self.bare(
            **_renumbered(self, order),
            D=self.D and tuple(self.D[i] for i in order),
            finishing=self.finishing,
            multistep=self.multistep,
            embedded=tuple(row.permuted(order) for row in self.embedded),
            abscissae_given=self.abscissae_given and tuple(self.abscissae_given[i] for i in order),
            dense=self.dense and tuple(self.dense[i] for i in order),
        )

    def to_float(self) -> FloatGLM:
        """Round every coefficient to double precision, once, and keep the residue."""
        found: dict[str, Any] = {"name": self.name}
        for name in "AUBV":
            found[name], found[f"{name}_residue"] = float_arrays(getattr(self, name))
        if self.G is not None:
            found["G"], _ = float_arrays(self.G)
        if self.D is not None:
            found["D"] = float_arrays((self.D,))[0][0]
        return FloatGLM(**found)


@dataclass(frozen=True, eq=False, repr=False)
class PartitionedGLM(Own, Method):
    """A pair of GLMs for ``q' = f(p)``, ``p' = k(q)`` (or ``f(q, p)``, ``k(q, p)``).

    One step is::

        Q  = h A f(P) + U q          q+ = h B f(P) + V q
        P  = h A^ k(Q) + U^ p        p+ = h B^ k(Q) + V^ p

    There are n_P stages P where f is evaluated and n_Q stages Q where k is evaluated. For a general
    (not separable) system the two numbers agree and both functions take ``(Q_i, P_i)``.

    Attributes
    ----------
    A, U, B, V : Matrix
        The method for q, (n_Q, n_P), (n_Q, r), (r, n_P), (r, r).
    A_hat, U_hat, B_hat, V_hat : Matrix
        The method for p, (n_P, n_Q), (n_P, r^), (r^, n_Q), (r^, r^).
    G : Matrix or None
        (r, r^) bilinear form its source gives, or ``None``.
    D_P, D_Q : Vector or None
        (n_P,) and (n_Q,) diagonals its source gives, or ``None``.
    separable : bool
        Whether the pair is meant for separable systems only (two stage sets).
    starting : PairStartingMethod or None
        Starting method of the pair, or ``None``. There is no finishing method: the outputs are the
        solution.
    output, output_hat : Vector or None
        (r,) and (r^,) functionals that read the solution (q, p) off the values, or ``None`` as in
        :class:`GLM`.
    name, claims, source, document, embedded
        As in :class:`GLM`.
    system : str
        ``"time"`` for a method in y and t, whose k has no arguments, else ``""``.

    Raises
    ------
    DataError
        For a wrong shape or an entry that cannot be read.
    """

    A: Matrix
    U: Matrix
    B: Matrix
    V: Matrix
    A_hat: Matrix
    U_hat: Matrix
    B_hat: Matrix
    V_hat: Matrix
    LETTERS = PAIR
    name: str = ""
    G: Matrix | None = None
    D_P: Vector | None = None
    D_Q: Vector | None = None
    separable: bool = False
    starting: PairStartingMethod | None = None
    claims: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    source: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    document: Mapping[str, Any] | None = field(default=None, repr=False)
    output: Vector | None = None
    output_hat: Vector | None = None
    embedded: tuple[EmbeddedRow, ...] = ()
    system: str = ""

    if TYPE_CHECKING:  # as for a GLM

        def __init__(
            self,
            A: Rows,
            U: Rows,
            B: Rows,
            V: Rows,
            A_hat: Rows,
            U_hat: Rows,
            B_hat: Rows,
            V_hat: Rows,
            name: str = "",
            G: Rows | None = None,
            D_P: Entries | None = None,
            D_Q: Entries | None = None,
            separable: bool = False,
            starting: PairStartingMethod | None = None,
            claims: Mapping[str, Any] = ...,
            source: Mapping[str, Any] = ...,
            document: Mapping[str, Any] | None = None,
            output: Entries | None = None,
            output_hat: Entries | None = None,
            embedded: tuple[EmbeddedRow, ...] = (),
            system: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        check_fields(self, starting=PairStartingMethod, separable=bool, system=str)
        for name in (letter + hat for letter in "AUBV" for hat in self.LETTERS.values()):
            object.__setattr__(self, name, as_matrix(getattr(self, name), name))
        n_q, n_p = len(self.A), len(self.A_hat)
        r, r_hat = len(self.V), len(self.V_hat)
        check_shape("A", self.A, n_q, n_p, "(n_Q, n_P)")
        check_shape("U", self.U, n_q, r, "(n_Q, r)")
        check_shape("B", self.B, r, n_p, "(r, n_P)")
        check_shape("V", self.V, r, r, "(r, r)")
        check_shape("A_hat", self.A_hat, n_p, n_q, "(n_P, n_Q)")
        check_shape("U_hat", self.U_hat, n_p, r_hat, "(n_P, r^)")
        check_shape("B_hat", self.B_hat, r_hat, n_q, "(r^, n_Q)")
        check_shape("V_hat", self.V_hat, r_hat, r_hat, "(r^, r^)")
        if n_p != n_q and not self.separable:
            raise DataError(
                f"a pair with {n_p} stages P and {n_q} stages Q is for separable systems: "
                f"say `separable: true`"
            )
        if self.G is not None:
            object.__setattr__(self, "G", as_matrix(self.G, "G"))
            check_shape("G", self.G, r, r_hat, "(r, r^)")
        for name, size in (("D_P", n_p), ("D_Q", n_q)):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, as_vector(value, name))
                if len(value) != size:
                    raise DataError(f"`{name}` must have {size} entries, got {len(value)}")
        _take_output(self, "output", r)
        _take_output(self, "output_hat", r_hat)
        check_embedded(self)

    SIZES: ClassVar[Sequence[str]] = ("n_Q", "n_P", "r", "r_hat")

    @property
    def n_P(self) -> int:
        """Number of stages P, where f is evaluated."""
        return len(self.A_hat)

    @property
    def n_Q(self) -> int:
        """Number of stages Q, where k is evaluated."""
        return len(self.A)

    @property
    def r(self) -> int:
        """Number of q values carried."""
        return len(self.V)

    @property
    def r_hat(self) -> int:
        """Number of p values carried."""
        return len(self.V_hat)

    @property
    def palette(self) -> Palette:
        """Alternating colours on separable systems, else every colour below each."""
        return SEPARABLE if self.separable else GENERAL

    @property
    def diagonals(self) -> tuple[Vector | None, ...]:
        """D_P and D_Q."""
        return self.D_P, self.D_Q

    def bare(self, **changes: Any) -> Self:
        """Return a copy with other coefficients and without claims, source or start.

        The outputs stay where the numbers of values do.
        """
        return _without_file(self, {"V": "output", "V_hat": "output_hat"}, changes)

    def transform(self, T: Rows, T_hat: Rows | None = None) -> Self:
        """Carry ``T q`` and ``T_hat p`` instead of q and p: an equivalent pair.

        The starting method, the outputs and the bilinear form ``T^-* G T_hat^-1`` go along.

        Parameters
        ----------
        T : Rows
            (r, r) nonsingular.
        T_hat : Rows or None
            (r^, r^) nonsingular, or ``None`` to leave the values of p as they are.

        Raises
        ------
        ExactnessError
            When T or T_hat is singular.
        """
        T = _transformation(T, "T", self.r, "r")
        one = linalg.identity(self.r_hat)
        T_hat = one if T_hat is None else _transformation(T_hat, "T_hat", self.r_hat, "r^")
        return self.bare(
            **_transformed(self, (T, linalg.inverse(T)), (T_hat, linalg.inverse(T_hat))),
            D_P=self.D_P,
            D_Q=self.D_Q,
            embedded=self.embedded,
        )

    def permute_stages(self, Q: Sequence[int], P: Sequence[int] | None = None) -> Self:
        """Renumber the stages: the new Q_i is the old Q_j, j = ``Q[i]`` (from 0), P likewise.

        Parameters
        ----------
        Q : Sequence[int]
            Permutation of 0..n_Q-1.
        P : Sequence[int] or None
            Permutation of 0..n_P-1; by default that of Q, as it must be where stages are shared.
        """
        Q = _permutation(Q, "Q", self.n_Q)
        P = _permutation(Q if P is None else P, "P", self.n_P)
        if not self.separable and list(P) != list(Q):
            raise DataError(
                "the stages Q and P of a pair that is not separable are evaluated together: give "
                "one permutation for both"
            )
        return self.bare(
            **_renumbered(self, Q, P),
            D_P=self.D_P and tuple(self.D_P[i] for i in P),
            D_Q=self.D_Q and tuple(self.D_Q[i] for i in Q),
            embedded=tuple(row.permuted(P, Q) for row in self.embedded),
        )

    def weighted(self, B: tuple[Matrix, ...]) -> PartitionedGLM:
        """Return the pair with other weights, for one of its embedded rows."""
        one = ((Exact(1),),)
        return self.bare(
            B=B[0], U=one * self.n_Q, V=one, B_hat=B[1], U_hat=one * self.n_P, V_hat=one,
            output=None, output_hat=None,
        )  # fmt: skip
