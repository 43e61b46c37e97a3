"""Certificates: what was proved about a file, written so that others can check it.

The format is ``glmref-certificate-1`` (``docs/certificates.md``). The kernel finds what is true;
then its series, and the witnesses it was handed, are written down; a statement that rests on an
enclosure gets its interval test. Nothing is decided here: that is what the judge does with what was
written (:mod:`.verdicts`). What has no certificate is said with the reason.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from types import SimpleNamespace
from typing import Any, ClassVar

from ..catalogue.claims import (
    A_STABLE,
    ABSCISSAE,
    CLAIMS,
    CONJUGATE_SYMPLECTIC,
    CONJUGATE_SYMPLECTIC_ORDER,
    DENSE_ORDER,
    EMBEDDED_ORDER,
    FINISHING_ORDER,
    GROWTH,
    L_STABLE,
    NYSTROM_ORDER,
    NYSTROM_STARTING_ORDER,
    ORDER,
    STARTING_ORDER,
    SYMMETRIC_REDUCED,
    W_ORDER,
)
from ..catalogue.files import document as shipped_document
from ..catalogue.keys import ABOUT
from ..errors import ExactnessError, UsageError
from ..exact import linalg
from ..exact.expression import to_text
from ..exact.judging import consulted, proof_of
from ..exact.linalg import Matrix, Vector
from ..findings import Proof
from ..judge.claims import MODIFIED, ORDERS, SECOND, alternatives
from ..judge.refusals import Refused
from ..system.budget import fits
from ..system.shown import above
from ..theory import polynomials as poly
from ..theory.coefficients import scalars
from ..theory.forms import choose_form
from ..theory.judged import judged_parts
from ..theory.residues import residues
from ..theory.stability import SAMPLES
from ..theory.starting_series import Judged, StartingSeries
from ..theory.symmetry import Symmetry, symmetry
from ..theory.symplectic import find_forms
from .field import Texts, about, field_of_decimals, texts_of_decimals, tower_of
from .kernel import KINDS, Found, Kernel

FORMAT = "glmref-certificate-1"
Part = dict[str, Any]
#: The parts before one that is proposed, and what may be its witness.
Parts = tuple[Part, ...]
Witnesses = Iterator[dict[str, Any]]


def certificates_of(
    facts: Any, claim: str, declared: object, found: Found
) -> Iterator[dict[str, Any] | str]:
    """Write the certificates that may prove what was found, or say why there is none.

    Of an open question of truth the judge searches: it accepts one of several, or none.
    """
    try:
        yield from _certificates(facts, claim, declared, found)
    except ExactnessError as error:
        yield str(error)


class Shared:
    """What the certificates of one file share: its interval tests and its number fields."""

    def __init__(self, facts: Any) -> None:
        self.facts = facts

    @cached_property
    def document(self) -> Mapping[str, Any]:
        """The document of the method; of one without a file that which ``save`` writes.

        Raises
        ------
        ExactnessError
            For a method without a file that no file can hold exactly.
        """
        method = self.facts.method
        if method.document is not None:
            return method.document
        if not method.is_exact:
            raise ExactnessError("a method without a file, in numbers that are not exact")
        try:
            return above("exchange.documents", "method_document")(method, method.name, None)
        except UsageError as error:
            raise ExactnessError(f"a method without a file: {error}") from error

    @cached_property
    def method(self) -> dict[str, Any]:
        """The test of the method, where the file has an enclosure."""
        implied = self.facts.implied
        return {} if implied is None or implied.root is None else {"method": implied.root.proof}

    @cached_property
    def exact_texts(self) -> Texts:
        """The entries of a file whose numbers are exact."""
        kept = {k: v for k, v in self.document.items() if k != "claims"}
        base = shipped_document(kept["base"]) if kept.get("class") == "composition" else None
        return Texts(kept if base is None else {"x": [kept, base]})

    @cached_property
    def enclosed_texts(self) -> Texts:
        """The exact entries of a file with decimals."""
        return texts_of_decimals(self.document, exact=self.facts.method.is_exact)

    def judged(
        self, nystrom: bool, free: bool, trees: bool | str, row: str | None = None
    ) -> Judged | None:
        """Return the series that the judge has of the method and keeps for its certificates.

        It may be that of an embedded row. There is none of decimals, of a method that the judge
        does not read, and where 1 is a multiple eigenvalue: the finder then looks for more.
        """
        try:
            with consulted() as judge:
                record = self.record(exact=True)
                method = record.method.for_claim((NYSTROM_ORDER if nystrom else ORDER).key)
                if row is not None:
                    method = method.with_row(method.rows()[row][0]).for_claim(ORDER.key)
                found = record.series(method, not free, trees, (row,))
        except (ExactnessError, Refused):
            return None
        scalar = tower_of(tuple(self.exact_texts.radicals)).scalar
        about = judge.proof.about_of(method, row)

        def kept(key: tuple[Any, ...], make: Callable[[], Any]) -> Any:
            return record.known((*key, *about), make)

        return Judged(found, kept, scalar) if found.simple else None

    def record(self, exact: bool) -> Any:
        """Return the judge's record of the document: exact, at its root, or over its decimals."""
        document, implied = self.document, self.facts.implied
        if not exact and implied is not None and implied.root is not None:
            return implied.root.record
        radicals = self.enclosed_texts.radicals
        field = self.exact_field([], None) if exact else field_of_decimals("balls", radicals)
        base = shipped_document(document["base"]) if "base" in document else None
        with consulted() as judge:
            return judge.proof.record_of(json.dumps([about(document), base, field, None]))

    def exact_field(self, parts: list[Part], declared: object) -> dict[str, Any]:
        """Return the field of a statement about exact numbers."""
        radicals = self.exact_texts.with_more([[part["witness"] for part in parts], declared])
        return tower_of(tuple(radicals)).as_json()

    def field(self, claim: str, parts: list[Part]) -> dict[str, Any]:
        """Return the field of a statement about decimals; the same for all that need no start."""
        radicals = self.enclosed_texts.with_more([part["witness"] for part in parts])
        if self.facts.implied is None:
            return field_of_decimals("balls", radicals)
        proofs = dict(self.method)
        if claim in (STARTING_ORDER.key, NYSTROM_STARTING_ORDER.key, FINISHING_ORDER.key):
            proofs |= self.facts.implied.blocks.proofs
        return {**field_of_decimals("enclosure", radicals), "proofs": proofs}


