"""Machine-checked proofs: a method's claims as theorems for the Coq proof assistant.

The file needs the library in ``checker/coq``. This module is trusted for nothing: it writes down
the method and witnesses (starting series, form, involution), and Coq computes every identity again.
What is written, by claim:

====================  ============================================================================
order                 one-step methods: the classical order conditions, and one tree that fails at
                      the next order; others: a starting series, over all trees; where its first
                      value is the solution, also one tree that fails at the next order
G-symplectic          G, D
symmetric             L, P
zero growth           X, y with B U = V X - X V + u y^T, so that w B U v = 0 for eigenvectors
====================  ============================================================================
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..catalogue import lookup as catalogue
from ..errors import ExactnessError, GlmrefError, UsageError
from ..exact import Exact, linalg
from ..exact.expression import to_text
from ..exact.linalg import Matrix, Vector, solve_affine
from ..method import GLM, Method, PartitionedGLM
from ..method.preconsistency import preconsistency_vector
from ..theory.coefficients import is_zero
from ..theory.order import OrderResult, order_of
from ..theory.symmetry import symmetry
from ..theory.symplectic import g_symplectic
from ..theory.trees import Tree
from .field import Tower, radicals_of

#: Largest order that is looked at: 719 trees have order 10.
MAX_ORDER = 10
#: The same for pairs, whose trees have two colours.
MAX_PAIR_ORDER = 8

_HEADER = """\
(* {title}

   Written by `python -m glmref.prove.coq {name}`, checked with the library in checker/coq. *)
