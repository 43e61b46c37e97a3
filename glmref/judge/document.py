"""From the document of a method to its matrices A, U, B, V (section 1)."""

from __future__ import annotations

from collections.abc import Mapping

from .arithmetic import Fraction
from .claims import CLASSES, COMMON, FORMATS, MODIFIED, ORDERS, SECOND, SECOND_FORMAT
from .families import (
    Component,
    composition,
    linear_multistep,
    nystrom,
    nystrom_weights,
    one_leg,
    rosenbrock,
    rosenbrock_weights,
    runge_kutta,
    splitting,
)
from .fields import Numbers
from .grammar import may_be_declared
from .linalg import (
    apply,
    combine,
    diagonal,
    dot,
    identity,
    kernel,
    less,
    minus,
    multiples,
    ones,
    solve,
    star,
    times,
    transpose,
)
from .numbers import apart, inverse, is_enclosure, total, vanishes
from .refusals import Document, as_list, as_object, as_text, keys, not_covered, require, shown


def class_of(document: Document) -> str:
    """Return the class of a document that has the keys of its class, and no others."""
    kind = str(document.get("class"))
    require(kind in CLASSES, f"no class is called {kind[:40]!r}")
    needed, optional = CLASSES[kind]
    keys(document, needed + " class", COMMON + " " + optional, where="document")
    return kind


