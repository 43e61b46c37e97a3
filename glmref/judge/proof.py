"""One certificate: its statement, its method, its series, what its parts have shown."""

from __future__ import annotations

import json
from collections.abc import Mapping
from copy import copy
from functools import lru_cache
from typing import TypeVar

from .arithmetic import Fraction, Interval, rational_of
from .claims import LOOKS_AT
from .document import Method, class_of
from .enclosed_pair import Pair
from .enclosed_rk import RungeKutta
from .enclosed_sweep import Sweep
from .fields import Numbers
from .grammar import published_decimal
from .krawczyk import at_values
from .linalg import apply, equal, is_exact
from .numbers import apart, as_real
from .parity import even_start, start_with_parity
from .refusals import Malformed, NoCertificate, as_object, keys, require, whole
from .rule import Bound, Conclusion, Replaced, Reversal
from .series import Solved
from .trees import PATHS, size, through

T = TypeVar("T")
FORMAT = "glmref-certificate-1"


def around_decimal(text, digits):
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

    def __init__(self, document, field, block, numbers):
        self.exact, self.numbers, self.root, self.memory = numbers, numbers, None, {}
        self.document = document
        unknowns = as_object(document.get("unknowns", {}))
        if field["kind"] == "balls":
            values = {}
            for name, text in unknowns.items():
                digits = whole(document.get("digits"), 1, 400)
                values[name] = around_decimal(published_decimal(text, digits), digits)
            self.numbers = numbers.changed(decimal=around_decimal, unknowns=values)
        elif block is not None:
            kinds = {"sweep": Sweep, "pair-sweep": Pair, "splitting": Pair, "rk": RungeKutta,
                     "rosenbrock": RungeKutta}  # fmt: skip
            kind = class_of(document)
            require(kind in kinds, "an enclosure of another class")
            self.root = kinds[kind](document, numbers, block)
            weights = [row for row, _ in self.root.halves.values()]
            fine = all(apart(x) for row in weights for x in at_values(row, self.root.root))
            require(fine, "a weight may be 0")
            values = dict(zip(self.root.unknowns, self.root.root, strict=True))
            self.numbers = numbers.changed(unknowns=values)
            if isinstance(self.root, Sweep):
                self.root.explicit_now = self.numbers.explicit = frozenset(self.root.explicit)

    def read(self, base):
        """Read the matrices of the document, at the root of an enclosure."""
        self.method = Method(self.document, self.numbers, base)
        self.method.check_shapes()

    def known(self, key, make):
        """Return what was made before under this key; None keeps nothing."""
        if key is None:
            return make()
        if key not in self.memory:
            self.memory[key] = make()
        return self.memory[key]


@lru_cache(maxsize=1)
def numbers_of(field):
    """Return the numbers of the text of a field."""
    return Numbers(json.loads(field))


@lru_cache(maxsize=1)
def record_of(text):
    """Return the record of the text of a document, a base, a field and the proof of the method."""
    document, base, field, block = json.loads(text)
    record = Record(document, field, block, numbers_of(json.dumps(field)).changed())
    record.read(base)
    return record


def frame(certificate: object, rules: Mapping[str, object]) -> tuple[dict, dict]:
    """Return (document, statement) of a value that has the members of a certificate.

    Raises
    ------
    NoCertificate
        If a member is missing, unknown or of another type: what is no certificate proves and
        refutes nothing.
    """
    try:
        check_depth(certificate)
        keys(certificate, "format statement document field parts identities", "base", "certificate")
        member(certificate["format"] == FORMAT, "the format is another one")
        statement, document = certificate["statement"], certificate["document"]
        keys(statement, "method claim declared verdict proof", where="statement")
        for key in ("method", "claim", "verdict", "proof"):
            member(isinstance(statement[key], str), f"the {key} of the statement is no string")
        member(statement["verdict"] in ("holds", "fails"), "the verdict is not holds or fails")
        member(isinstance(document, dict), "the document is no object")
        member(document.get("name") == statement["method"], "the document has another name")
        field, parts, texts = (certificate[key] for key in ("field", "parts", "identities"))
        member(isinstance(field, dict), "the field is no object")
        member(isinstance(field.get("kind"), str), "the field has no kind")
        lines = isinstance(texts, list) and all(isinstance(x, str) for x in texts)
        member(lines, "the identities are no list of strings")
        check_parts(parts, rules)
    except Malformed as error:
        raise NoCertificate(str(error)) from None
    return document, statement


def check_depth(value: object) -> None:
    """Refuse a value with more than 100 lists and objects inside each other."""
    level = [value]
    for _ in range(100):
        level = [y for x in level if isinstance(x, dict | list)
                 for y in (x.values() if isinstance(x, dict) else x)]  # fmt: skip
        if not level:
            return
    raise Malformed("lists and objects stand more than 100 deep inside each other")


def check_parts(parts: object, rules: Mapping[str, object]) -> None:
    """Refuse what is no list of rules with their witnesses."""
    if not isinstance(parts, list) or not 0 < len(parts) <= 20:
        raise Malformed("the parts are no list of 1 to 20")
    for part in parts:
        keys(part, "rule witness", "", "part")
        member(isinstance(part["witness"], dict), "a witness is no object")
        known = isinstance(part["rule"], str) and part["rule"] in rules
        member(known, f"no rule is called {str(part['rule'])[:40]!r}")


def member(fine: bool, why: str) -> None:
    """Refuse a member of a certificate."""
    if not fine:
        raise Malformed(why)


