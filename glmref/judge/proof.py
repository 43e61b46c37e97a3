"""One certificate: its statement, its method, its series, what its parts have shown."""

from __future__ import annotations

import json
from collections.abc import Callable, Container, Mapping
from copy import copy
from dataclasses import dataclass
from functools import lru_cache

from .arithmetic import Fraction, Interval, rational_of
from .claims import LOOKS_AT
from .document import Method, class_of
from .enclosed_pair import Pair
from .enclosed_rk import RungeKutta
from .enclosed_sweep import Sweep
from .enclosures import Enclosed
from .fields import Numbers
from .grammar import published_decimal
from .krawczyk import at_values
from .linalg import apply, equal, is_exact
from .numbers import apart, as_reals
from .parity import EvenStart, OddFinish, OddStart, undoes
from .refusals import (
    Document,
    Malformed,
    NoCertificate,
    NotShown,
    T,
    as_list,
    as_object,
    as_text,
    keys,
    require,
    shown,
    whole,
)
from .rule import Bound, Conclusion, Replaced, Reversal, Rule
from .series import Solved
from .trees import PATHS, size, through

FORMAT = "glmref-certificate-1"


def around_decimal(text: str | Fraction, digits: int) -> Interval:
    """Return an interval around a decimal of a document with this number of places.

    A decimal with fewer places says less than `digits` does.
    """
    places = len(text.partition(".")[2]) if isinstance(text, str) else digits
    require(places >= digits, f"a decimal has {places} places, not the {digits} of its file")
    unit = Fraction(1, 10**digits)
    value = rational_of(text) if isinstance(text, str) else text
    return Interval.ends(value - unit, value + unit)


class Record:
    """The root of an enclosure and what was found from it, kept for the next certificate."""

    def __init__(
        self, document: Document, field: Document, block: object, numbers: Numbers
    ) -> None:
        self.exact, self.numbers, self.memory, self.document = numbers, numbers, {}, document
        self.root: Enclosed | None = None
        unknowns = as_object(document.get("unknowns", {}))
        if field["kind"] == "balls":
            values = {}
            for name, text in unknowns.items():
                digits = whole(document.get("digits"), 1, 400)
                values[name] = around_decimal(published_decimal(text, digits), digits)
            self.numbers = numbers.changed(decimal=around_decimal, unknowns=values)
        elif block is not None:
            proof = as_object(block)
            members = {k: x for k, x in proof.items() if k not in ("centre", "inverse")}
            equations = equations_of(json.dumps([document, field, members]))
            self.root = root = equations.enclosed(proof)
            weights = [row for row, _ in root.halves.values()]
            fine = all(apart(x) for row in weights for x in at_values(row, root.root))
            require(fine, "a weight may be 0")
            values = dict(zip(root.unknowns, root.root, strict=True))
            self.numbers = numbers.changed(unknowns=values)
            if isinstance(root, Sweep):
                root.explicit_now = self.numbers.explicit = frozenset(root.explicit)

    def read(self, base: Document | None) -> None:
        """Read the matrices of the document, at the root of an enclosure."""
        self.method = Method(self.document, self.numbers, base)
        self.method.check_shapes()

    def odd_start(self, order: int) -> OddStart:
        """Return the conditions of the start of a sweep."""
        root = self.root
        if not isinstance(root, Sweep):
            raise NotShown("a start with parity of another class")
        return self.known(("start", order), lambda: OddStart(
            self.exact, self.document, root.series(root.root, order + 1).cut_value,
            root.reversal()["o"], order, root.q))  # fmt: skip

    def exact_start(self, order: int, L: list, eta: Solved) -> OddStart:
        """Return the conditions of a start of a method without decimals that L reverses."""

        def made() -> OddStart:
            for t in through(eta.method, order, False):
                sign_ = -1 if size(t) % 2 else 1
                equal(eta.eta_of(t), [sign_ * x for x in apply(L, eta.eta_of(t))],
                      "eta(-h) = L eta(h)")  # fmt: skip
            return OddStart(self.exact, self.document,
                            lambda t: as_reals(eta.eta_of(t)), L, order, 1)  # fmt: skip

        return self.known(("start", order, eta, *map(tuple, L)), made)

    def even_start(self, most: int, nystrom: int) -> EvenStart:
        """Return the conditions of the start of a pair."""
        pair = self.root
        if not isinstance(pair, Pair):
            raise NotShown("the proof of a start of a pair")
        return self.known(("start", most, nystrom), lambda: EvenStart(
            self.exact, self.document, pair, (most, nystrom)))  # fmt: skip

    def undoes(self) -> bool:
        """Tell whether the finish undoes the first value of the start whatever the digits are."""
        blocks = (as_object(self.document[x]) for x in ("starting", "finishing"))
        return self.known(("undoes",), lambda: undoes(self.exact, *blocks))

    def finish(self, start: OddStart, proof: Document, order: int) -> OddFinish:
        """Return the conditions of the finish after a start with its proof."""

        def made() -> OddFinish:
            A, B = start.at(proof)
            return OddFinish(self.exact, self.document, A, B[0], order)

        return self.known(("finish", start, json.dumps(proof), order), made)

    def known(self, key: tuple | None, make: Callable[[], T]) -> T:
        """Return what was made before under this key; None keeps nothing."""
        if key is None:
            return make()
        if key not in self.memory:
            self.memory[key] = make()
        return self.memory[key]

    def series(
        self, method: Method, identity_mode: bool, nystrom: bool | str, about: tuple = (None,)
    ) -> Solved:
        """Return the starting series of the method, or of another with what tells it apart."""
        key = ("series", identity_mode, nystrom, *about_of(method, *about))
        found = self.memory.get(key)
        if found is None or found.moving:  # it may have been left half made by a refusal
            found = self.memory[key] = Solved(method, identity_mode, nystrom)
        return found


