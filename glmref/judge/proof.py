"""One certificate: its statement, its parts, and the answer (section 7)."""

import json
from fractions import Fraction
from functools import lru_cache

from .claims import (
    ADDITIVE,
    AS_EXACT,
    LOOKS_AT,
    ORDERS,
    PROVES,
    ROSENBROCK,
    SECOND,
    VALUES,
    WITNESS,
)
from .document import Method, gaps_of_rows
from .enclosed_pair import Pair
from .enclosed_rk import RungeKutta
from .enclosed_sweep import Sweep
from .fields import Numbers
from .grammar import published_decimal
from .krawczyk import at_values
from .linalg import apply, equal, is_exact
from .numbers import Interval, apart, as_real
from .parity import even_start, start_with_parity
from .refusals import Refused, as_object, keys, require, whole
from .rules_digits import not_to_digits, to_digits
from .rules_enclosed import (
    implied,
    implied_finish,
    implied_order,
    implied_stage_order,
    implied_start,
)
from .rules_forms import form, given_form_fails, no_form, not_quadratic, quadratic
from .rules_growth import bounded, eigen, grows, growth, unbounded, unshared
from .rules_orders import (
    not_preconsistent,
    order_at_least,
    order_at_most,
    preconsistent,
    stage_order_at_least,
    stage_order_at_most,
)
from .rules_rows import absent, all_zero_or_not, check_rows, dense, differences_of, gaps_of_end, row
from .rules_stability import a_stable, l_limit, not_a_stable
from .rules_starts import finish_at_least, finish_at_most, start_at_least, start_at_most
from .rules_structure import (
    abscissae,
    equivalent,
    error_constant,
    explicit,
    implicit,
    other_abscissae,
    reducible,
)
from .rules_symmetry import not_symmetric, symmetric
from .series import Solved
from .trees import PATHS, size, through

FORMAT = "glmref-certificate-1"


RULES = {rule.__name__.replace("_", "-"): rule for rule in (
    order_at_least, order_at_most, preconsistent, stage_order_at_least,
    stage_order_at_most, start_at_least, start_at_most, finish_at_least, finish_at_most, bounded,
    unbounded, eigen, growth, grows, unshared, form, given_form_fails, no_form, quadratic,
    not_quadratic, symmetric, not_symmetric, explicit, implicit, abscissae, other_abscissae,
    error_constant, reducible, equivalent, a_stable, not_a_stable, l_limit, implied,
    implied_order, implied_stage_order, implied_start, implied_finish, row, dense, absent,
    to_digits, not_to_digits, not_preconsistent,
)} | {
    "consistent": lambda proof, w: preconsistent(proof, w, True),
    "no-order-1": lambda proof, w: not_preconsistent(proof, w, True),
    "irreducible": lambda proof, w: reducible(proof, w, False),
    "other-error-constant": lambda proof, w: error_constant(proof, w, False),
    "not-l-limit": lambda proof, w: l_limit(proof, w, False),
    "not-dense": lambda proof, w: dense(proof, w, False),
    "differences": all_zero_or_not(differences_of, True),
    "no-differences": all_zero_or_not(differences_of, False),
    "row-sums": all_zero_or_not(gaps_of_rows, True),
    "no-row-sums": all_zero_or_not(gaps_of_rows, False),
    "dense-end": all_zero_or_not(gaps_of_end, True),
    "no-dense-end": all_zero_or_not(gaps_of_end, False),
}  # fmt: skip


class Record:
    """The root of an enclosure and what was found from it, kept for the next certificate."""

    def __init__(self, document, field, block, numbers):
        self.exact, self.numbers, self.root, self.memory = numbers, numbers, None, {}
        unknowns = as_object(document.get("unknowns", {}))
        if field["kind"] == "balls":
            digits = whole(document.get("digits"), 1, 400)

            def around_decimal(text):
                unit = Fraction(1, 10**digits)
                return Interval.ends(Fraction(text) - unit, Fraction(text) + unit)

            values = {}
            for name, text in unknowns.items():
                values[name] = around_decimal(published_decimal(text, digits))
            self.numbers = numbers.changed(decimal=around_decimal, unknowns=values)
        elif block is not None:
            kinds = {"sweep": Sweep, "pair-sweep": Pair, "splitting": Pair, "rk": RungeKutta,
                     "rosenbrock": RungeKutta}  # fmt: skip
            require(document.get("class") in kinds, "an enclosure of another class")
            self.root = kinds[document["class"]](document, numbers, block)
            weights = [row for row, _ in self.root.halves.values()]
            fine = all(apart(x) for row in weights for x in at_values(row, self.root.root))
            require(fine, "a weight may be 0")
            values = dict(zip(self.root.unknowns, self.root.root, strict=True))
            self.numbers = numbers.changed(unknowns=values)
            if isinstance(self.root, Sweep):
                self.root.explicit_now = self.numbers.explicit = frozenset(self.root.explicit)

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
    document, _, field, block = json.loads(text)
    return Record(document, field, block, numbers_of(json.dumps(field)).changed())