class Method:
    """Components with their colours, the palette, and what else the file gives."""

    def __init__(
        self,
        document: Mapping[str, object],
        numbers: Numbers,
        base: Mapping[str, object] | None = None,
    ) -> None:
        self.document, self.numbers = document, numbers
        kind = class_of(document)
        require(document.get("format", FORMATS[0]) in FORMATS, "another format")
        later = {kind, *(() if kind == "pair-sweep" else document)} & SECOND_FORMAT
        fine = document.get("format") != FORMATS[0] or not later
        require(fine, f"{', '.join(sorted(later))} belongs to {FORMATS[1]}")
        require(document.get("field", "real") in ("real", "complex"), "another field")
        require((base is not None) == (kind == "composition"), "a base belongs to compositions")
        names = [x for key in ("unknowns", "constants") for x in as_object(document.get(key, {}))]
        fine = all(map(may_be_declared, names)) and len({*names}) == len(names)
        require(fine, "a constant has a name that it cannot have")
        self.kind, self.base = kind, base
        made = getattr(self, "make_" + kind.replace("-", "_"))()
        self.pair, self.additive = type(made) is tuple, kind in ("additive", "rosenbrock")
        self.system = "rosenbrock" if kind == "rosenbrock" else ""
        self.parts: dict[str, Component] = (
            {"f": made[0], "k": made[1]} if self.pair else {"o": made}
        )
        if self.additive:
            self.parts = made
        blocks = {"o": document} if kind == "glm" else {}
        if kind == "partitioned":
            blocks = {c: as_object(document[key]) for c, key in (("f", "q"), ("k", "p"))}
        self.declared = {c: self.list("output", x) for c, x in blocks.items() if "output" in x}
        fixed = {"splitting": True, "pair-sweep": True, "partitioned-rk": False,
                 "nystrom": "A_prime" not in document}  # fmt: skip
        separable = document.get("separable", fixed.get(kind, False))
        require(type(separable) is bool, "separable is true or false")
        self.separable = self.pair and bool(separable)
        children = {"f": "k", "k": "f"} if self.separable else {}
        self.palette = tuple((c, children.get(c, "".join(self.parts))) for c in self.parts)

    def single(self) -> Component:
        """Return the component of a method that is no pair."""
        require("o" in self.parts, "the rule is for single methods")
        return self.parts["o"]

    def part(self, colour: object) -> Component:
        """Return the component of a colour."""
        require(isinstance(colour, str) and colour in self.parts, f"no component {colour!r}")
        return self.parts[str(colour)]

    def list(self, key: str, source: Document | None = None) -> list:
        """Return a vector of the document."""
        return self.numbers.vector((source or self.document).get(key), self.document)

    def matrix(self, key: str, source: Document | None = None) -> list:
        """Return a matrix of the document."""
        return self.numbers.matrix((source or self.document).get(key), self.document)

    def further(self, key: str) -> list:
        """Return the rows of X or Y beyond the first, of which there may be none."""
        return self.matrix(key) if self.document.get(key, []) != [] else []

    def form(self, key: str = "G") -> list:
        """Return a matrix that may be written as its diagonal."""
        return self.numbers.form(self.document[key], self.document)

    def make_glm(self, source: Document | None = None) -> Component:
        """Return the matrices as they stand."""
        return Component(*(self.matrix(key, source) for key in "AUBV"))

    def make_rk(self) -> Component:
        """Return A, U = 1, B = b, V = 1."""
        return runge_kutta(self.matrix("A"), self.list("b"))

    def make_composition(self) -> Component:
        """Return the base with steps gamma_1 h, gamma_2 h, .."""
        given = as_object(self.base)
        require(given.get("class") == "rk", "a base must be rk")
        require(given.get("name") == self.document.get("base"), "the base has another name")
        whole_base = Method(given, self.numbers)
        if "c" in given and not vanishes(gaps_of_rows(whole_base)):
            not_covered("a composition of a base with c apart")
        base = whole_base.single()
        return composition(base.A, base.B[0], self.list("gamma"))

    def multistep(self) -> tuple[list, list]:
        """Return alpha and beta of equal lengths."""
        alpha, beta = self.list("alpha"), self.list("beta")
        require(len(alpha) == len(beta) >= 2, "alpha and beta have other lengths")
        require(bool(alpha[-1]), "alpha_k is 0")
        return alpha, beta

    def make_lmm(self) -> Component:
        """Return the form with one stage and the values y and f that are needed."""
        alpha, beta = self.multistep()
        unit = inverse(alpha[-1])
        return linear_multistep(multiples(unit, alpha), multiples(unit, beta))

    def make_one_leg(self) -> Component:
        """Return the one-leg form."""
        alpha, beta = self.multistep()
        require(not apart(total(beta) - 1), "beta of a one-leg method does not sum to 1")
        unit = inverse(alpha[-1])
        return one_leg(multiples(unit, alpha), beta, unit)

    def make_sweep(self) -> Component:
        """Return B = X D, U = X^* G V, A from S = X^* G X."""
        X, d, V = self.matrix("X"), self.list("D"), self.matrix("V")
        left = times(star(X), self.form())
        S, none = times(left, X), self.numbers.explicit
        texts = as_list(as_object(self.document.get("enclosure", {})).get("equations", []))
        if none is None and any(str(text).startswith("explicit") for text in texts):
            not_covered("stages of a sweep that an equation makes explicit")
        for i, row in enumerate(S):
            own = Fraction(0) if i in (none or ()) else d[i] * row[i] * Fraction(1, 2)
            row[i:] = [own] + [Fraction(0)] * (len(d) - i - 1)
            row[:i] = [x * y for x, y in zip(d, row[:i], strict=False)]
        return Component(S, times(left, V), times(X, diagonal(d)), V)

    def make_partitioned(self) -> tuple[Component, Component]:
        """Return two methods as they stand."""
        for key in ("q", "p"):
            keys(self.document[key], "A U B V", "output", where=f"component {key}")
        return self.make_glm(as_object(self.document["q"])), self.make_glm(
            as_object(self.document["p"])
        )

    def make_partitioned_rk(self) -> tuple[Component, Component]:
        """Return two Runge-Kutta methods."""
        return self.make_rk(), runge_kutta(self.matrix("A_hat"), self.list("b_hat"))

    def make_additive(self) -> dict[str, Component]:
        """Return a Runge-Kutta method for each right-hand side; the colours are digits."""
        parts = as_list(self.document["parts"], "there are 2 to 9 parts")
        require(2 <= len(parts) <= 9, "there are 2 to 9 parts")
        for part in parts:
            keys(part, "A b", where="part")
        return {str(n): runge_kutta(self.matrix("A", part), self.list("b", part))
                for n, part in enumerate(parts, 1)}  # fmt: skip

    def make_rosenbrock(self) -> dict[str, Component]:
        """Return f - J with alpha and J with alpha + gamma below it, on two sets of stages."""
        alpha, gamma = self.matrix("alpha"), self.matrix("gamma")
        require(len(alpha) == len(gamma), "alpha and gamma have other shapes")
        parts = rosenbrock(alpha, combine(alpha, gamma), self.list("b"))
        return dict(zip("12", parts, strict=True))

    def make_nystrom(self) -> tuple[Component, ...]:
        """Return the pair q' = p, p' = k: the stages p and p + h k_l, from which Q is combined."""
        c, A = self.list("c"), self.matrix("A")
        inner = self.matrix("A_prime") if "A_prime" in self.document else None
        fits = [len(x) for x in A] == [len(c)] * len(c)
        require(fits, "A has another shape")
        fits = inner is None or [len(x) for x in inner] == [len(c)] * len(c)
        require(fits, "A_prime has another shape")
        return nystrom(A, c, inner, self.weights(self.document))

    def weights(self, source: Document) -> list:
        """Return the weights of a row of the file, for each component."""
        if self.kind == "additive":
            return self.matrix("b", source)
        b = self.list("b", source)
        if self.kind == "rosenbrock":
            return rosenbrock_weights(b)
        if self.kind == "nystrom":
            return nystrom_weights(b, self.list("b_prime", source), "A_prime" in self.document)
        return [b]

    def rows(self) -> dict[str, tuple[dict, dict]]:
        """Return {name: (weights of the solution, of the estimate) by colour} of `embedded`."""
        given = rows_of(self.document)
        own = {"rk": "b", "additive": "b", "nystrom": "b b_prime", "rosenbrock": "b", "glm": "b v"}
        require(not given or self.kind in own, "no rows are embedded here")
        found = {}
        for row in given:
            error = self.kind == "rk" and "error" in as_object(row)
            keys(row, "name " + ("error" if error else own[self.kind]), where="embedded")
            weights = self.weights({"b": row["error"]} if error else row)
            if self.kind == "glm":
                found[row["name"]] = {"o": (weights[0], self.list("v", row))}, {}
                continue
            require(len(weights) == len(self.parts), "embedded has another number of rows")
            weights = dict(zip(self.parts, weights, strict=True))
            fine = all(len(self.part(c).B[0]) == len(w) for c, w in weights.items())
            require(fine, "embedded has another length")
            other = {c: less(self.part(c).B[0], w) for c, w in weights.items()}
            found[row["name"]] = (other, weights) if error else (weights, other)
        return found

    def with_parts(
        self, parts: dict[str, Component], system: str = "", separable: bool | None = None
    ) -> Method:
        """Return this method with other components."""
        other = object.__new__(Method)
        other.__dict__.update(self.__dict__, parts=parts, system=system)
        other.pair = set(parts) == {"f", "k"}
        other.additive = set(parts) == {"1", "2"} or (self.additive and len(parts) > 1)
        if other.pair and not self.pair:
            other.separable, other.palette = False, (("f", "fk"), ("k", "fk"))
        if set(parts) == {"o"}:
            other.palette = (("o", "o"),)
        return other

    def for_claim(self, claim: str) -> Method:
        """Return the method that a claim is about."""
        if self.kind == "rosenbrock" and claim in ("a-stable", "l-stable"):
            beta = combine(self.matrix("alpha"), self.matrix("gamma"))
            return self.with_parts({"o": runge_kutta(beta, self.list("b"))})
        if self.kind == "rosenbrock":
            return self.with_parts(self.parts, "w" if claim == "w-order" else "rosenbrock")
        timed = claim in (*ORDERS, *SECOND) and claim not in MODIFIED
        if self.kind != "rk" or "c" not in self.document or not timed:
            return self
        m, c = self.single(), self.list("c")
        require(len(c) == len(m.A), "c has another length")
        if all(not is_enclosure(x) and not x for x in gaps_of_rows(self)):
            return self  # what is not decided is a c of its own, which A 1 is too
        require(claim in (*ORDERS, "stage-order"), "a claim with c apart")
        rest = [Fraction(0)] * (len(c) - 1)
        time = runge_kutta([[x, *rest] for x in c], [Fraction(1), *rest])
        return self.with_parts({"f": m, "k": time}, "time")

    def with_row(self, weights: Mapping[str, list]) -> Method:
        """Return the method with other weights by colour; of class glm with weights of the values.

        There the values after a step are moved along u, so that their output is the row.
        """
        if self.kind != "glm":
            parts = {c: runge_kutta(m.A, weights[c]) for c, m in self.parts.items()}
            return self.with_parts(parts, self.system)
        m, (b, v), u = self.single(), weights["o"], self.u("o")
        w = reading(self, "o", u)
        require(len(b) == len(m.A) and len(v) == m.r, "embedded has another length")

        def moved(M: list, own: list) -> list:
            gap = less(own, apply(transpose(M), w))
            return [[x + k * y for x, y in zip(r, gap, strict=True)]
                    for k, r in zip(u, M, strict=True)]  # fmt: skip

        return self.with_parts(
            {"o": Component(m.A, m.U, moved(m.B, b), moved(m.V, v))}, self.system
        )

    def make_splitting(self) -> tuple[Component, Component]:
        """Return the pair of a splitting: P stages from a, Q stages from b."""
        first, a, b = self.document["first"], self.list("a"), self.list("b")
        require(first in ("q", "p"), "first is q or p")
        more = len(a) - len(b) if first == "q" else len(b) - len(a)
        require(more in (0, 1), "the updates of q and p do not alternate")
        return splitting(a, b, str(first))

    def make_pair_sweep(self) -> tuple[Component, Component]:
        """Return the pair of a sweep through the letters of `stages`."""
        letters = as_text(self.document["stages"], "stages are letters P, Q")
        require(set(letters) <= set("PQ"), "stages are letters P, Q")
        P, Q = ([n for n, x in enumerate(letters) if x == y] for y in "PQ")
        G, b, c, zero = self.form(), self.list("b"), self.list("c"), Fraction(0)
        X = [ones(len(P)), *self.further("w")]
        Y = [ones(len(Q)), *self.further("v")]
        fits = all(len(x) == len(b) for x in (P, *X)) and all(len(y) == len(c) for y in (Q, *Y))
        require(fits and len(X) == len(G) and len(Y) == len(G[0]), "shapes of the pair")
        V, V_hat, S = self.matrix("V"), self.matrix("V_hat"), times(transpose(X), G, Y)
        below = [[P[i] < Q[j] for j in range(len(Q))] for i in range(len(P))]
        A = [[x * S[i][j] if below[i][j] else zero for i, x in enumerate(b)] for j in range(len(Q))]
        A_hat = [[zero if below[i][j] else x * S[i][j] for j, x in enumerate(c)]
                 for i in range(len(P))]  # fmt: skip
        U, U_hat = times(transpose(Y), transpose(G), V), times(transpose(X), G, V_hat)
        return (Component(A, U, times(X, diagonal(b)), V),
                Component(A_hat, U_hat, times(Y, diagonal(c)), V_hat))  # fmt: skip

    def check_shapes(self) -> None:
        """Refuse matrices that do not fit each other, and stages of a pair that do not meet."""
        stages = {len(m.A) for m in self.parts.values()}
        require(not self.additive or len(stages) == 1, "the parts have other stages")
        for c, m in self.parts.items():
            slopes, r = len(m.B[0]), m.r
            partner = self.parts["k" if c == "f" else "f"] if self.pair else m
            fits = len(m.A) == len(m.U) == len(partner.B[0]) and len(m.A[0]) == slopes
            fits = fits and len(m.U[0]) == len(m.V[0]) == len(m.B) == r
            fits = fits and (self.separable or len(m.A) == slopes)
            require(fits, f"shapes of component {c} do not fit")

    def vectors_to_one(self, colour: object, consistent: bool = False) -> tuple[list | None, bool]:
        """Return (u, whether it is the only one) with V u = u and U u = 1, u None where none is.

        Of a `consistent` method also B 1 + V v = u + v for some v: w u = w B 1 for all w = w V.
        """
        m = self.part(colour)
        shift = minus(m.V, identity(m.r))
        N, rows, right = kernel(shift), list(m.U), ones(len(m.U))
        if consistent:
            left = kernel(transpose(shift))
            rows, right = rows + left, right + apply(left, apply(m.B, ones(len(m.B[0]))))
        if not N:
            return None, True
        c, unique = solve([apply(N, row) for row in rows], right)
        return (None if c is None else apply(transpose(N), c)), unique

    def u(self, colour: str) -> list:
        """Return the u with V u = u and U u = 1, which must be the only one."""
        u, unique = self.vectors_to_one(colour)
        return shown(u if unique else None, "there is not one u with V u = u, U u = 1")