def about_of(method: Method, row: str | None, *replaced: Replaced) -> tuple:
    """Return what tells the methods of one record apart: row, system, colours, what replaced it."""
    return row, method.system, *method.parts, *replaced


@lru_cache(maxsize=1)
def numbers_of(field: str) -> Numbers:
    """Return the numbers of the text of a field."""
    return Numbers(json.loads(field))


@lru_cache(maxsize=1)
def equations_of(text: str) -> Enclosed:
    """Return the equations of the text of a document, a field and a proof without its root."""
    document, field, members = json.loads(text)
    kinds: dict[str, type[Enclosed]] = {
        "sweep": Sweep, "pair-sweep": Pair, "splitting": Pair, "rk": RungeKutta,
        "rosenbrock": RungeKutta}  # fmt: skip
    kind = shown(kinds.get(class_of(document)), "an enclosure of another class")
    return kind(document, numbers_of(json.dumps(field)).changed(), members)


@lru_cache(maxsize=2)  # the file's own and, of some statements, one with other radicals
def record_of(text: str) -> Record:
    """Return the record of the text of a document, a base, a field and the proof of the method."""
    document, base, field, block = json.loads(text)
    record = Record(document, field, block, numbers_of(json.dumps(field)).changed())
    record.read(base)
    return record


@dataclass(frozen=True)
class Part:
    """A rule by its name, and its witness, which the rule reads."""

    rule: str
    witness: Document


@dataclass(frozen=True)
class Certificate:
    """The members of a certificate; section 7 says what they mean."""

    claim: str
    declared: object
    holds: bool
    proof: str
    document: Document
    field: Document
    parts: tuple[Part, ...]
    base: object