class Proof:
    """One certificate while it is checked: the statement, the method, what is shown so far."""

    def __init__(self, certificate):
        keys(certificate, "format statement document field parts identities", "base", "certificate")
        require(certificate["format"] == FORMAT, "another format")
        statement, parts = certificate["statement"], certificate["parts"]
        keys(statement, "method claim declared verdict proof", where="statement")
        self.claim, self.declared = statement["claim"], statement["declared"]
        require(statement["verdict"] in ("holds", "fails"), "a verdict is holds or fails")
        require(isinstance(self.claim, str), "a claim is a string")
        self.holds = statement["verdict"] == "holds"
        texts = certificate["identities"]
        require(isinstance(texts, list) and all(isinstance(x, str) for x in texts), "identities")
        require(isinstance(parts, list) and 0 < len(parts) <= 20, "parts are a list")
        for part in parts:
            keys(part, "rule witness", "", "part")
            require(part["rule"] in RULES, f"no rule is called {part['rule']!r}")
        self.parts, self.rules = parts, [part["rule"] for part in parts]
        document = as_object(certificate["document"])
        require(document.get("name") == statement["method"], "the document is another method")
        claims = as_object(document.get("claims", {}))
        declared = claims.get(self.claim, self.declared)
        same = type(declared) is type(self.declared) and declared == self.declared
        require(same, "the document declares something else")
        field = dict(as_object(certificate["field"]))
        require(("proofs" in field) == (field.get("kind") == "enclosure"), "proofs of a method")
        base, self.blocks, self.kind = (
            certificate.get("base"),
            field.pop("proofs", {}),
            field["kind"],
        )
        keys(self.blocks, "", "method starting finishing", "proofs")
        kept = {key: value for key, value in document.items() if key != "claims"}
        self.record = record_of(json.dumps([kept, base, field, self.blocks.get("method")]))
        self.method = Method(document, self.record.numbers, base)
        self.method.check_shapes()
        if self.rules != ["absent"]:
            self.method = self.method.for_claim(self.claim)
        require(statement["proof"] in self.proofs(), "the proof is another")
        self.low = self.high = self.reversal = self.row = None
        self.stable, self.eigen = set(), {}
        self.claim_text = f"{self.claim} = {self.declared}"

    def apply(self, part):
        """Check one part, and return the bound that it proves, if any."""
        keys(part["witness"], *WITNESS.get(part["rule"], "").split("|"))
        return RULES[part["rule"]](self, part["witness"])

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
        require(self.reversal is not None and self.low is not None, "symmetry is missing")
        L, eta = self.reversal["o"], self.series(*self.low[1:], order, filled=True)
        for t in through(self.method, order, False):
            sign_ = -1 if size(t) % 2 else 1
            equal(eta.eta_of(t), [sign_ * x for x in apply(L, eta.eta_of(t))], "eta(-h) = L eta(h)")
        return L, lambda t: [as_real(x) for x in eta.eta_of(t)], 1

    def claimed(self, texts):
        """Return declared numbers; claims use no constants."""
        require(isinstance(texts, list), "a list is declared")
        return [self.method.numbers.entry(text, {}) for text in texts]

    def check(self):
        """Check that the parts are those of the statement (7), and each of them."""
        kind, about = self.method.kind, self.claim in ADDITIVE or not self.method.additive
        about = self.claim in ROSENBROCK if kind == "rosenbrock" else about
        require(about, f"{self.claim} has no meaning for an additive method")
        require(self.claim != "w-order" or kind == "rosenbrock", "a Rosenbrock method is needed")
        fine = self.rules == ["absent"] or self.fits()
        require(fine, f"these parts do not prove {self.claim}: {self.rules}")
        results = [self.apply(part) for part in self.parts]
        if self.rules == ["absent"]:
            return
        if self.claim == "embedded-order":
            check_rows(self, results)
        elif self.claim in ORDERS or self.claim == "dense-order":
            self.check_order(self.low and self.low[0], self.high and self.high[0])
        elif self.claim in SECOND:
            low, high = ([value for rule, value in zip(self.rules, results, strict=True)
                          if rule in names] for names in self.both_ends())  # fmt: skip
            if self.rules == ["order-at-most"]:  # none of these orders is above that of the method
                high = self.high
            self.check_order(*(found[0] if found else None for found in (low, high)))
        if self.claim in ("zero-stable", "parasitism-free", "growth") and "bounded" in self.rules:
            require(self.stable == set(self.method.parts), "V of one component is missing")
        for shown in (self.low, self.high):
            if shown and (self.claim in ORDERS or self.claim in SECOND):
                found = shown[1], shown[2] in (True, "nystrom-paths")
                require(found == self.mode(), "principal or trees are not those of the claim")

    def both_ends(self):
        """Return the rules for the two bounds of an order that rests on the order."""
        name = SECOND.get(self.claim, "order")
        return {f"{name}-at-least", f"implied-{name}"}, {f"{name}-at-most"}

    def mode(self):
        """Return (identity?, nystrom?) of the orders that a claim is about."""
        single = all(m.r == 1 for m in self.method.parts.values())
        nystrom = self.claim.startswith("nystrom")
        if self.claim in ("order", "stage-order", "finishing-order"):
            return single, False
        if self.claim == "starting-order":
            return self.method.pair, False
        return self.claim != "effective-order", nystrom

    def fits(self):
        """Tell whether the parts are such as prove statements of this kind (7)."""
        claim, rules, truth = self.claim, self.rules, self.holds
        if claim in (*ORDERS, *SECOND):  # any bounds: what they show is compared with the claim
            whole(self.declared)
            names = {"order-at-least", "implied-order", "order-at-most", "no-order-1"}
            names |= {"not-preconsistent"}.union(*self.both_ends())
            known = "order-at-most" in rules or not any(x.startswith("implied") for x in rules)
            fine = set(rules) <= names | {"symmetric"} and len(set(rules)) == len(rules)
            return fine and (known or not self.holds)
        if claim == "dense-order":
            whole(self.declared)
        elif claim not in VALUES:
            require(type(self.declared) is bool, "the claim is true or false")
            truth = self.declared == self.holds
        exact = self.kind in ("rational", "tower")
        texts = PROVES.get(claim, ("", ""))[not truth] if exact or claim in AS_EXACT else ""
        if not exact and (truth or claim == "growth"):
            texts += "|implied"
        often = {"*": len(self.method.parts), "+": len(self.method.document.get("embedded", ()))}
        return rules in ([x.rstrip("*+") for x in text.split() for _ in range(often.get(x[-1], 1))]
                         for text in texts.split("|") if text)  # fmt: skip

    def check_order(self, low, high):
        """Refuse bounds that do not decide the declared order; no order is below 0."""
        if {"no-order-1", "not-preconsistent"} & set(self.rules):
            low = high = 0
        low, p = low or 0, self.declared
        decided = low == p == high if self.holds else p < low or (high is not None and high < p)
        require(decided, f"the parts show {low} <= order <= {high}")


def verdict(certificate):
    """Return (accepted, sentence) for the value of one JSON file."""
    try:
        proof = Proof(certificate)
        proof.check()
    except (Refused, ArithmeticError, LookupError, MemoryError, RecursionError, TypeError,
            ValueError, AttributeError) as error:  # fmt: skip
        record_of.cache_clear()  # a series may have been left half made
        if isinstance(error, Refused):
            return False, str(error)
        if isinstance(error, RecursionError | MemoryError | ArithmeticError):
            return False, "beyond the limits of this checker"
        return False, f"a part has another shape ({type(error).__name__})"
    name, claim = str(proof.method.document["name"])[:100], proof.claim_text[:300]
    word = "holds" if proof.holds else "fails"
    return True, f"{name}: {claim} {word} ({', '.join(proof.rules)})"