class Proof:
    """One certificate while it is checked: the statement, the method, what is shown so far."""

    def __init__(self, certificate, rules):
        document, statement = frame(certificate, rules)
        self.table, self.parts = rules, certificate["parts"]
        self.claim, self.declared = statement["claim"], statement["declared"]
        self.holds = statement["verdict"] == "holds"
        self.rules = [part["rule"] for part in self.parts]
        claims = as_object(document.get("claims", {}))
        declared = claims.get(self.claim, self.declared)
        same = type(declared) is type(self.declared) and declared == self.declared
        require(same, "the document declares something else")
        field = dict(certificate["field"])
        require(("proofs" in field) == (field["kind"] == "enclosure"), "proofs of a method")
        base, self.blocks = certificate.get("base"), field.pop("proofs", {})
        self.kind = field["kind"]
        keys(self.blocks, "", "method starting finishing", "proofs")
        kept = {key: value for key, value in document.items() if key != "claims"}
        self.record = record_of(json.dumps([kept, base, field, self.blocks.get("method")]))
        self.method = self.record.method
        if self.rules != ["absent"]:
            self.method = self.method.for_claim(self.claim)
        require(statement["proof"] in self.proofs(), "the proof is another")
        self.known: dict[str, Bound] = {}
        self.shown: list[Conclusion] = []
        self.row = None
        self.claim_text = f"{self.claim} = {self.declared}"

    def apply(self, part):
        """Check one part; keep and return what it shows, if anything."""
        found = self.table[part["rule"]].apply(self, part["witness"])
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

    def of_row(self, name, method):
        """Return the proof of an embedded row, of which nothing is shown."""
        other = copy(self)
        other.method, other.row, other.known, other.shown = method, name, {}, []
        return other

    def proofs(self):
        """Return what the proof may be called: exact where only exact entries are looked at."""
        if self.kind in ("rational", "tower"):
            return ["exact"]
        looked = set(self.rules)
        for part in self.parts:
            witness = as_object(part["witness"])
            looked |= {"several-values", "singular"} & set(witness)
            if witness.get("part") == -1:  # a number of eigenvalues
                looked = looked - {"eigen", "grows"} | {"bounded"}
            if part["rule"] == "no-order-1":
                looked = looked - {"no-order-1"} | {"consistent"}
        looked -= {"not-quadratic", "not-symmetric"} if looked & set(LOOKS_AT) else set()
        exact = looked <= set(LOOKS_AT) and all(
            is_exact(getattr(m, x))
            for m in self.method.parts.values()
            for x in set("".join(LOOKS_AT[rule] for rule in looked))
        )
        return ["exact", "enclosed"] if exact else ["enclosed"]

    def root(self):
        """Return the sweep or pair at the root of the equations."""
        require(self.record.root is not None, "the proof of the method is missing")
        return self.record.root

    def series(self, identity_mode, nystrom, order, filled=False):
        """Return the series that an order needs, ready for its conditions or `filled` with eta."""
        identity_mode = identity_mode or nystrom in PATHS
        fine = identity_mode and all(m.r == 1 for m in self.method.parts.values())
        require(fine or not self.method.system, "several values are carried")
        found = self.record.known(("series", self.row, self.method.system, *self.method.parts,
                                   identity_mode, nystrom),
                                  lambda: Solved(self.method, identity_mode, nystrom))  # fmt: skip
        if found.order > order:
            return found
        found.advance(order)
        if filled:
            found.fill()
        return found

    def even_orders(self):
        """Return the orders of the start of a pair."""
        require("starting" in self.blocks, "the proof of the start is missing")
        proof = self.blocks["starting"]
        return self.record.known(("start", json.dumps(proof)), lambda: even_start(
            proof, self.root(), self.record.exact, self.method.document))  # fmt: skip

    def odd_start(self, order):
        """Return A and B of the start of one method, proved to have the order."""
        require("starting" in self.blocks, "the proof of the start is missing")

        proof, numbers = self.blocks["starting"], self.record.exact

        def made():
            L, series, q = self.target(order)
            return start_with_parity(proof, numbers, self.method.document, series, L, order, q)[1:]

        key = ("start", order, json.dumps(proof)) if self.record.root is not None else None
        return self.record.known(key, made)

    def target(self, order):
        """Return (L, starting series, stage order) that a start has to meet."""
        if self.record.root is not None:
            sweep = self.root()
            series = sweep.series(sweep.root, order + 1).cut_value
            return sweep.reversal()["o"], series, sweep.q
        known = self.known.get("order")
        reversals = self.all_shown(Reversal)
        require(reversals and known is not None, "symmetry is missing")
        L, eta = reversals[0].L["o"], self.series(*known.kind, order, filled=True)
        for t in through(self.method, order, False):
            sign_ = -1 if size(t) % 2 else 1
            equal(eta.eta_of(t), [sign_ * x for x in apply(L, eta.eta_of(t))], "eta(-h) = L eta(h)")
        return L, lambda t: [as_real(x) for x in eta.eta_of(t)], 1

    def claimed(self, texts):
        """Return declared numbers; claims use no constants."""
        require(isinstance(texts, list), "a list is declared")
        return [self.method.numbers.entry(text, {}) for text in texts]

    def mode(self):
        """Return (identity?, nystrom?) of the orders that a claim is about."""
        single = all(m.r == 1 for m in self.method.parts.values())
        nystrom = self.claim.startswith("nystrom")
        if self.claim in ("order", "stage-order", "finishing-order"):
            return single, False
        if self.claim == "starting-order":
            return self.method.pair, False
        return self.claim != "effective-order", nystrom