def _certificates(facts: Any, claim: str, declared: Any, judged: Found) -> Iterator[dict[str, Any]]:
    shared: Shared = facts.shared
    enclosed = judged.proof is not Proof.EXACT or not facts.kernel.exact
    document = shared.document
    writer = _Writer(facts, claim, declared, judged, decimals=enclosed)
    for parts in writer.proposals():
        found = {
            "format": FORMAT,
            "statement": {
                "method": document["name"],
                "claim": claim,
                "declared": declared,
                "verdict": "holds" if judged.truth else "fails",
                "proof": str(judged.proof),
            },
            "document": {**about(document), "claims": {claim: declared}},
            "field": shared.field(claim, parts)
            if enclosed
            else shared.exact_field(parts, declared),
            "parts": parts,
            "identities": writer.identities,
        }
        if document.get("class") == "composition":
            found["base"] = dict(shipped_document(document["base"]))
        if enclosed and CLAIMS[claim].type not in (int, dict):
            found["statement"]["proof"] = proof_of(json.loads(json.dumps(found)))
        yield found


def _vector(values: Vector) -> list[str]:
    found = scalars(values)
    if not linalg.is_exact((found,)):
        raise ExactnessError("a number that the proof needs is known to its decimals only")
    return [to_text(x) for x in found]


