"""Certificates: what was proved about a file, written so that others can check it.

The format is ``glmref-certificate-1`` (``docs/certificates.md``). The kernel decides first; then
its series, and the witnesses it was handed, are written down; a statement that rests on an
enclosure gets its interval test. What has no certificate, such as a method that declares an
output, is said with the reason.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any, Self

from ..catalogue.claims import (
    A_STABLE,
    ABSCISSAE,
    CLAIMS,
    DENSE_END,
    DENSE_ORDER,
    EFFECTIVE_ORDER,
    EMBEDDED_DIFFERENCE,
    EMBEDDED_ORDER,
    FINISHING_ORDER,
    GROWTH,
    L_STABLE,
    NYSTROM_ORDER,
    NYSTROM_STARTING_ORDER,
    ORDER,
    ORDER_IDENTITY,
    REDUCIBLE,
    ROW_SUMS,
    STAGE_ORDER,
    STARTING_ORDER,
    SYMMETRIC,
    W_ORDER,
)
from ..catalogue.files import document as shipped_document
from ..errors import ExactnessError
from ..exact import Exact, linalg
from ..exact.expression import parse, to_text
from ..exact.linalg import Matrix, Vector
from ..findings import Proof, Verdict
from ..method.embedded import EmbeddedRow
from ..theory import polynomials as poly
from ..theory.coefficients import apply, is_zero, plus, times
from ..theory.root_location import in_closed_disc, is_schur
from .algebra import (
    bounded,
    consistency_vectors,
    diagonal_values,
    difference,
    involutions,
    is_exact,
    preconsistency,
    scalars,
)
from .certificate_enclosed import equation_numbers, method_proof, start_proofs
from .field import Tower, radicals_of, written_out
from .finders import proposal_for
from .forest import Paths
from .kernel import Judgement, Kernel
from .series import StartingSeries, component, read

FORMAT = "glmref-certificate-1"
Part = dict[str, Any]
#: Claims about something that a file may lack: the key of the file.
_ABOUT = {
    EMBEDDED_DIFFERENCE.key: "embedded",
    ROW_SUMS.key: "c",
    DENSE_END.key: "dense",
    DENSE_ORDER.key: "dense",
    STARTING_ORDER.key: "starting",
    FINISHING_ORDER.key: "finishing",
}
_PROSE = frozenset({"name", "title", "source", "notes", "broken", "claims", "enclosure", "stages"})


def certificates_of(
    facts: Any, statements: Mapping[str, tuple[object, Judgement]]
) -> Iterator[tuple[str, dict[str, Any] | str]]:
    """Write the certificate of every statement, or say why there is none.

    Yields
    ------
    tuple[str, dict[str, Any] or str]
        (claim, certificate or reason).
    """
    proofs = _Proofs(facts)
    for claim, (declared, judgement) in statements.items():
        try:
            yield claim, _certificate(facts, claim, declared, judgement, proofs)
        except ExactnessError as error:
            yield claim, str(error)


def _trees(series: StartingSeries, nystrom: bool) -> str:
    """Which trees a series is about, in the words of a certificate."""
    if isinstance(series.trees, Paths):
        return "nystrom-paths" if nystrom else "paths"
    return "nystrom" if nystrom else "all"


class _Proofs:
    """The interval tests of one file, each made at most once."""

    def __init__(self, facts: Any) -> None:
        self.facts, self.document = facts, facts.method.document

    @cached_property
    def method(self) -> dict[str, Any]:
        """The test of the method, where the file has an enclosure."""
        if "enclosure" not in self.document:
            return {}
        claims = self.document["claims"]
        order = max(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key, NYSTROM_ORDER.key))
        return {"method": method_proof(self.document, order + 1)}

    @cached_property
    def starts(self) -> dict[str, Any]:
        """The tests of the start and of the finish."""
        return start_proofs(self.document, self.facts.method)

    def field(self, claim: str, parts: list[Part]) -> dict[str, Any]:
        """The field of a statement about decimals; the same for all that need no start."""
        document = self.document
        plain = {k: v for k, v in document.items() if k not in ("unknowns", "claims")}
        if document.get("class") == "composition":
            plain = {"x": [plain, shipped_document(document["base"])]}
        elif not self.facts.method.is_exact:
            plain = {k: v for k, v in plain.items() if k not in ("starting", "finishing")}
        found = _field(plain, [{"rule": "", "witness": equation_numbers(document)}, *parts], [])
        kept = {k: found.get(k, empty) for k, empty in (("generators", []), ("radicals", {}))}
        if self.facts.implied is None:
            return {"kind": "balls", **kept}
        proofs = dict(self.method)
        if claim in (STARTING_ORDER.key, NYSTROM_STARTING_ORDER.key, FINISHING_ORDER.key):
            proofs |= self.starts
        return {"kind": "enclosure", **kept, "proofs": proofs}


def _certificate(
    facts: Any, claim: str, declared: Any, judged: Judgement, proofs: _Proofs
) -> dict[str, Any]:
    if judged.verdict is Verdict.OPEN:
        raise ExactnessError("the claim is open")
    enclosed = judged.proof is not Proof.EXACT or not facts.kernel.exact
    document = facts.method.document
    if document is None:
        raise ExactnessError("a method without a file has no certificate")
    writer = (_EnclosedWriter if enclosed else _Writer)(facts, claim, declared, judged)
    parts = writer.parts()
    kept = {k: v for k, v in document.items() if k not in ("claims", "source", "notes", "title")}
    kept = {**kept, "claims": {claim: declared}}
    found = {
        "format": FORMAT,
        "statement": {
            "method": facts.method.name,
            "claim": claim,
            "declared": declared,
            "verdict": str(judged.verdict),
            "proof": str(judged.proof),
        },
        "document": kept,
        "field": proofs.field(claim, parts) if enclosed else _field(kept, parts, declared),
        "parts": parts,
        "identities": writer.identities,
    }
    if document.get("class") == "composition":
        found["base"] = dict(shipped_document(document["base"]))
        if not enclosed:
            found["field"] = _field({"x": [kept, found["base"]]}, parts, declared)
    return found


def _strings(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            if key not in _PROSE:
                yield from _strings(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _strings(inner)


def _field(document: Mapping[str, Any], parts: list[Part], declared: Any) -> dict[str, Any]:
    constants = dict(document.get("constants", {}))
    entries = [written_out(x, constants) for x in _strings({**document, "constants": {}})]
    entries += [written_out(constants[x], constants) for x in constants]
    entries += [x for part in parts for x in _numbers(part["witness"])]
    entries += [written_out(x, constants) for x in _strings(declared)]
    radicals: dict[str, None] = {}
    for text in entries:
        if "sqrt" in text or "root" in text or "exp" in text or "i" in text:
            radicals |= dict.fromkeys(radicals_of(text))
    return Tower(radicals).as_json()


def _numbers(value: Any) -> Iterator[str]:
    """Strings of a witness that are numbers: words such as rules and trees hold none of these."""
    for text in _strings(value):
        if any(x in text for x in ("sqrt(", "root(", "exp(")) or text in ("i", "-i"):
            yield text


def _vector(values: Vector) -> list[str]:
    found = scalars(values)
    if not is_exact((found,)):
        raise ExactnessError("a number that the proof needs is known to its decimals only")
    return [to_text(x) for x in found]


def _matrix(rows: Matrix) -> list[list[str]]:
    return [_vector(row) for row in rows]


class _Reduced:
    """What a writer asks of facts, for a method without a file."""

    def __init__(self, method: Any) -> None:
        self.method, self.kernel = method, Kernel(method)


class _Writer:
    """The parts of one statement."""

    def __init__(self, facts: Any, claim: str, declared: Any, judged: Judgement) -> None:
        self.facts, self.claim, self.declared, self.judged = facts, claim, declared, judged
        self.kernel: Kernel = facts.kernel
        self.identities: list[str] = []
        self.holds = judged.verdict is Verdict.HOLDS

    def parts(self) -> list[Part]:
        """The parts that prove the statement."""
        return [{"rule": "absent", "witness": {}}] if self._absent() else self._parts()

    def _absent(self) -> bool:
        """Whether the file has nothing that the claim is about."""
        document = self.facts.method.document or {}
        if self.claim == EMBEDDED_ORDER.key:
            rows = {x.name for x in self.facts.method.embedded}
            return not rows or set(self.declared) != rows
        key = _ABOUT.get(self.claim)
        return key is not None and not document.get(key) and not (
            key == "starting" and self.kernel.is_pair
        )  # fmt: skip

    def _parts(self) -> list[Part]:
        method = self.facts.method
        if method.rosenbrock and self.claim in (A_STABLE.key, L_STABLE.key):
            return self._of(method.linear_form, self.claim).parts()
        special = getattr(self, f"_{CLAIMS[self.claim].rule}", None)
        if special is not None:
            return special()
        if self.claim in (ORDER_IDENTITY.key, EFFECTIVE_ORDER.key, NYSTROM_ORDER.key):
            free = self.claim == EFFECTIVE_ORDER.key
            return self._order_parts(free=free, nystrom=self.claim == NYSTROM_ORDER.key)
        raise ExactnessError(f"certificates of {self.claim!r} are not written yet")

    def _of(self, method: Any, claim: str) -> _Writer:
        """The writer of the same statement about another method."""
        return _Writer(type(self.facts)(method), claim, self.declared, self.judged)

    # -- what stands beside a tableau

    def _embedded_order(self) -> list[Part]:
        found = []
        for row in self.facts.method.embedded:
            inner = self._of_row(row)
            found.append({"rule": "row", "witness": {"row": row.name, "parts": inner.parts()}})
            self.identities += inner.identities
        return found

    def _of_row(self, row: EmbeddedRow) -> Self:
        """The writer of the order of a row."""
        facts = type(self.facts)(self.facts.method.with_row(row))
        return type(self)(facts, self.kernel.row_claim, self.declared[row.name], self.judged)

    def _order_to_digits(self) -> list[Part]:
        found = self.kernel.to_digits(self.declared)
        for name, x in found.items():
            if not x.truth:
                shown = {"tree": x.largest} if x.largest else {"order": x.order}
                return [{"rule": "not-to-digits", "witness": {"row": name, **shown}}]
        trees = {name: {"largest": x.largest, "beyond": x.beyond} for name, x in found.items()}
        self.identities += [
            f"residuals of {name} through order {p}: at most {e}"
            for name, (p, e) in self.declared.items()
        ]
        return [{"rule": "to-digits", "witness": {"rows": trees}}]

    def _embedded_difference(self) -> list[Part]:
        return self._simple("differences", "no-differences")

    def _row_sums(self) -> list[Part]:
        return self._simple("row-sums", "no-row-sums")

    def _dense_end(self) -> list[Part]:
        return self._simple("dense-end", "no-dense-end")

    def _dense_order(self) -> list[Part]:
        found = self.kernel.range(DENSE_ORDER.key)
        if found.upper is None or found.lower != found.upper:
            raise ExactnessError("the order is not settled")
        return [{"rule": "dense", "witness": {"order": found.upper, "tree": found.tree}}]

    def _w_order(self) -> list[Part]:
        return self._of(self.facts.method.with_any_matrix(), ORDER.key).parts()

    # -- orders

    def _order(self) -> list[Part]:
        return self._order_parts(free=not self.kernel.one_step)

    def _order_parts(self, *, free: bool, nystrom: bool = False) -> list[Part]:
        if self.kernel.timed is not self.kernel:
            return self._of(self.kernel.timed.method, self.claim)._order_parts(
                free=free, nystrom=nystrom
            )
        found = self.kernel.order_range(free=free, nystrom=nystrom)
        if found.upper is None or found.lower != found.upper:
            raise ExactnessError("the order is not settled")
        p = found.upper
        if p == 0:
            return [self._no_order()]
        # along paths the series with the identity as principal part serves a free one too
        series = self.kernel.series[free and (free, nystrom) in self.kernel.series, nystrom]
        if not series.complete:
            raise ExactnessError("the eigenvalue 1 of V is multiple, and the series not unique")
        names = {
            "principal": "free" if free else "identity",
            "trees": _trees(series, nystrom),
        }
        below = {"order": p, **names, **self._series(series, p)}
        above = {"order": p, **names, "same": True, **self._left_and_right(series)}
        above["n"] = self._functional(series, p, found.tree, free=free, nystrom=nystrom)
        count = sum(1 for n in range(1, p + 1) for t in series.trees.level(n) if series.counts(t))
        self.identities.append(f"B xiD(t) + V eta(t) = (E eta)(t), {count} trees")
        self.identities.append(f"the condition of {found.tree} is not zero, order {p + 1}")
        return [
            {"rule": "order-at-least", "witness": below},
            {"rule": "order-at-most", "witness": above},
        ]

    def _series(self, series: StartingSeries, p: int, eta: Any = None) -> dict[str, Any]:
        values = series.eta if eta is None else eta
        u = {c: _vector(x.u) for c, x in series.components.items()}
        wanted = [t for n in range(1, p + 1) for t in series.trees.level(n) if series.counts(t)]
        if not any(t in values for t in wanted):
            return {"u": u, "eta": "zero"}
        return {
            "u": u,
            "eta": {
                series.trees.text[t]: _vector(values.get(t, Kernel._none(t, series)))
                for t in wanted
            },
        }

    @staticmethod
    def _left_and_right(series: StartingSeries) -> dict[str, Any]:
        W, N = {}, {}
        for c, x in series.components.items():
            r = len(x.u)
            W[c] = [[to_text(Exact(0) + dict(row).get(j, 0)) for j in range(r)] for row in x.W]
            N[c] = [list(row) for row in zip(*map(_vector, x.N), strict=True)]
        return {"W": W, "N": N}

    @staticmethod
    def _functional(
        series: StartingSeries, p: int, tree: str, *, free: bool, nystrom: bool
    ) -> dict[str, list[str]]:
        """Rational numbers n(t) with n L = 0 that see the residual of one tree."""
        trees = series.trees
        if isinstance(trees, Paths) and free:
            return {trees.text[t]: ["1"] for t in trees.level(p + 1)}
        if not series.simple:
            return _Writer._wide_functional(series, p, free=free)
        if not free or p == 0:
            return {tree: ["1"]}
        smaller, larger = trees.level(p), trees.level(p + 1)

        def row(t: int) -> dict[int, Fraction]:
            found = {s: Fraction(-n) for s, n in trees.cuts[t].items() if trees.order[s] == p}
            if len(trees.children[t]) == 1:
                child = trees.children[t][0]
                found[child] = found.get(child, Fraction(0)) + 1
            return found

        # express the row of the failing tree in the rows of the determining trees
        rows = {t: row(t) for t in larger if t in series.determined} if p > 1 else {}
        target = row(trees.text.index(tree))
        if not any(target.values()):
            return {tree: ["1"]}
        if p == 1:
            system = [row(t) for t in larger]
            kept = tuple(tuple(Exact(x.get(s, Fraction(0))) for x in system) for s in smaller)
            residuals = [scalars([series.residual(t)[0]])[0] for t in larger]
            for n in linalg.nullspace(kept):
                if linalg.dot(n, residuals).is_zero() is False:
                    pairs = zip(larger, n, strict=True)
                    return {trees.text[t]: _vector((x,)) for t, x in pairs if not x.is_zero()}
            raise ExactnessError("no combination of the conditions refutes order 2")
        place = {s: j for j, s in enumerate(smaller)}
        names = list(rows)
        system = [tuple(Exact(rows[t].get(s, Fraction(0))) for t in names) for s in place]
        right = [(Exact(-target.get(s, Fraction(0))),) for s in place]
        solution = linalg.solve(tuple(system), tuple(right))
        n = {trees.text[t]: _vector(x) for t, x in zip(names, solution, strict=True)}
        return {tree: ["1"], **{t: x for t, x in n.items() if x != ["0"]}}

    @staticmethod
    def _wide_functional(series: StartingSeries, p: int, *, free: bool) -> dict[str, list[str]]:
        """The same for one method with several eigenvectors: a null vector that sees a residual."""
        trees, (c,) = series.trees, series.components.values()
        d, larger = len(c.N), trees.level(p + 1)
        place = {t: k * d for k, t in enumerate(larger)}
        images = [apply(c.W, apply(c.B, apply(c.U, x))) for x in c.N]
        units = linalg.identity(d)
        parts = units if free else linalg.nullspace((tuple(read(c, x) for x in c.N),))
        rows = []
        for s in trees.level(p):
            for e in parts:
                row = [Exact(0)] * (d * len(larger))
                for t in larger:
                    ways = trees.cuts[t].get(s, 0)
                    for i in range(d):
                        value = Exact(-ways) * e[i]
                        if trees.children[t] == (s,):
                            value += sum((images[j][i] * e[j] for j in range(d)), Exact(0))
                        row[place[t] + i] = value
                rows.append(tuple(row))
        residual = [x for t in larger for x in scalars(apply(c.W, series._right(t)))]
        for n in linalg.nullspace(tuple(rows)) if rows else linalg.identity(len(residual)):
            if linalg.dot(n, residual).is_zero() is False:
                values = {t: _vector(n[place[t] : place[t] + d]) for t in larger}
                return {trees.text[t]: x for t, x in values.items() if set(x) != {"0"}}
        raise ExactnessError("no combination of the conditions refutes the next order")

    def _no_order(self) -> Part:
        """Left null vectors of the linear system of u and v, the right side not zero."""
        for c, (_, U, B, V) in self.kernel.blocks.items():
            if not is_exact(U, B, V):
                if is_exact(V) and self._other_u(U, B, V):
                    return {"rule": "no-order-1", "witness": {"colour": c}}
                if not is_exact(U, V):
                    continue
            r = len(V)
            D = linalg.sub(V, linalg.identity(r))
            total = linalg.matvec(B, (Exact(1),) * len(B[0]))
            nil = (Exact(0),) * r
            rows = [(*row, *nil) for row in D] + [(*row, *nil) for row in U]
            right = [Exact(0)] * r + [Exact(1)] * len(U)
            for i, row in enumerate(D):
                rows.append((*(Exact(-int(i == j)) for j in range(r)), *row))
                right.append(-total[i])
            for x in linalg.nullspace(linalg.transpose(tuple(rows))):
                if linalg.dot(x, right).is_zero() is False:
                    s = len(U)
                    self.identities.append("u and v of consistency do not exist")
                    return {
                        "rule": "no-order-1",
                        "witness": {
                            "colour": c, "x": _vector(x[:r]), "y": _vector(x[r : r + s]),
                            "z": _vector(x[r + s :]),
                        },
                    }  # fmt: skip
        raise ExactnessError("order 1 is not excluded by consistency")

    @staticmethod
    def _other_u(U: Matrix, B: Matrix, V: Matrix) -> bool:
        """Whether U u is not 1 for the u with W u = W B 1."""
        D = linalg.sub(V, linalg.identity(len(V)))
        right, left = linalg.nullspace(D), linalg.nullspace(linalg.transpose(D))
        if not right:
            return True
        pairing = linalg.matmul(tuple(left), linalg.transpose(tuple(right)))
        if linalg.rank(pairing) < len(right):
            return False
        slopes = linalg.matvec(tuple(left), linalg.matvec(B, (Exact(1),) * len(B[0])))
        parts = linalg.matvec(linalg.inverse(pairing), slopes)
        u = linalg.matvec(linalg.transpose(tuple(right)), parts)
        return any((x - 1).is_zero() is False for x in linalg.matvec(U, u))

    def _stage_order(self) -> list[Part]:
        found = self.kernel.range(STAGE_ORDER.key)
        parts = self._order()
        q = found.upper
        if q == 0 and parts[0]["rule"] == "no-order-1":
            return parts
        if q is None or found.lower != q or parts[0]["rule"] != "order-at-least":
            raise ExactnessError("the stage order is not settled")
        tree = (
            self._failing_stage(parts[0]["witness"], q) if q < parts[0]["witness"]["order"] else ""
        )
        return [
            *parts,
            {"rule": "stage-order-at-least", "witness": {"q": q}},
            {"rule": "stage-order-at-most", "witness": {"q": q, "tree": tree}},
        ]

    def _failing_stage(self, witness: Mapping[str, Any], q: int) -> str:
        series = self.kernel.timed.series[witness["principal"] == "free", False]
        trees = series.trees
        none = Kernel._none
        c = {
            trees.colour[t]: series.stage(t, series.eta.get(t, none(t, series)))
            for t in trees.level(1)
        }
        for t in filter(series.counts, trees.level(q + 1)):
            power = times(Fraction(1, trees.density[t]), series.power(c[trees.colour[t]], q + 1))
            defect = plus(series.stage(t, series.eta.get(t, none(t, series))), times(-1, power))
            if witness["principal"] == "free" and q + 1 == witness["order"]:
                defect = series.fixed_stages(trees.colour[t], defect)
            if is_zero(defect) is False:
                return trees.text[t]
        raise ExactnessError("no stage was found that is not the solution")

    def _starting_order(self, *, nystrom: bool = False) -> list[Part]:
        kernel = self.kernel
        claim = NYSTROM_STARTING_ORDER.key if nystrom else STARTING_ORDER.key
        found, free = kernel.range(claim), not kernel.is_pair
        known = kernel.order_range(free=free, nystrom=nystrom)
        if found.upper is None or found.lower != found.upper:
            raise ExactnessError("the order of the start is not settled")
        if known.upper == 0 and kernel.exact:
            return [self._no_order()]
        if not known.value or (free, nystrom) not in kernel.series:
            raise ExactnessError("the order of the start is not settled")
        if not kernel._exact_start():
            raise ExactnessError("certificates of enclosed starts are not written yet")
        q, p, series = found.upper, known.value, kernel.series[free, nystrom]
        given = kernel._start_series(series, p)
        eta = dict(kernel._shifted(series, given, p) if free else series.eta)
        trees = series.trees
        failing: dict[str, Any] = {"tree": ""}
        for n in range(1, min(q + 1, p) + 1):
            for t in (t for t in trees.level(n) if series.counts(t)):
                own = eta.get(t, Kernel._none(t, series))
                gap = scalars([plus(x, times(-1, y)) for x, y in zip(given[t], own, strict=True)])
                if n == p and free:
                    fixed = kernel._without_principal(series, t, gap)
                    if n <= q:
                        eta[t] = plus(own, tuple(difference(gap, fixed)))
                    gap = fixed
                bad = next((i for i, x in enumerate(gap) if not x.is_zero()), None)
                if bad is not None and not failing["tree"]:
                    failing = {"tree": trees.text[t], "value": bad + 1}
        block = {"order": p, **self._series(series, p, eta)}
        block["trees"] = _trees(series, nystrom)
        self.identities.append(f"the start agrees with the series through order {q}")
        return [
            *self._order_parts(free=free, nystrom=nystrom),
            {"rule": "start-at-least", "witness": {"q": q, **block}},
            {"rule": "start-at-most", "witness": {"q": q, **block, **failing}},
        ]

    def _finishing_order(self) -> list[Part]:
        found = self.kernel.range(FINISHING_ORDER.key)
        parts = self._order_parts(free=not self.kernel.one_step)
        p, q = parts[0]["witness"]["order"], found.upper
        if q is None or found.lower != q or not self.kernel._exact_start():
            raise ExactnessError("the order of the finish is not settled")
        more = {"tree": found.reason.split()[1]} if q < p else {}
        return [
            *parts,
            {"rule": "finish-at-least", "witness": {"q": q}},
            {"rule": "finish-at-most", "witness": {"q": q, **more}},
        ]

    def _symmetric_reduced(self) -> list[Part]:
        """The method without idle values, which is minimal, and its symmetry."""
        proposed = self._witness()
        smaller = proposed["reduced"]
        inner = _Writer(_Reduced(smaller), SYMMETRIC.key, self.declared, self.judged)
        blocks = {k: _matrix(getattr(smaller, k)) for k in "UBV"}
        if self._truth():
            Ls, exchanges = proposed["involutions"]
            witness = {"L": _matrix(Ls[0]), "P": list(exchanges["o"])}
            last = [{"rule": "symmetric", "witness": witness}]
        else:
            last = inner._not_symmetric()
        return [
            {"rule": "equivalent", "witness": blocks},
            {"rule": "irreducible", "witness": {}},
            *last,
        ]

    def _nystrom_starting_order(self) -> list[Part]:
        return self._starting_order(nystrom=True)

    # -- true or false

    def _truth(self) -> bool:
        return bool(self.declared) == self.holds

    def _witness(self) -> Mapping[str, Any]:
        return proposal_for(self.facts, self.claim).witness()

    def _simple(self, good: str, bad: str) -> list[Part]:
        return [{"rule": good if self._truth() else bad, "witness": {}}]

    def _vectors(self, *, v: bool) -> Part:
        u: dict[str, Any] = {}
        w: dict[str, Any] = {}
        for c, (A, U, B, V) in self.kernel.blocks.items():
            if not v and not is_exact(U, V):  # U u = 1 all the same
                one = component(A, U, B, V).u
                if not is_exact((one,)):
                    raise ExactnessError("u is not exact")
                u[c] = _vector(one)
                continue
            if not is_exact(U, B, V) and v:
                return {
                    "rule": "consistent",
                    "witness": {"u": self._vectors(v=False)["witness"]["u"]},
                }
            both = consistency_vectors(U, B, V) if v else None
            one = both[0] if both else preconsistency(U, V)
            assert one is not None
            u[c] = _vector(one)
            if both:
                w[c] = _vector(both[1])
        rule = "consistent" if v else "preconsistent"
        return {"rule": rule, "witness": {"u": u, "v": w} if v else {"u": u}}

    def _consistent(self) -> list[Part]:
        return [self._vectors(v=True)] if self._truth() else [self._no_order()]

    def _preconsistent(self) -> list[Part]:
        return [self._vectors(v=False) if self._truth() else self._no_vector()]

    def _no_vector(self) -> Part:
        """A combination of V u = u, U u = 1 that contradicts itself, or two entries of U u."""
        for c, (_, U, _, V) in self.kernel.blocks.items():
            r = len(V)
            if not is_exact(U):
                differing = self._differing_stages(U, V)
                if differing is not None:
                    witness = {"colour": c, "rows": differing}
                    return {"rule": "not-preconsistent", "witness": witness}
                continue
            rows = (*linalg.sub(V, linalg.identity(r)), *U)
            right = [Exact(0)] * r + [Exact(1)] * len(U)
            for x in linalg.nullspace(linalg.transpose(rows)):
                if linalg.dot(x, right).is_zero() is False:
                    witness = {"colour": c, "x": _vector(x[:r]), "y": _vector(x[r:])}
                    return {"rule": "not-preconsistent", "witness": witness}
        raise ExactnessError("no vector refutes preconsistency")

    @staticmethod
    def _differing_stages(U: Matrix, V: Matrix) -> list[int] | None:
        """Two stages where U u differs for the one u = V u; 0 twice where V has no such u."""
        if not is_exact(V):
            return None
        fixed = linalg.nullspace(linalg.sub(V, linalg.identity(len(V))))
        if len(fixed) != 1:
            return None if fixed else [0, 0]
        x = linalg.matvec(U, fixed[0])
        pairs = ([i, j] for i in range(len(U)) for j in range(i))
        return next((p for p in pairs if (x[p[0]] - x[p[1]]).is_zero() is False), None)

    def _bounded(self, c: str) -> Part:
        V = self.kernel.blocks[c][3]
        if not is_exact(V):  # the block with eigenvalues on the circle
            exact = (x for x in self._blocks(V) if is_exact(x))
            on_circle = (x for x in exact if not is_schur(poly.characteristic_polynomial(x)))
            V = next(on_circle, ((Exact(0),),))
        q, h = self._circle(V)
        once = _vector(poly.squarefree(q))
        return {"rule": "bounded", "witness": {"which": c, "q": once, "h": _vector(h)}}

    @staticmethod
    def _blocks(V: Matrix) -> list[Matrix]:
        """Diagonal blocks of V in the order of the page: by the values in them."""
        groups = sorted(diagonal_values(V))
        return [tuple(tuple(V[i][j] for j in group) for i in group) for group in groups]

    @staticmethod
    def _circle(V: Matrix) -> tuple[Any, Any]:
        """Factors of the characteristic polynomial of V: what it shares with its mirror image."""
        h = poly.characteristic_polynomial(V)
        q: Any = (Exact(1),)
        low = 0
        while h[low].is_zero():
            low += 1
        zeros, rest = h[:low], h[low:]
        while len(rest) > 1:
            shared = poly.gcd(rest, poly.reciprocal(rest))
            if len(shared) <= 1:
                break
            rest, q = poly.divide(rest, shared)[0], poly.mul(q, shared)
        return q, (*zeros, *rest)

    def _unbounded(self) -> Part:
        """A root outside the circle, or a defective one on it, of the first V that has one."""
        c = next(c for c, b in self.kernel.blocks.items() if bounded(b[3]) is False)
        value: dict[str, Any] = {"charpoly": True}
        V, where = self.kernel.blocks[c][3], {}
        if not is_exact(V):
            blocks = self._blocks(V)
            where["block"] = next(i for i, x in enumerate(blocks) if bounded(x) is False)
            V = blocks[where["block"]]
        if is_exact(V):
            q, h = self._circle(V)
            if in_closed_disc(poly.mul(q, h)):
                value["chain"] = {"q": _vector(q), "h": _vector(h)}
        return {"rule": "unbounded", "witness": {"which": c, "value": value, **where}}

    def _zero_stable(self) -> list[Part]:
        if self._truth():
            return [self._bounded(c) for c in self.kernel.blocks]
        return [self._unbounded()]

    def _symplectic(self) -> list[Part]:
        if self._truth():
            return [{"rule": "quadratic", "witness": {}}]
        if not self.kernel.one_step:
            return [{"rule": "not-quadratic", "witness": {"several-values": True}}]
        if self.kernel.is_pair:
            (A, _, (b,), _), (A_hat, _, (b_hat,), _) = (
                self.kernel.blocks["f"], self.kernel.blocks["k"]
            )  # fmt: skip
        else:
            A, _, (b,), _ = self.kernel.blocks["o"]
            A_hat, b_hat = A, b
        for i in range(len(b)):
            for j in range(len(b_hat)):
                value = b[i] * A_hat[i][j] + b_hat[j] * A[j][i] - b[i] * b_hat[j]
                if value.is_zero() is False:
                    return [{"rule": "not-quadratic", "witness": {"entry": [i, j]}}]
        gaps = [x - y for x, y in zip(b, b_hat, strict=True)]
        at = next((i for i, x in enumerate(gaps) if x.is_zero() is False), None)
        if at is None:
            raise ExactnessError("no entry refutes the identity")
        return [{"rule": "not-quadratic", "witness": {"weight": at}}]

    def _g_symplectic(self) -> list[Part]:
        proposed = self._witness()
        if self._truth():
            G, diagonals = proposed.get("form") or self._eliminated_form()
            names = ("D_P", "D_Q") if self.kernel.is_pair else ("D",)
            witness = {"G": _matrix(G)}
            witness |= {n: _vector(d) for n, d in zip(names, diagonals, strict=True)}  # type: ignore[misc]
            return [self._vectors(v=False), {"rule": "form", "witness": witness}]
        if proposed.get("given"):
            G, diagonals = proposed["form"]
            names = ("V", "P", "Q", "A", "real", "shared") if self.kernel.is_pair else (
                "V", "U", "A", "hermitian", "real"
            )  # fmt: skip
            residuals = self.kernel._form_residuals(G, diagonals)
            for name, matrix in zip(names, residuals, strict=False):
                for i, j, x in linalg.entries(matrix):
                    if x.is_zero() is False:
                        where = {"identity": name, "entry": [i, j]}
                        return [{"rule": "given-form-fails", "witness": where}]
            ignored = {"rule": "given-form-fails", "witness": {"identity": "solution"}}
            return [self._vectors(v=False), ignored]
        return self._no_form()

    def _eliminated_form(self) -> tuple[Matrix, list[Vector]]:
        """A form that no finder proposes."""
        vectors = [preconsistency(b[1], b[3]) for b in self.kernel.blocks.values()]
        u, u_hat = vectors[0], vectors[-1]
        assert u is not None and u_hat is not None
        found = self.kernel.some_form(u, u_hat)
        assert found is not None
        return found

    def _no_form(self) -> list[Part]:
        """Factors of the identities whose sum is u^* G u, whatever G and D are."""
        kernel = self.kernel
        vectors = [preconsistency(b[1], b[3]) for b in kernel.blocks.values()]
        u, u_hat = vectors[0], vectors[-1]
        if u is None or u_hat is None:
            return [self._no_vector()]
        values, columns, labels = kernel.form_system(u, u_hat)
        # x (columns) = values: a combination of the identities
        rows = [(*row, -value) for row, value in zip(columns, values, strict=True)]
        whole = next((x for x in linalg.nullspace(tuple(rows)) if not x[-1].is_zero()), None)
        if whole is None:
            raise ExactnessError("no combination of the identities was found")
        factors = [x / whole[-1] for x in whole[:-1]]

        def sign(name: str) -> int:  # the page has V^* G V^ on the left of a pair
            return -1 if kernel.is_pair and name == "V" else 1

        chosen = [
            {"identity": name, "entry": [i, j], "part": part, "factor": to_text(x * sign(name))}
            for (name, i, j, part), x in zip(labels, factors, strict=True)
            if not x.is_zero() and name != "shared"  # the page has D_P = D_Q in every unit
        ]
        return [self._vectors(v=False), {"rule": "no-form", "witness": {"lambda": chosen}}]

    def _symmetric(self) -> list[Part]:
        kernel = self.kernel
        if self._truth():
            Ls, exchanges = self._witness()["involutions"]
            if kernel.is_pair:
                witness = {
                    "L": _matrix(Ls[0]), "L_hat": _matrix(Ls[1]),
                    "P_Q": list(exchanges["f"]), "P_P": list(exchanges["k"]),
                }  # fmt: skip
            else:
                witness = {"L": _matrix(Ls[0]), "P": list(exchanges["o"])}
            return [{"rule": "symmetric", "witness": witness}]
        return self._not_symmetric()

    def _not_symmetric(self) -> list[Part]:
        kernel = self.kernel
        for c, (_, _, _, V) in kernel.blocks.items():
            null = linalg.nullspace(V)
            if null:
                where = {"singular": _vector(null[0])} | ({"which": c} if kernel.is_pair else {})
                return [{"rule": "not-symmetric", "witness": where}]
        relations, sizes = kernel.exchange_problem(
            {c: linalg.inverse(b[3]) for c, b in kernel.blocks.items()}
        )
        found = involutions(relations, sizes)
        if not found:
            return [{"rule": "not-symmetric", "witness": {"stages": True}}]
        values = [{"P": list(P), "functional": True} for P in found]
        return [{"rule": "not-symmetric", "witness": {"values": values}}]

    def _explicit(self) -> list[Part]:
        if self._truth():
            order = self.kernel.explicit_order()
            return [{"rule": "explicit", "witness": {"order": order}}]
        return [{"rule": "implicit", "witness": {"cycle": self.kernel.cycle()}}]

    def _abscissae(self) -> list[Part]:
        blocks = self.kernel.blocks
        shown = self.judged.reason.split()
        at = int(shown[1]) - 1 if shown[:1] == ["number"] else -1
        if not all(is_exact(*block[1:]) for block in blocks.values()):
            if "no abscissae" in self.judged.reason:
                return [self._no_order()]
            if self.holds:
                raise ExactnessError("the abscissae of decimals are enclosed, not proved")
            return [{"rule": "other-abscissae", "witness": {"stage": at}}]
        witness: dict[str, Any] = {"u": {}, "v": {}}
        for c, (_, U, B, V) in blocks.items():
            both = consistency_vectors(U, B, V)
            if both is None:
                return [self._no_order()]
            u, v = both
            k = next(i for i, x in enumerate(u) if not x.is_zero())
            v = tuple(x - v[k] / u[k] * y for x, y in zip(v, u, strict=True))
            witness["u"][c], witness["v"][c] = _vector(u), _vector(v)
        if self.holds:
            return [{"rule": "abscissae", "witness": witness}]
        return [{"rule": "other-abscissae", "witness": {**witness, "stage": at}}]

    def _error_constant(self) -> list[Part]:
        multistep = self.facts.method.multistep
        assert multistep is not None
        alpha, beta = multistep
        p, defect = -2, Exact(0)
        while defect.is_zero():
            p += 1
            q, defect = p + 1, Exact(0)
            for m, (a, b) in enumerate(zip(alpha, beta, strict=True)):
                defect = defect + a * m**q - (b * (q * m ** (q - 1)) if q else Exact(0))
        rule = "error-constant" if self.holds else "other-error-constant"
        return [{"rule": rule, "witness": {"order": p}}]

    def _reducible(self) -> list[Part]:
        if not self._truth():
            return [{"rule": "irreducible", "witness": {}}]
        for c in self.kernel.blocks:
            reached, seen = self.kernel.reached_and_seen(c)
            for name, rows in (("y", seen), ("x", reached)):
                null = linalg.nullspace(rows) if is_exact(rows) else ()
                if null:
                    return [
                        {"rule": "reducible", "witness": {"component": c, name: _vector(null[0])}}
                    ]
        raise ExactnessError("no value is idle")

    def _a_stable(self) -> list[Part]:
        if self._truth():
            return [self._bounded("o"), {"rule": "a-stable", "witness": {}}]
        reason = self.judged.reason
        if "at z = " in reason and "modulus" in reason:
            y = reason.rsplit("at z = ", 1)[1].removesuffix(" i")
            return [{"rule": "not-a-stable", "witness": {"y": y}}]
        if "power-bounded at z = " in reason:
            y = reason.rsplit("at z = ", 1)[1].removesuffix(" i")
            return [{"rule": "not-a-stable", "witness": {"defect": y}}]
        kind = (
            "infinity" if "infinity" in reason
            else "pole" if "pole" in reason
            else "start" if "M(0)" in reason
            else "axis"
        )  # fmt: skip
        part = {"rule": "not-a-stable", "witness": {kind: True}}
        if kind != "start":
            return [part]
        return [self._unbounded(), part]

    def _l_stable(self) -> list[Part]:
        if self._truth():
            return [
                self._bounded("o"), {"rule": "a-stable", "witness": {}},
                {"rule": "l-limit", "witness": {}},
            ]  # fmt: skip
        if "do not all tend to 0" in self.judged.reason:
            return [{"rule": "not-l-limit", "witness": {}}]
        return self._a_stable()

    # -- growth

    def _eigen(self) -> tuple[list[Part], dict[str, Any]]:
        proposed = self._witness()
        parts: list[Part] = []
        for c in self.kernel.blocks:
            if c not in proposed:
                raise ExactnessError(proposed.get("why", "eigenvalues are not known"))
            found, h = proposed[c]
            parts.append({
                "rule": "eigen",
                "witness": {
                    "which": c,
                    "parts": [
                        {"zeta": to_text(z), "W": _matrix(tuple(W)),
                         "N": _matrix(linalg.transpose(tuple(N)))}
                        for z, W, N in found
                    ],
                    "h": _vector(h),
                },
            })  # fmt: skip
        return parts, dict(proposed)

    def _real_growth(self, proposed: Mapping[str, Any]) -> None:
        """Refuse decimals at an eigenvalue that is not real: the intervals of a checker are."""
        decimals = not all(is_exact(U, B) for _, U, B, _ in self.kernel.blocks.values())
        if decimals and not all(z.is_real() for parts, _ in proposed.values() for z, *_ in parts):
            raise ExactnessError("growth of decimals at an eigenvalue that is not real")

    def _unshared(self) -> list[Part]:
        """Of a separable pair without a shared eigenvalue but 1; empty where that is not so."""
        values = [b[3] for b in self.kernel.blocks.values()]
        if not self.kernel.is_pair or self.kernel.shared or not is_exact(*values):
            return []
        if not poly.share_only_one(*map(poly.characteristic_polynomial, values)):
            return []
        bounded = [self._bounded(c) for c in self.kernel.blocks]
        return [*bounded, {"rule": "unshared", "witness": {}}]

    def _growth(self) -> list[Part]:
        if self.kernel._unstable():
            return [self._unbounded()]
        if unshared := self._unshared():
            return unshared
        parts, proposed = self._eigen()
        declared = self.declared if isinstance(self.declared, list) else []
        if self.holds:
            self._real_growth(proposed)
            sizes = [len(W) - int((z - 1).is_zero()) for z, W, _ in proposed.get("o", ([], ()))[0]]
            lists, at = [], 0
            for size in sizes:
                lists.append([str(x) for x in declared[at : at + size]])
                at += size
            return [*parts, {"rule": "growth", "witness": {"list": lists}}]
        return [*parts, {"rule": "grows", "witness": {"part": self._growing(declared)}}]

    def _growing(self, declared: list[Any]) -> int:
        """The part whose parameters are others than declared, or -1: their number is another."""
        groups = self.kernel._growth_matrices(self._witness())
        if self.kernel.is_pair:  # the claim is about what the halves feed each other
            groups = [(zeta, found[:2]) for zeta, found in groups]
        first = [not self.kernel.is_pair and bool((zeta - 1).is_zero()) for zeta, _ in groups]
        sizes = [
            sum(len(m) - one for m in found) for one, (_, found) in zip(first, groups, strict=True)
        ]
        if sum(sizes) != len(declared):
            return -1
        self._real_growth(self._witness())
        numbers = [parse(str(x)) for x in declared]
        for k, (one, (_, found)) in enumerate(zip(first, groups, strict=True)):
            mine, numbers = numbers[: sizes[k]], numbers[sizes[k] :]
            if self.kernel.is_pair:
                if any(x.is_zero() is False for m in found for row in m for x in row):
                    return k
            elif len(found[0]) > one or mine:
                wanted = [Exact(1), *mine] if one else mine
                if self.kernel._same_spectrum(found[0], wanted).truth is False:
                    return k
        raise ExactnessError("no growth parameter is another one than declared")

    def _parasitism_free(self) -> list[Part]:
        if self.kernel._unstable():
            return self._growth()
        if self._truth() and (unshared := self._unshared()):
            return unshared
        parts, proposed = self._eigen()
        self._real_growth(proposed)
        if self._truth():
            return [*parts, {"rule": "growth", "witness": {"list": "zero"}}]
        matrices = self.kernel._growth_matrices(self._witness())
        for k, (zeta, found) in enumerate(matrices):
            if not self.kernel.is_pair and (zeta - 1).is_zero():
                if self.kernel._only_principal(found[0]) is False:
                    return [*parts, {"rule": "grows", "witness": {"part": k}}]
                continue
            if any(x.is_zero() is False for m in found for row in m for x in row):
                return [*parts, {"rule": "grows", "witness": {"part": k}}]
        raise ExactnessError("growth at the eigenvalue 1 is not written out")


class _EnclosedWriter(_Writer):
    """The parts of a statement about decimals: the one exact method in them, or all of them."""

    def _parts(self) -> list[Part]:
        claim, kernel = self.claim, self.kernel
        if CLAIMS[claim].type is int:
            return self._range()
        if claim == EMBEDDED_ORDER.key:
            return self._rows()
        if claim == REDUCIBLE.key and not self._truth():
            return [{"rule": "irreducible", "witness": {}}]
        if claim == SYMMETRIC.key and not self._truth():
            for c, (_, _, _, V) in kernel.blocks.items():
                null = linalg.nullspace(V) if is_exact(V) else ()
                if null:
                    where: dict[str, Any] = {"which": c} if kernel.is_pair else {}
                    where["singular"] = _vector(null[0])
                    return [{"rule": "not-symmetric", "witness": where}]
            return [{"rule": "not-symmetric", "witness": {"stages": True}}]
        if claim == ABSCISSAE.key and kernel.implied is None:
            return self._abscissae()
        implied = kernel.implied
        growing = claim == GROWTH.key and implied and implied.growth_zeros is not None
        listed = claim == ABSCISSAE.key and self.holds
        follows = implied and (listed or (claim in implied.true and self._truth()))
        if growing or follows:
            self.identities.append("decided at the one root of the equations of the file")
            return [{"rule": "implied", "witness": {}}]
        return super()._parts()

    def _rows(self) -> list[Part]:
        """Every row; of a claim that fails, without equations, one whose order is another."""
        kernel = self.kernel
        if kernel.implied is not None:
            return [self._row(name, x) for name, x in kernel.row_kernels]
        if self.holds:
            return super()._embedded_order()
        nystrom = kernel.row_claim == NYSTROM_ORDER.key
        for row, (name, x) in zip(self.facts.method.embedded, kernel.row_kernels, strict=True):
            found = x.order_range(free=False, nystrom=nystrom)
            if found.upper is not None and found.upper < self.declared[name]:
                parts = self._bounds(free=False, nystrom=nystrom, kernel=x)[1:]
            elif found.lower > self.declared[name]:
                inner = self._of_row(row)
                parts = inner._exact_order(free=False, nystrom=nystrom)[:1]
            else:
                continue
            return [{"rule": "row", "witness": {"row": name, "parts": parts}}]
        raise ExactnessError("no row has another order within the digits")

    def _range(self) -> list[Part]:
        claim = self.claim
        if claim == DENSE_ORDER.key:
            found = self.kernel.range(claim)
            rule = "dense" if self.holds else "not-dense"
            return [{"rule": rule, "witness": {"order": found.upper, "tree": found.tree}}]
        if claim == FINISHING_ORDER.key or "starting-order" in claim:
            try:
                return super()._parts() if self.kernel.implied is None else self._of_start()
            except ExactnessError:
                return self._of_start()
        free = claim == EFFECTIVE_ORDER.key
        if claim in (ORDER.key, STAGE_ORDER.key):
            free = not self.kernel.one_step
        nystrom = claim == NYSTROM_ORDER.key
        kernel = self.kernel.any_matrix if claim == W_ORDER.key else self.kernel
        found = kernel.order_range(free=free, nystrom=nystrom)
        if found.upper == 0 and not found.tree and not self.holds:
            try:
                return [self._no_order()]
            except ExactnessError:
                return [self._no_vector()]
        if claim == STAGE_ORDER.key and self.kernel.implied is None:
            return self._stages(free=free)
        if (self.holds and self.kernel.implied is None) or found.lower > self.declared:
            return self._exact_order(free=free, nystrom=nystrom)
        parts = self._bounds(free=free, nystrom=nystrom, kernel=kernel)
        if claim != STAGE_ORDER.key:
            if not self.holds and parts[0]["witness"]["order"] > self.declared:
                parts[0]["witness"] = parts[0]["witness"] | {"order": self.declared + 1}
                return parts[:1]
            return parts if self.holds else parts[1:]
        stages, p = self.kernel.range(claim), parts[0]["witness"]["order"]
        q = stages.upper
        if q is None or (q >= p and self.holds) or (stages.lower != q and self.holds):
            raise ExactnessError("the stage order is not settled")
        if not self.holds and q > self.declared:
            more = {"rule": "implied-stage-order", "witness": {"q": self.declared + 1}}
            return [parts[0], more]
        if q >= p:
            return parts[1:]
        tree = self._failing_stage(parts[0]["witness"], q)
        above = {"rule": "not-stage-order", "witness": {"q": q, "tree": tree}}
        if not self.holds:
            return [above]
        return [*parts, {"rule": "implied-stage-order", "witness": {"q": q}}, above]

    def _exact_order(self, *, free: bool, nystrom: bool) -> list[Part]:
        """An order that no entry in decimals touches; of the last trees no eta is written."""
        try:
            return super()._parts()
        except ExactnessError:
            kernel = self.kernel.timed
            series, p = kernel.series[free, nystrom], kernel.order_range(free=free, nystrom=nystrom)
            if free and kernel.method.system:
                raise
            if p.upper == 0:
                return self._bounds(free=free, nystrom=nystrom)[1:]
            given = p.lower - (free or not kernel.one_step)
            if not series.simple or isinstance(series.trees, Paths) or not p.lower:
                raise
        names = {"principal": "free" if free else "identity", "trees": _trees(series, nystrom)}
        first = {"order": p.lower, **names, **self._series(series, given)}
        if given < p.lower:
            first["last"] = "solvable"
        last = {"order": p.lower, **names, "tree": p.tree}
        return [
            {"rule": "order-at-least", "witness": first},
            *([{"rule": "not-order", "witness": last}] if self.holds else []),
        ]

    def _stages(self, *, free: bool) -> list[Part]:
        """The stage order of decimals: with the order where that is settled, else without it."""
        stages, parts = self.kernel.range(STAGE_ORDER.key), []
        if self.holds or stages.lower > self.declared:
            try:
                return super()._parts()
            except ExactnessError:
                if free:  # the series is unique where the order is known
                    raise
            order = {"order": max(stages.lower, 1), "principal": "identity", "trees": "all"}
            series = self._series(self.kernel.timed.series[False, False], order["order"])
            parts = [
                {"rule": "order-at-least", "witness": {**order, **series}},
                {"rule": "stage-order-at-least", "witness": {"q": stages.lower}},
            ]
            if not self.holds:
                return parts
        elif stages.upper == self.kernel.order_range(free=free).upper:
            return self._bounds(free=free, nystrom=False)[1:]
        assert stages.upper is not None, "the verdict rests on it"
        beyond = {"principal": "free" if free else "identity", "order": stages.upper + 1}
        tree = self._failing_stage(beyond, stages.upper)
        witness = {"q": stages.upper, "tree": tree}
        return [*parts, {"rule": "not-stage-order", "witness": witness}]

    def _row(self, name: str, kernel: Kernel) -> Part:
        parts = self._bounds(free=False, nystrom=False, kernel=kernel)
        return {"rule": "row", "witness": {"row": name, "parts": parts}}

    def _bounds(self, *, free: bool, nystrom: bool, kernel: Kernel | None = None) -> list[Part]:
        found = (kernel or self.kernel).order_range(free=free, nystrom=nystrom)
        if found.upper is None:
            raise ExactnessError("the order is not settled")
        names = {
            "order": found.upper,
            "principal": "free" if free else "identity",
            "trees": "nystrom" if nystrom else "all",
        }
        self.identities.append(
            f"the condition of {found.tree} is not zero, order {found.upper + 1}"
        )
        return [
            {"rule": "implied-order", "witness": names},
            {"rule": "not-order", "witness": {**names, "tree": found.tree}},
        ]

    def _of_start(self) -> list[Part]:
        claim, kernel = self.claim, self.kernel
        finish, nystrom = claim == FINISHING_ORDER.key, claim == NYSTROM_STARTING_ORDER.key
        free = not kernel.one_step and not kernel.is_pair
        found = kernel.range(claim)
        q = found.upper
        own = kernel.order_range(free=not kernel.is_pair, nystrom=nystrom)
        if own.upper == 0:
            if not own.tree:
                return [self._no_order()]
            return self._bounds(free=not kernel.is_pair, nystrom=nystrom)[1:]
        if not self.holds:
            free = not kernel.is_pair
            if q is not None and q == own.upper:
                return self._bounds(free=free, nystrom=nystrom)[1:]
            more = self._failing_start(nystrom) if kernel.is_pair else {
                "tree": "" if "multiple of y" in found.reason else "o"
            }  # fmt: skip
            return [{"rule": "not-start", "witness": {"q": q, **more}}]
        if kernel.exact:
            parts = [*self._order_parts(free=True), *self._symmetric_part()]
        else:
            parts = self._bounds(free=free, nystrom=nystrom)
        name, top = ("finish", "finish-at-most") if finish else ("start", "not-start")
        more = {}
        if q is None or found.lower != q:
            raise ExactnessError("the order of the start is not settled")
        if q < parts[0]["witness"]["order"]:
            more = self._failing_start(nystrom)
        return [
            *parts,
            {"rule": f"implied-{name}", "witness": {"q": q}},
            {"rule": top, "witness": {"q": q, **more}},
        ]

    def _symmetric_part(self) -> list[Part]:
        proposed = proposal_for(self.facts, SYMMETRIC.key).witness()
        if "involutions" not in proposed:
            raise ExactnessError("the method is not symmetric")
        Ls, exchanges = proposed["involutions"]
        witness = {"L": _matrix(Ls[0]), "P": list(exchanges["o"])}
        return [{"rule": "symmetric", "witness": witness}]

    def _failing_start(self, nystrom: bool) -> dict[str, Any]:
        """The first tree at which the start of a pair is certainly wrong, and the value."""
        kernel = self.kernel
        if not kernel.is_pair:
            raise ExactnessError("the order of the start is not written out")
        kernel.order_range(free=False, nystrom=nystrom)
        series = kernel.series[False, nystrom]
        found = kernel.range(self.claim)
        given = kernel._start_series(series, (found.upper or 0) + 1)
        for t in series.trees.level((found.upper or 0) + 1):
            if not series.counts(t):
                continue
            own = series.eta.get(t, Kernel._none(t, series))
            for k, x in enumerate(difference(given[t], own)):
                if x.is_zero() is False:
                    return {"tree": series.trees.text[t], "value": k + 1}
        raise ExactnessError("no tree refutes the start")