def read_certificate(value: object, rules: Container[str]) -> Certificate:
    """Return the certificate of a value that has the members of one.

    Raises
    ------
    NoCertificate
        If a member is missing, unknown or of another type: what is no certificate proves and
        refutes nothing.
    """
    try:
        check_depth(value)
        keys(value, "format statement document field parts identities", "base", "certificate")
        given = as_object(value)
        member(given["format"] == FORMAT, "the format is another one")
        keys(given["statement"], "method claim declared verdict proof", where="statement")
        statement = as_object(given["statement"])
        name, claim, verdict, proof = (
            as_text(statement[key], f"the {key} of the statement is no string")
            for key in ("method", "claim", "verdict", "proof")
        )
        member(verdict in ("holds", "fails"), "the verdict is not holds or fails")
        document = as_object(given["document"], "the document is no object")
        member(document.get("name") == name, "the document has another name")
        field = as_object(given["field"], "the field is no object")
        member(isinstance(field.get("kind"), str), "the field has no kind")
        why = "the identities are no list of strings"
        for text in as_list(given["identities"], why):
            as_text(text, why)
        return Certificate(claim, statement["declared"], verdict == "holds", proof, document, field,
                           read_parts(given["parts"], rules), given.get("base"))  # fmt: skip
    except Malformed as error:
        raise NoCertificate(str(error)) from None


def check_depth(value: object) -> None:
    """Refuse a value with more than 100 lists and objects inside each other."""
    level = [value]
    for _ in range(100):
        level = [y for x in level if isinstance(x, dict | list)
                 for y in (x.values() if isinstance(x, dict) else x)]  # fmt: skip
        if not level:
            return
    raise Malformed("lists and objects stand more than 100 deep inside each other")


def read_parts(value: object, rules: Container[str]) -> tuple[Part, ...]:
    """Return the rules with their witnesses of a list of 1 to 20 parts."""
    parts = as_list(value, "the parts are no list of 1 to 20")
    member(0 < len(parts) <= 20, "the parts are no list of 1 to 20")
    for part in parts:
        keys(part, "rule witness", "", "part")
        known = isinstance(part["rule"], str) and part["rule"] in rules
        member(known, f"no rule is called {str(part['rule'])[:40]!r}")
    return tuple(Part(x["rule"], as_object(x["witness"], "a witness is no object")) for x in parts)


def member(fine: bool, why: str) -> None:
    """Refuse a member of a certificate."""
    if not fine:
        raise Malformed(why)