def _matrix(rows: Matrix) -> list[list[str]]:
    return [_vector(row) for row in rows]


def _none(writer: Any, parts: Parts) -> Witnesses:
    yield {}


class _Writer:
    """The parts of one statement, of exact numbers or of decimals.

    A statement about decimals is about the one exact method in them that an enclosure proves, or
    about all methods in them.
    """

    def __init__(
        self, facts: Any, claim: str, declared: Any, judged: Found, *, decimals: bool
    ) -> None:
        self.facts, self.claim, self.declared, self.judged = facts, claim, declared, judged
        self.decimals = decimals
        self.kernel: Kernel = facts.kernel
        self.identities: list[str] = []
        self.holds = judged.truth is True
        self.implied = self.kernel.implied if decimals else None

    def proposals(self) -> Iterator[list[Part]]:
        """Yield lists of parts that may prove the statement."""
        if self._absent() or CLAIMS[self.claim].type in (int, dict):
            yield self.parts()
        elif self._follows():
            self.identities.append("decided at the one root of the equations of the file")
            yield [{"rule": "implied", "witness": {}}]
        else:
            yield from self._proved()

    def _proved(self) -> Iterator[list[Part]]:
        """Yield the parts with which the judge proves such a statement, with what is known."""
        why: ExactnessError | None = None
        last: ExactnessError | None = None
        for rules in alternatives(self.claim, self._truth(), {"*": len(self.blocks)}):
            last = None
            try:
                yield from self._filled(rules)
            except ExactnessError as error:
                last, why = error, why or error
        if last is not None:  # else the judge has refused the last proposal, and said why
            raise why or last

    def _filled(self, rules: list[str], parts: tuple[Part, ...] = ()) -> Iterator[list[Part]]:
        """Yield parts of these rules, after others, with all witnesses that are proposed."""
        if not rules:
            yield list(parts)
            return
        rule, *later = rules
        for witness in self._witnesses.get(rule, _none)(self, parts):
            yield from self._filled(later, (*parts, {"rule": rule, "witness": witness}))

    def _follows(self) -> bool:
        """Return whether the statement is decided at the root of the equations of the file."""
        claim, implied = self.claim, self.implied
        growing = claim == GROWTH.key and implied and implied.growth_zeros is not None
        listed = claim == ABSCISSAE.key and self.holds
        return bool(implied and (growing or listed or (claim in implied.true and self._truth())))

    def parts(self) -> list[Part]:
        """Return the parts that prove a statement about an order, or about what is absent."""
        return [{"rule": "absent", "witness": {}}] if self._absent() else self._parts()

    def _absent(self) -> bool:
        """Return whether the file has nothing that the claim is about."""
        if self.claim == EMBEDDED_ORDER.key:
            rows = {x.name for x in self.facts.method.embedded}
            return not rows or set(self.declared) != rows
        key = ABOUT.get(self.claim)
        return key is not None and not self.facts.shared.document.get(key) and not (
            key == "starting" and self.kernel.is_pair
        )  # fmt: skip

    def _parts(self) -> list[Part]:
        if self.claim in SECOND:
            name = SECOND[self.claim]
            return self._reached(name) if self.claim in MODIFIED else self._after_order(name)
        if self.claim in ORDERS:
            return self._order_parts()
        return getattr(self, "_" + self.claim.replace("-", "_"))()

    # -- what stands beside a tableau

    def _embedded_order(self) -> list[Part]:
        """Return every row; of decimals, where the claim fails, one whose order is another."""
        rows, claim = [], self.kernel.row_claim
        one = self.decimals and not self.holds
        for name, kernel in self.kernel.row_kernels:
            found, declared = kernel.range(claim), self.declared[name]
            if one and found.lower <= declared and (found.upper is None or found.upper >= declared):
                continue
            of_row = SimpleNamespace(method=kernel.method, kernel=kernel)
            inner = _Writer(of_row, claim, declared, self.judged, decimals=self.decimals)
            rows.append({"rule": "row", "witness": {"row": name, "parts": inner.parts()}})
            self.identities += inner.identities
        if not rows:
            raise ExactnessError("no row has another order within the digits")
        return rows[:1] if one else rows

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

    def _dense_order(self) -> list[Part]:
        found, fails = self.kernel.range(DENSE_ORDER.key), self.decimals and not self.holds
        if not fails and (found.upper is None or found.lower != found.upper):
            raise ExactnessError("the order is not settled")
        witness = {"order": found.upper, "tree": found.tree}
        return [{"rule": "not-dense" if fails else "dense", "witness": witness}]

    # -- orders

    def _asked(self) -> tuple[Kernel, bool, bool]:
        """Return what knows the order that a claim is about, whether it is free, and nystrom."""
        claim, kernel = self.claim, self.kernel
        if claim == W_ORDER.key:
            kernel = kernel.any_matrix
        one = kernel.is_pair if "starting" in claim else kernel.one_step
        return kernel.timed, *KINDS.get(claim, (not one, claim.startswith("nystrom")))

    def _order_parts(self, *, upper_only: bool = False) -> list[Part]:
        """Return both bounds of the order, or of a claim about it that fails what refutes it.

        The lower one follows from the equations of an enclosure, or from the trees.
        """
        kernel, free, nystrom = self._asked()
        if free and kernel.method.system:
            raise ExactnessError("the effective order of a table with c apart")
        found, by_root = kernel.order_range(free=free, nystrom=nystrom), False
        lower, upper = found.lower, found.upper
        fails = not self.holds and self.claim in ORDERS
        if self.implied and not kernel.exact and upper is not None:
            by_root, lower = True, self.declared + 1 if fails and upper > self.declared else upper
        below = upper_only or (fails and upper is not None and upper < self.declared)
        above = fails and lower > self.declared
        if upper is None if below else not (above or lower == upper):
            raise ExactnessError("the order is not settled")
        p = upper if below and upper is not None else lower
        if p == 0 and (kernel.exact or not found.tree):
            return [self._no_order()]
        names = {"order": p, "principal": "free" if free else "identity"}
        names["trees"] = "nystrom" if nystrom else "all"
        alone = upper_only or (self.decimals and fails) or lower != upper
        if not (by_root or (alone and below)):
            series = self._series(kernel, free=free, nystrom=nystrom)
            if series.along_paths:
                names["trees"] = "nystrom-paths" if nystrom else "paths"
            count = sum(len(series.level(n)) for n in range(1, p + 1))
            self.identities.append(f"B xiD(t) + V eta(t) = (E eta)(t), {count} trees")
        least = {"rule": "implied-order" if by_root else "order-at-least", "witness": names}
        if alone and not below:
            return [least]
        self.identities.append(f"the condition of {found.tree} is not zero, order {p + 1}")
        most = {"rule": "order-at-most", "witness": {**names, "tree": found.tree}}
        return [most] if alone else [least, most]

    @staticmethod
    def _series(kernel: Kernel, *, free: bool, nystrom: bool) -> StartingSeries:
        """Return the series of an order; along paths the one with the identity serves both."""
        if (free, nystrom) not in kernel.series:
            kernel.order_range(free=False, nystrom=nystrom)
            free = False
        series = kernel.series[free, nystrom]
        if not series.complete:
            raise ExactnessError("the eigenvalue 1 of V is multiple, and the series not unique")
        return series

    def _no_order(self) -> Part:
        """Return a component that is not consistent; of decimals one that has no u may be known."""
        try:
            return {"rule": "no-order-1", "witness": next(self._inconsistent(()))}
        except ExactnessError:
            if not self.decimals:
                raise
            return {"rule": "not-preconsistent", "witness": next(self._not_preconsistent(()))}

    def _after_order(self, name: str) -> list[Part]:
        """Return the bounds of stages, a start or a finish after those of the order."""
        found = self.kernel.range(self.claim)
        q, lower = found.upper, found.lower
        refutes = self.decimals and not self.holds
        if self.implied and q is not None:
            lower = self.declared + 1 if refutes and q > self.declared else q
        below = not self.holds and q is not None and q < self.declared
        where = {} if found.failing is None else {"tree": found.failing}
        most = {"rule": f"{name}-at-most", "witness": {"q": q, **where}}
        if refutes and below:
            return [most] if where else self._order_parts(upper_only=True)
        one_bound = refutes and self.implied is not None and lower > self.declared
        try:
            if q is None or not (below or one_bound or lower == q):
                raise ExactnessError(f"the {self.claim} is not settled")
            parts = self._order_parts()
        except ExactnessError:  # without it the series of a method that carries one value is known
            stages = name == "stage-order" and self.implied is None and self.kernel.one_step
            if not (self.decimals and stages and (self.holds or lower > self.declared)):
                raise
            one_bound = refutes
            names = {"order": max(lower, 1), "principal": "identity", "trees": "all"}
            parts = [{"rule": "order-at-least", "witness": names}]
        if parts[0]["rule"] in ("no-order-1", "not-preconsistent"):
            return parts
        if self.implied and self.kernel.exact:  # a start in decimals of an exact method
            parts.append({"rule": "symmetric", "witness": next(self._symmetric(()))})
        rule = f"implied-{name}" if self.implied else f"{name}-at-least"
        least = {"rule": rule, "witness": {"q": lower}}
        if name == "start" and lower == q and not self.implied:
            self.identities.append(f"the start agrees with the series through order {q}")
        if one_bound:
            return [parts[0], least]
        return [*parts, *([least] if lower == q else []), most]

    def _reached(self, name: str) -> list[Part]:
        """Return both bounds of an order of the underlying one-step method, or the lower one."""
        found = self.kernel.range(self.claim)
        bounds = {"at-least": found.lower, "at-most": found.upper}
        return [{"rule": f"{name}-{which}", "witness": {"q": q}}
                for which, q in bounds.items() if q is not None]  # fmt: skip

    # -- true or false, and lists: witnesses of rules, after the parts before them

    def _truth(self) -> bool:
        return (self.declared is not False) == self.holds

    @property
    def blocks(self) -> dict[str, Matrix]:
        """V by colour; of questions about stability those of the linear form."""
        stable = self.claim in (A_STABLE.key, L_STABLE.key)
        method = self.facts.linear if stable else self.facts.method
        return {c.colour: c.V for c in method.components}

    def _component(self, parts: Parts) -> Witnesses:
        """Yield the component that comes next."""
        yield {"which": list(self.blocks)[len(parts)]}

    def _without(self, *, consistent: bool, why: str) -> Witnesses:
        """Yield the first component that has no u as the judge finds, or no u and v."""
        with consulted():
            method = judged_parts(self.kernel.method)
            for colour in method.parts:
                with suppress(Refused):
                    if method.vectors_to_one(colour, consistent)[0] is None:
                        yield {"colour": colour}
                        return
        raise ExactnessError(why)

    def _inconsistent(self, parts: Parts) -> Witnesses:
        found = self._without(consistent=True, why="order 1 is not excluded by consistency")
        (witness,) = found
        self.identities.append("u and v of consistency do not exist")
        yield witness

    def _not_preconsistent(self, parts: Parts) -> Witnesses:
        yield from self._without(consistent=False, why="no vector refutes preconsistency")

    def _unbounded(self, parts: Parts) -> Witnesses:
        """Yield every V, or block of V, that may have a root outside or defective on the circle."""
        for c, V in self.blocks.items():
            blocks = [{}] if linalg.is_exact(V) else [
                {"block": i} for i, _ in enumerate(poly.blocks_of(V))]  # fmt: skip
            yield from ({"which": c, **where} for where in blocks)

    # forms

    def _not_quadratic(self, parts: Parts) -> Witnesses:
        yield {} if self.kernel.one_step else {"several-values": True}

    @property
    def _form_is_given(self) -> bool:
        """Whether the form found is that of the file: else, where it has no D and no u, another."""
        found = self.facts.g_symplecticity
        return None not in (found.G, self.facts.method.G) and found.dimension is None

    def _form(self, parts: Parts) -> Witnesses:
        """Yield the form that was found, or one that no finder proposes."""
        if self.claim == CONJUGATE_SYMPLECTIC.key and self.kernel.one_step:
            return  # it is 1, by `quadratic`
        found = self.facts.g_symplecticity
        G, diagonals = found.G, found.diagonals
        if G is None:
            other = None if found.holds is False else choose_form(find_forms(self.kernel.method))
            if other is None:
                raise ExactnessError("no form was found")
            G, diagonals = other.G, other.D
        names = ("D_P", "D_Q") if self.kernel.is_pair else ("D",)
        yield {"G": _matrix(G)} | {n: _vector(d) for n, d in zip(names, diagonals, strict=True)}

    def _given_form(self, parts: Parts) -> Witnesses:
        if self._form_is_given:
            yield {}

    def _no_form(self, parts: Parts) -> Witnesses:
        if self._form_is_given:
            return
        if not self.kernel.method.is_real:
            raise ExactnessError("that a complex method has no form is not written out")
        first, last = self.kernel.method.components[0], self.kernel.method.components[-1]
        fits(len(first.V) * len(last.V), len(first.V) * len(last.V), "the form")
        yield {}

    def _not_conjugate(self, parts: Parts) -> Witnesses:
        found = self.kernel.range(CONJUGATE_SYMPLECTIC_ORDER.key)
        if found.upper is None:
            raise ExactnessError(found.sentence)
        yield {"q": found.upper}

    # symmetry

    def _reversed(self) -> tuple[Any, Symmetry]:
        """Return the method that is asked about, and its symmetry: that without idle values."""
        if self.claim != SYMMETRIC_REDUCED.key:
            return self.facts.method, self.facts.symmetry
        if not self.facts.method.is_exact:
            raise ExactnessError("the method without idle values was not found")
        return self.facts.reduced, symmetry(self.facts.reduced)

    def _equivalent(self, parts: Parts) -> Witnesses:
        smaller, _ = self._reversed()
        if len(smaller.A) != len(self.facts.method.A):
            raise ExactnessError("a method with idle stages is not reduced")
        yield {k: _matrix(getattr(smaller, k)) for k in "UBV"}

    def _symmetric(self, parts: Parts) -> Witnesses:
        """Yield the L, and the exchanges of stages by colour, that were found."""
        _, found = self._reversed()
        Ls = [L for L in found.involutions.values() if L is not None]
        if found.reduced or not found.exchanges or len(Ls) < len(found.involutions):
            raise ExactnessError("no exchange of stages was found")
        exchanges = list(map(list, found.exchanges.values()))
        names = ("L", "L_hat", "P_Q", "P_P") if self.kernel.is_pair else ("L", "P")
        yield dict(zip(names, [*map(_matrix, Ls), *exchanges], strict=True))

    def _not_symmetric(self, parts: Parts) -> Witnesses:
        """Yield a V that is singular, or let the judge search the exchanges of stages."""
        method, _ = self._reversed()
        singular = [c.colour for c in method.components
                    if linalg.is_exact(c.V) and linalg.nullspace(c.V)]  # fmt: skip
        yield {"singular": singular[-1]} if singular else {}

    # abscissae, linear stability

    def _abscissae(self, parts: Parts) -> Witnesses:
        if not all(linalg.is_exact(*block[1:]) for block in self.kernel.blocks.values()):
            raise ExactnessError("the abscissae of decimals are enclosed, not proved")
        yield {}

    def _stable(self, parts: Parts) -> Witnesses:
        if not self.kernel.exact:
            raise ExactnessError("published decimals: stability is decided for exact methods only")
        yield {}

    def _not_a_stable(self, parts: Parts) -> Witnesses:
        """Yield the reasons for which a method may not be A-stable."""
        for start in self._stable(()):
            yield from self._elsewhere() if not parts else [start | {"start": True}]

    def _elsewhere(self) -> Witnesses:
        """Yield the reasons other than V, which is cheapest."""
        poles, points = [{"pole": True}], [{"y": y} for y in SAMPLES]
        first = self.facts.linear.is_diagonally_implicit
        yield {"infinity": True}
        yield from poles + points if first else points + poles
        yield {"axis": True}

    # growth

    @cached_property
    def _cosines(self) -> dict[str, list[str]]:
        """The eigenvalues of the halves of a pair that shares stages and the eigenvalue 1."""
        found = residues(self.kernel.method) or {}
        return {c: [str(x.cosine) for x in half] for c, half in found.items()}

    @cached_property
    def _shares_one(self) -> bool:
        """Whether the method is a separable pair whose halves share the eigenvalue 1 only."""
        values = [b[3] for b in self.kernel.blocks.values()]
        if not self.kernel.is_pair or self.kernel.shared or not linalg.is_exact(*values):
            return False
        return poly.share_only_one(*map(poly.characteristic, values))

    def _unshared(self, parts: Parts) -> Witnesses:
        if self._shares_one:
            yield {}

    def _residues(self, parts: Parts) -> Witnesses:
        if self._cosines:
            yield {"cosines": self._cosines}

    def _eigen(self, parts: Parts) -> Witnesses:
        """Yield the eigenvalues of the component that comes next, where no other rule does."""
        by_list = self.claim == GROWTH.key or self._truth()
        if self._cosines or (by_list and self._shares_one):
            return
        (witness,) = self._component(parts)
        if witness["which"] not in self.facts.eigen:
            raise ExactnessError(self.facts.eigen.get("why", "eigenvalues are not known"))
        yield witness | {"zeta": list(map(to_text, self.facts.eigen[witness["which"]]))}

    def _growth(self, parts: Parts) -> Witnesses:
        """Refuse decimals at an eigenvalue that is not real: the intervals of a checker are."""
        decimals = not all(linalg.is_exact(U, B) for _, U, B, _ in self.kernel.blocks.values())
        if decimals and not all(z.is_real() for zeta in self.facts.eigen.values() for z in zeta):
            raise ExactnessError("growth of decimals at an eigenvalue that is not real")
        yield {}

    def _grows(self, parts: Parts) -> Witnesses:
        """Yield that another number of parameters is declared, and the places of each."""
        if self.claim == GROWTH.key:
            yield {"part": -1}
        for k in range(min(map(len, self.facts.eigen.values()))):
            yield from ({"part": k} for _ in self._growth(parts))

    #: What is proposed to the judge as witness of a rule; the others need none.
    _witnesses: ClassVar[Mapping[str, Callable[[Any, Parts], Witnesses]]] = {
        "no-order-1": _inconsistent, "not-preconsistent": _not_preconsistent,
        "bounded": _component, "unbounded": _unbounded,
        "not-quadratic": _not_quadratic,
        "form": _form, "given-form-fails": _given_form, "no-form": _no_form,
        "conjugate-symplectic-at-most": _not_conjugate,
        "equivalent": _equivalent, "symmetric": _symmetric, "not-symmetric": _not_symmetric,
        "abscissae": _abscissae, "a-stable": _stable, "not-a-stable": _not_a_stable,
        "eigen": _eigen, "growth": _growth, "grows": _grows,
        "unshared": _unshared, "residues": _residues,
    }  # fmt: skip