def rows_of(document: Document) -> list[Document]:
    """Return the rows of `embedded`; each has a name of its own, a string other than ``"b"``."""
    given = as_list(document.get("embedded", []), "embedded is a list")
    require(len(given) <= 20, "embedded is a list")
    names = [as_object(row).get("name") for row in given]
    require(all(isinstance(x, str) for x in names), "a row of embedded has no name")
    require(len({"b", *names}) == len(names) + 1, "a name stands twice in embedded")
    return given


def first_place(u: list) -> int:
    """Return the first place where u is not 0."""
    return shown(next((k for k, x in enumerate(u) if bool(x)), None), "u is 0")


def reading(method: Method, colour: str, u: list) -> list:
    """Return the row that reads the solution: as declared, or 1 / u_k at the first place k."""
    w = method.declared.get(colour)
    if w is None:
        k = first_place(u)
        return [inverse(u[k]) if j == k else Fraction(0) for j in range(len(u))]
    require(len(w) == len(u) and vanishes(dot(w, u) - 1), "the output does not read the solution")
    return w


def gaps_of_rows(method: Method) -> list:
    """Return A 1 - c, or of a Nystrom method 2 A 1 - c^2 and A' 1 - c."""
    if method.kind == "nystrom":
        A, c = method.matrix("A"), method.list("c")
        gaps = [2 * total(row) - x * x for row, x in zip(A, c, strict=True)]
        inner = method.matrix("A_prime") if "A_prime" in method.document else []
        return gaps + [total(row) - x for row, x in zip(inner, c, strict=False)]
    m = method.single()
    return less(apply(m.A, ones(len(m.A))), method.list("c"))