class Proof:
    """One certificate while it is checked: the statement, the method, what is shown so far."""

    def __init__(self, certificate: object, rules: Mapping[str, Rule]) -> None:
        given = read_certificate(certificate, rules)
        self.table, self.parts, document = rules, given.parts, given.document
        self.claim, self.declared, self.holds = given.claim, given.declared, given.holds
        self.rules = [part.rule for part in self.parts]
        claims = as_object(document.get("claims", {}))
        declared = claims.get(self.claim, self.declared)
        same = type(declared) is type(self.declared) and declared == self.declared
        require(same, "the document declares something else")
        field = dict(given.field)
        require(("proofs" in field) == (field["kind"] == "enclosure"), "proofs of a method")
        blocks = field.pop("proofs", {})
        keys(blocks, "", "method starting finishing", "proofs")
        self.kind, self.blocks = field["kind"], as_object(blocks)
        kept = {key: value for key, value in document.items() if key != "claims"}
        self.record = record_of(json.dumps([kept, given.base, field, self.blocks.get("method")]))
        self.method = self.record.method
        if self.rules != ["absent"]:
            self.method = self.method.for_claim(self.claim)
        require(given.proof in self.proofs(), "the proof is another")
        self.known: dict[str, Bound] = {}
        self.shown: list[Conclusion] = []
        self.row: str | None = None
        self.claim_text = f"{self.claim} = {self.declared}"

    def apply(self, part: Part) -> Conclusion:
        """Check one part; keep and return what it shows, if anything."""
        found = self.table[part.rule].apply(self, part.witness)
        if isinstance(found, Replaced):
            self.method = found.method
        self.shown.append(found)
        if isinstance(found, Bound):
            before = self.known.get(found.quantity)
            self.known[found.quantity] = before.meet(found) if before else found
        return found

    def all_shown(self, kind: type[T]) -> list[T]:
        """Return the conclusions of one kind of the parts before."""
        return [x for x in self.shown if isinstance(x, kind)]

    def of_row(self, name: str, method: Method) -> Proof:
        """Return the proof of an embedded row, of which nothing is shown."""
        other = copy(self)
        other.method, other.row, other.known, other.shown = method, name, {}, []
        return other

    def proofs(self) -> list[str]:
        """Return what the proof may be called: exact where only exact entries are looked at."""
        if self.kind in ("rational", "tower"):
            return ["exact"]
        looked = set(self.rules)
        for part in self.parts:
            looked |= {"several-values", "singular"} & set(part.witness)
            if part.witness.get("part") == -1:  # a number of eigenvalues
                looked = looked - {"eigen", "grows"} | {"bounded"}
            if part.rule == "no-order-1":
                looked = looked - {"no-order-1"} | {"consistent"}
        looked -= {"not-quadratic", "not-symmetric"} if looked & set(LOOKS_AT) else set()
        exact = looked <= set(LOOKS_AT) and all(
            is_exact(getattr(m, x))
            for m in self.method.parts.values()
            for x in set("".join(LOOKS_AT[rule] for rule in looked))
        )
        return ["exact", "enclosed"] if exact else ["enclosed"]

    def root(self) -> Enclosed:
        """Return the method at the root of the equations."""
        return shown(self.record.root, "the proof of the method is missing")

    def block(self, name: str) -> Document:
        """Return the proof of a start or finish."""
        return as_object(self.blocks.get(name), f"the proof of the {name} block is missing")

    def of_method(self, key: tuple, make: Callable[[], T]) -> T:
        """Return what was made before, for any claim, of this same method: row, system, colours."""
        about = about_of(self.method, self.row, *self.all_shown(Replaced))
        return self.record.known((*key, *about), make)

    def series(
        self, identity_mode: bool, nystrom: bool | str, order: int, filled: bool = False
    ) -> Solved:
        """Return the series that an order needs, ready for its conditions or `filled` with eta."""
        identity_mode = identity_mode or nystrom in PATHS
        fine = identity_mode and all(m.r == 1 for m in self.method.parts.values())
        require(fine or not self.method.system, "several values are carried")
        about = (self.row, *self.all_shown(Replaced))
        found = self.record.series(self.method, identity_mode, nystrom, about)
        if found.order > order:
            return found
        found.advance(order)
        if filled:
            fine = found.order == order
            require(fine, f"the conditions of order {found.order + 1} contradict each other")
            found.fill()
        return found

    def even_orders(self) -> tuple[int, int]:
        """Return the orders of the start of a pair."""
        proof = self.block("starting")
        most, nystrom = (whole(x, 0, 12) for x in as_list(proof.get("orders"), "orders"))
        self.root()
        self.record.even_start(most, nystrom).root(proof)
        return most, max(most, nystrom)

    def odd_start(self, order: int) -> OddStart:
        """Return the conditions of the start of one method, which are to be satisfied."""
        if self.record.root is not None:
            return self.record.odd_start(order)
        known = shown(self.known.get("order"), "the order is missing")
        reversals = self.all_shown(Reversal)
        require(reversals, "symmetry is missing")
        eta = self.series(*known.kind, order, filled=True)
        return self.record.exact_start(order, reversals[0].L["o"], eta)

    def claimed(self, texts: object) -> list:
        """Return declared numbers; claims use no constants."""
        given = as_list(texts, "a list is declared")
        return [self.method.numbers.entry(text, {}) for text in given]

    def mode(self) -> tuple[bool, bool]:
        """Return (identity?, nystrom?) of the orders that a claim is about."""
        single = all(m.r == 1 for m in self.method.parts.values())
        nystrom = self.claim.startswith("nystrom")
        if self.claim in ("order", "stage-order", "finishing-order"):
            return single, False
        if self.claim == "starting-order":
            return self.method.pair, False
        return self.claim != "effective-order", nystrom