From Coq Require Import List QArith.
From Glmref Require Import Trees Field GLM Symplectic NotOrder.
Import ListNotations.
Open Scope nat_scope.
"""


def to_coq(method: Method | str) -> str:
    """Write the claims of a method as theorems with proofs, for Coq.

    Parameters
    ----------
    method : Method or str
        An exact method, or the name of one in the catalogue.

    Raises
    ------
    UsageError
        For a method with decimals, where no identity is exact, and for additive and Rosenbrock
        methods, which the library in Coq does not know.
    """
    if isinstance(method, str):
        method = catalogue.load(method)
    if not method.is_exact:
        raise UsageError(
            f"the method {method.name!r} has decimal coefficients; "
            f"proofs for Coq are written for exact ones"
        )
    writer = _WRITERS.get(type(method))
    if writer is None:
        kind = "a Rosenbrock method" if method.rosenbrock else "an additive method"
        raise UsageError(
            f"the method {method.name!r} is {kind}; proofs for Coq are written for general linear "
            f"methods and pairs of them"
        )
    return writer(method).text()


#: The last step of a proof: the check is computed, and comes out true.
_COMPUTE = "vm_compute; reflexivity."


class _Writer:
    """Numbers, vectors, matrices and trees as Coq terms, in one tower.

    Everything is written twice: the first time the roots are collected that the numbers need, and
    only then is it known how deep a number is nested.
    """

    def __init__(self, method: Method) -> None:
        self.method = method
        self.name = file_stem(method.name)
        self.tower: Tower
        self.roots: dict[str, None] | None = {}
        self.definitions: list[str] = []
        self.theorems: list[tuple[str, str]] = []

    def text(self) -> str:
        self.write()
        assert self.roots is not None
        self.tower, self.roots = Tower(self.roots, conjugates=False), None
        self.definitions, self.theorems = [], []
        self.write()
        title = str((self.method.document or {}).get("title", self.method.name))
        header = _HEADER.format(title=_comment(title), name=_comment(self.method.name))
        tower = (
            "(* The roots, last one first: x^n = radicand. *)\n"
            f"Definition T : tower := {self.levels()}.\n"
        )
        proofs = [text for _, text in self.theorems]
        printed = "\n".join(f"Print Assumptions {name}." for name, _ in self.theorems)
        return "\n".join([header, tower, *self.definitions, *proofs, printed, ""])

    def write(self) -> None:
        raise NotImplementedError

    # -- terms -----------------------------------------------------------------------------------

    def number(self, x: Any) -> str:
        value = x if isinstance(x, Exact) else Exact(x)
        radicals: list[str] = []
        with suppress(ExactnessError):  # a number that has no such text lies in the field
            radicals = radicals_of(to_text(value))
        if self.roots is None:
            return self._nested(self.tower.coordinates(value, radicals), len(self.tower.degrees))
        self.roots |= dict.fromkeys(radicals)
        return ""

    def _nested(self, terms: Mapping[tuple[int, ...], Fraction], depth: int) -> str:
        """Return a polynomial in the last root whose coefficients lie in the levels below."""
        terms = {power: x for power, x in terms.items() if x}
        if not any(map(any, terms)):
            x = sum(terms.values(), Fraction(0))
            return f"Rat ({x.numerator}#{x.denominator})" if x else "Rat 0"
        parts: dict[int, dict[tuple[int, ...], Fraction]] = {}
        for power, x in terms.items():
            parts.setdefault(power[depth - 1], {})[power[: depth - 1]] = x
        text = self._nested(parts.get(max(parts), {}), depth - 1)
        text = text if text.startswith("Rat") else f"Ext ({text}) (Rat 0)"
        for k in range(max(parts) - 1, -1, -1):
            text = f"Ext ({self._nested(parts.get(k, {}), depth - 1)}) ({text})"
        return text

    def vector(self, xs: Sequence[Any]) -> str:
        return "[" + "; ".join(map(self.number, xs)) + "]"

    def matrix(self, rows: Sequence[Sequence[Any]]) -> str:
        return "[" + ";\n     ".join(map(self.vector, rows)) + "]"

    def tree(self, t: Tree, palette: str) -> str:
        """Graft the children, one after another."""
        colour = {"o": "tt", "f": "false", "k": "true"}[t.colour]
        text = f"leaf {palette} {colour}"
        for child in t.children:
            text = f"graft ({text}) ({self.tree(child, palette)})"
        return text

    def levels(self) -> str:
        """Return the tower, last root first; every radicand lies in the levels below its root."""
        items = []
        for depth, (n, x) in enumerate(zip(self.tower.degrees, self.tower.values, strict=True)):
            below = {k[:depth]: w for k, w in self.tower.coordinates(x**n).items() if w}
            items.append(f"({n}, {self._nested(below, depth)})")
        return "[" + "; ".join(reversed(items)) + "]"

    # -- parts of the file -------------------------------------------------------------------------

    def define(self, name: str, kind: str, value: str) -> None:
        self.definitions.append(f"Definition {name} : {kind} :=\n    {value}.\n")

    def theorem(self, suffix: str, statement: str, proof: str) -> None:
        """Write a theorem for every field and all roots in it."""
        name = f"{self.name}_{suffix}"
        text = (
            f"Theorem {name} : forall (F : field) (x : list F), roots_of F T x ->\n"
            f"  {statement}.\nProof. intros F x H. {proof} Qed.\n"
        )
        self.theorems.append((name, text))

    def block(self, letter: str, blocks: Sequence[Matrix]) -> None:
        A, U, B, V = (f"\n    {self.matrix(x)}" for x in blocks)
        value = f"@Build_glm (in_tower T){A}{U}{B}{V} {len(blocks[2][0])}"
        self.define(letter, "glm (in_tower T)", value)

    def best_order(self, most: int) -> OrderResult:
        """Write the order with identity, unless free principal parts give more."""
        same = order_of(self.method, max_order=most, principal="identity")
        if self.method.is_one_step:
            return same
        found = order_of(self.method, max_order=most, principal="free")
        return same if same.order == found.order else found

    def starting_series(self, found: OrderResult, palette: str, method: str, method_K: str) -> None:
        """Write the order with the starting series as witness, without trees of no weight."""
        eta, p = found.eta, found.order
        if eta is None:
            return
        support = eta.support()
        rows = [f"({self.tree(t, palette)}, {self.vector(x)})" for t, x in support.items()]
        self.define("eta", f"list (tree {palette} * list num)", "[" + ";\n     ".join(rows) + "]")
        colours = list(eta.palette)
        u = [self.vector(eta.empty(colour)) for colour in colours]
        choice = u[0] if len(u) == 1 else f"if c then {u[1]} else {u[0]}"
        self.define("u", f"{palette} -> list num", f"fun c => {choice}")
        first = all((eta.empty(colour)[0] - 1).is_zero() for colour in colours)
        identity = first and all(is_zero(x[0]) is True for x in support.values())
        value = f"({method})"
        proof = f"{palette} T {method_K} u eta F x H {p}); {_COMPUTE}"
        if identity:
            self.theorem(
                f"order_identity_{p}",
                f"has_order_identity {value} {p}",
                f"apply (@check_order_identity {proof}",
            )
            earlier = f"{self.name}_order_identity_{p}"
            self.theorem(
                f"order_{p}", f"has_order {value} {p}", f"apply identity_order, {earlier}, H."
            )
            self.not_order(found, palette, value, method_K)
        else:
            self.theorem(f"order_{p}", f"has_order {value} {p}", f"apply (@check_order {proof}")

    def not_order(self, found: OrderResult, palette: str, value: str, method_K: str) -> None:
        """Write a tree at which the next order fails; the series with the identity is unique."""
        t, p = found.failing_tree, found.order
        resolvents = [_resolvent(c.V) for c in self.method.components]
        solutions = [x for x in resolvents if x is not None]
        if t is None or found.residual is None or found.principal != "identity":
            return
        if len(solutions) < len(resolvents):  # 1 is no simple eigenvalue
            return
        Zs = [self.matrix(Z) for Z, _ in solutions]
        numbers = [self.vector(a) for _, a in solutions]
        for name, kind, texts in (("Z", "list (list num)", Zs), ("a", "list num", numbers)):
            choice = texts[0] if len(texts) == 1 else f"if c then {texts[1]} else {texts[0]}"
            self.define(name, f"{palette} -> {kind}", f"fun c => {choice}")
        (V,) = (c.V for c in self.method.components if c.colour == t.colour)
        (w,) = linalg.nullspace(linalg.transpose(linalg.sub(V, linalg.identity(len(V)))))
        assert found.eta is not None
        seen = linalg.dot(w, found.eta.empty(t.colour))
        residual = as_exact(found.residual)
        self.theorem(
            f"not_order_identity_{p + 1}",
            f"~ has_order_identity {value} {p + 1}",
            f"apply (@check_not_order_identity {palette} T {method_K} u eta Z a F x H\n"
            f"  {p} ({self.tree(t, palette)}) {self.vector(w)}\n"
            f"  ({self.number(1 / (residual * as_exact(seen)))})); {_COMPUTE}",
        )


def _resolvent(V: Matrix) -> tuple[Matrix, Vector] | None:
    """Return rows z and numbers a with z (I - V) + a e_1 = e_i: where 1 is simple and u_1 not 0."""
    r, rows, numbers = len(V), [], []
    shifted = linalg.transpose(linalg.sub(linalg.identity(r), V))
    system = tuple((*row, Exact(int(i == 0))) for i, row in enumerate(shifted))
    for unit in linalg.identity(r):
        found = solve_affine(system, unit)
        if found.failed is not None or found.undecided:
            return None
        rows.append(tuple(found.point[:r]))
        numbers.append(found.point[r])
    return tuple(rows), tuple(numbers)


def _comment(text: str) -> str:
    return text.replace("(*", "( *").replace("*)", "* )").replace('"', "'")


class _One(_Writer):
    """A general linear method; one that carries a single value is a Runge-Kutta method."""

    method: GLM

    def write(self) -> None:
        m = self.method
        if m.r == 1:
            self.define("a", "list (list num)", self.matrix(m.A))
            self.define("b", "list num", self.vector(m.B[0]))
            self.define("M", "glm (in_tower T)", "@rk (in_tower T) a b")
            self.one_step(order_of(m, max_order=MAX_ORDER, principal="identity"))
        else:
            self.block("M", (m.A, m.U, m.B, m.V))
            best = self.best_order(MAX_ORDER)
            self.starting_series(best, "rooted", "fun _ : rooted => method F x T M", "(fun _ => M)")
        self.form()
        self.symmetry()
        if m.r > 1:
            self.growth()

    def one_step(self, found: OrderResult) -> None:
        """Write the order by the classical conditions, and one tree that fails at the next."""
        p, values = found.order, "(matrix F x a) (vector F x b)"
        if p:
            proof = f"apply (@check_rk_order T a b F x H {p}); {_COMPUTE}"
            self.theorem(f"order_{p}", f"rk_order {values} {p}", proof)
        t = found.failing_tree
        if t is not None and found.residual is not None:
            inverse = 1 / as_exact(found.residual)
            term = self.tree(t, "rooted")
            self.theorem(
                f"not_order_{p + 1}",
                f"~ rk_order {values} {p + 1}",
                f"apply (@check_rk_not_order T a b F x H {p + 1} ({term})\n"
                f"  ({self.number(inverse)})); {_COMPUTE}",
            )

    def form(self) -> None:
        """Return G-symplecticity where it holds with plain transposes: of real methods."""
        m = self.method
        found, u = g_symplectic(m), preconsistency_vector(m)
        if not found.holds or not m.is_real or found.G is None or found.D is None or u is None:
            return
        size = 1 / as_exact(linalg.dot(u, linalg.matvec(found.G, u)))
        self.theorem(
            "symplectic" if m.r == 1 else "g_symplectic",
            "g_symplectic (method F x T M)",
            f"apply (@check_g_symplectic T F x H M\n  {self.matrix(found.G)}\n"
            f"  {self.vector(found.D)}\n  {self.vector(u)} ({self.number(size)})); {_COMPUTE}",
        )

    def symmetry(self) -> None:
        m = self.method
        found = symmetry(m)
        if not found.holds or found.reduced or found.L is None or found.P is None:
            return
        inverse = linalg.inverse(m.V)
        self.theorem(
            "symmetric",
            "symmetric (method F x T M)",
            f"apply (@check_symmetric_value T F x H M\n  {self.matrix(found.L)}\n"
            f"  {self.matrix(inverse)} [{'; '.join(map(str, found.P))}]); {_COMPUTE}",
        )

    def growth(self) -> None:
        m, u = self.method, preconsistency_vector(self.method)
        solution = None if u is None else commutator(m, u)
        if solution is None or u is None:
            return
        X, y = solution
        self.theorem(
            "no_growth",
            "no_growth (method F x T M)",
            f"apply (@check_no_growth T F x H M\n  {self.matrix(X)}\n"
            f"  {self.vector(u)} {self.vector(y)}); {_COMPUTE}",
        )


def as_exact(x: Any) -> Exact:
    """Pass an exact number, where the types allow for a ball."""
    assert isinstance(x, Exact)
    return x


def commutator(m: GLM, u: Vector) -> tuple[Matrix, Vector] | None:
    """Solve B U = V X - X V + u y^T for X and y, which proves that no component grows.

    Returns
    -------
    tuple[Matrix, Vector] or None
        X (r, r) and y (r,), or ``None`` where there are none.
    """
    r, zero = m.r, Exact(0)
    target = linalg.matmul(m.B, m.U)
    rows, right = [], []
    for i in range(r):
        for j in range(r):
            row: list[Any] = [zero] * (r * r + r)
            for k in range(r):
                row[k * r + j] = row[k * r + j] + m.V[i][k]
                row[i * r + k] = row[i * r + k] - m.V[k][j]
            row[r * r + j] = u[i]
            rows.append(tuple(row))
            right.append(target[i][j])
    found = solve_affine(tuple(rows), tuple(right))
    if found.failed is not None or found.undecided:
        return None
    point = found.point
    return tuple(point[i * r : (i + 1) * r] for i in range(r)), point[r * r :]


class _Pair(_Writer):
    """A pair of methods for q' = f, p' = k."""

    method: PartitionedGLM

    def write(self) -> None:
        m = self.method
        palette = "separable" if m.separable else "general"
        for name, component in zip(("Mq", "Mp"), m.components, strict=True):
            self.block(name, component.matrices)
        self.define("M", f"{palette} -> glm (in_tower T)", "fun c => if c then Mp else Mq")
        choice = self.best_order(MAX_PAIR_ORDER)
        self.starting_series(choice, palette, f"fun c : {palette} => method F x T (M c)", "M")
        form = g_symplectic(m)
        G, D_P, D_Q = form.G, form.D_P, form.D_Q
        if choice.eta is None or not form.holds or G is None or D_P is None or D_Q is None:
            return
        u, v = choice.eta.empty("f"), choice.eta.empty("k")
        size = 1 / as_exact(linalg.dot(u, linalg.matvec(G, v)))
        self.theorem(
            "g_symplectic",
            f"pair_g_symplectic {str(not m.separable).lower()} (method F x T Mq) (method F x T Mp)",
            f"apply (@check_pair_g_symplectic T F x H {str(not m.separable).lower()} Mq Mp\n"
            f"  {self.matrix(G)}\n  {self.vector(D_P)}\n  {self.vector(D_Q)}\n"
            f"  {self.vector(u)} {self.vector(v)} ({self.number(size)})); {_COMPUTE}",
        )


_WRITERS = {GLM: _One, PartitionedGLM: _Pair}


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the files of the methods named."""
    parser = argparse.ArgumentParser(
        prog="python -m glmref.prove.coq", description="Write proofs for Coq."
    )
    parser.add_argument("names", nargs="+", metavar="NAME", help="exact methods of the catalogue")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="one file for each, m_NAME.v")
    options = parser.parse_args(arguments)
    for name in options.names:
        try:
            text = to_coq(name)
        except GlmrefError as error:
            sys.stderr.write(f"{error}\n")
            return 2
        if options.output is None:
            sys.stdout.write(text)
        else:
            options.output.mkdir(parents=True, exist_ok=True)
            (options.output / f"{file_stem(name)}.v").write_text(text, encoding="utf-8")
    return 0


def file_stem(name: str) -> str:
    """Return the name of the Coq file and first part of the theorems' names: ``m_gauss_2``."""
    return "m_" + "".join(x if x.isalnum() else "_" for x in name)


if __name__ == "__main__":
    sys.exit(main())
