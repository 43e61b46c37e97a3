"""Both directions of a claim: statements, witnesses for and against them, and what is accepted.

A rule whose theorem has a hypothesis that nobody evaluates gives itself away without anybody knowing
the truth: it accepts a claim in one direction, and another rule accepts it in the other.

:func:`accepted` is the one place that knows the program that judges certificates.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from glmref import judge
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.prove.verifier import facts_for
from tests.build import SOURCE

Document = Mapping[str, Any]
Part = tuple[str, Mapping[str, Any]]
ORDERS = ("order", "order-identity", "effective-order", "nystrom-order", "w-order")
SECOND = {
    "stage-order": "stage-order",
    "starting-order": "start",
    "nystrom-starting-order": "start",
    "finishing-order": "finish",
    "hamiltonian-to-order": "hamiltonian",
    "conjugate-symplectic-order": "conjugate-symplectic",
    "energy-order": "energy",
}
#: Those of the underlying one-step method, whose parts stand alone.
ALONE = ("hamiltonian", "conjugate-symplectic", "energy")
#: Claims that are true or false, with the parts for true and those for false; `?` stands for every
#: colour, `~` for a witness of :func:`_witnesses`.
TRUTHS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "preconsistent": (("preconsistent", "implied"), ("not-preconsistent ?",)),
    "consistent": (("consistent", "implied"), ("no-order-1 ?",)),
    "symplectic": (("quadratic", "implied"), ("not-quadratic ~", "not-quadratic")),
    "g-symplectic": (
        ("form ~", "preconsistent form ~", "implied"),
        ("given-form-fails", "no-form", "not-preconsistent ?"),
    ),
    "conjugate-symplectic": (
        ("form ~ conjugate", "quadratic conjugate", "implied"),
        ("conjugate-symplectic-at-most ~",),
    ),
    "symmetric": (("symmetric ~", "implied"), ("not-symmetric ~", "not-symmetric")),
    "explicit": (("explicit",), ("implicit",)),
    "reducible": (("reducible",), ("irreducible",)),
    "zero-stable": (("bounded *",), ("unbounded ?", "unbounded ~")),
    "a-stable": (("bounded * a-stable",), ("not-a-stable ~", "unbounded ? not-a-stable ~")),
    "l-stable": (
        ("bounded * a-stable l-limit",),
        ("not-a-stable ~", "unbounded ? not-a-stable ~", "not-l-limit"),
    ),
    "parasitism-free": (
        ("eigen * growth", "bounded * unshared", "implied"),
        ("eigen * grows ~", "unbounded ?"),
    ),
    "embedded-difference": (("differences", "implied"), ("no-differences",)),
    "row-sums": (("row-sums",), ("no-row-sums",)),
    "dense-end": (("dense-end",), ("no-dense-end",)),
}
#: Claims with a value: the parts for it and those against it.
VALUES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "growth": (
        ("eigen * growth", "bounded * unshared", "implied"),
        ("eigen * grows ~", "unbounded ?", "bounded * unshared", "implied"),
    ),
    "second-order-growth": (("eigen * second-order", "implied"), ("eigen * other-second-order",)),
    "abscissae": (("abscissae", "implied"), ("other-abscissae", "no-order-1 ?")),
    "error-constant": (("error-constant",), ("other-error-constant",)),
}
#: Steps or stages above which no search for an exchange of stages is asked for.
STEPS = 12


def accepted(certificate: Mapping[str, Any]) -> bool:
    """Return whether the judge accepts a certificate (the one place that names it)."""
    return judge.verdict(certificate)[0]


def written(document: Document, claims: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the certificates that the package writes for these claims of a document."""
    whole = {
        "format": "glmref-method-1",
        "source": SOURCE,
        **document,
        "name": document.get("name", "x").lower(),  # of a file it has no capitals
        "claims": claims,
    }
    whole.pop("broken", None)
    try:
        facts = facts_for(load_document(whole))
    except GlmrefError:
        return []
    found = []
    for claim, value in claims.items():
        try:
            found.append(facts.judge(claim, value).certificate)
        except GlmrefError:
            continue
    return [x for x in found if isinstance(x, dict)]


@dataclass(frozen=True)
class Subject:
    """A document with the field, and for a composition the base, of its certificates."""

    document: Document
    field: Mapping[str, Any]
    base: Document | None = None
    proof: str = ""

    def certificate(
        self, claim: str, declared: object, verdict: str, parts: Sequence[Part]
    ) -> dict[str, Any]:
        """Return a certificate of one statement about the document."""
        exact = self.field["kind"] in ("rational", "tower")
        found = {
            "format": "glmref-certificate-1",
            "statement": {
                "method": self.document.get("name", "x"),
                "claim": claim,
                "declared": declared,
                "verdict": verdict,
                "proof": self.proof or ("exact" if exact else "enclosed"),
            },
            "document": {"name": "x", **self.document, "claims": {claim: declared}},
            "field": self.field,
            "identities": [],
            "parts": [{"rule": rule, "witness": dict(witness)} for rule, witness in parts],
        }
        return found if self.base is None else {**found, "base": self.base}

    def accepts(self, claim: str, declared: object, verdict: str, parts: Sequence[Part]) -> bool:
        """Return whether the statement is accepted with these parts."""
        return accepted(self.certificate(claim, declared, verdict, parts))

    @property
    def steps(self) -> int:
        """The steps of a composition or splitting; of other classes that have b, the stages."""
        return max(len(self.document.get(key, ())) for key in ("gamma", "a", "b"))

    @property
    def colours(self) -> tuple[str, ...]:
        """The colours of the components."""
        kind = self.document.get("class")
        if kind == "additive":
            return tuple(str(n + 1) for n in range(len(self.document["parts"])))
        if kind == "rosenbrock":
            return "1", "2"
        pairs = ("partitioned", "partitioned-rk", "splitting", "pair-sweep", "nystrom")
        return ("f", "k") if kind in pairs else ("o",)


def _trees(colours: Sequence[str], most: int) -> Iterator[str]:
    """Yield some trees of each order: bushes, paths and what is between, every colour."""
    for root in colours:
        for below in colours:
            leaf, head = ("o", "") if root == "o" else (below, root)
            yield root
            for n in range(1, most):
                yield f"{head}[{leaf * n}]"
            inner = f"[{leaf}]" if root == "o" else f"{below}[{root}]"
            yield f"{head}[{inner}]"
            yield f"{head}[{leaf}{inner}]"
            yield f"{head}[[{inner}]]" if root == "o" else f"{head}[{below}[{root}[{below}]]]"


def _bounds(subject: Subject, claim: str, most: int) -> Iterator[tuple[int, bool, Sequence[Part]]]:
    """Yield (bound, whether it is a lower one, parts) for orders of a kind."""
    trees = list(dict.fromkeys(_trees(subject.colours, most + 1)))
    principals, kinds = ("free", "identity"), ("all", "nystrom")
    seconds = claim in SECOND
    name = SECOND.get(claim, "order")
    if name in ALONE:
        for q, which in itertools.product(range(most + 2), ("least", "most")):
            yield q, which == "least", [(f"{name}-at-{which}", {"q": q})]
        return
    for c in subject.colours:
        yield 0, False, [("no-order-1", {"colour": c})]
        yield 0, False, [("not-preconsistent", {"colour": c})]
    for p in range(most + 1):
        for principal, kind in itertools.product(principals, kinds):
            if (kind == "nystrom") != claim.startswith("nystrom"):
                continue
            own = {"order": p, "principal": principal, "trees": kind}
            least: Part = ("order-at-least", own)
            implied: Part = ("implied-order", own)
            here = [t for t in trees if sum(map(t.count, subject.colours)) or t]
            at_most: Sequence[Part] = [("order-at-most", {**own, "tree": t}) for t in here
                                   if _size(t) == p + 1][:6]  # fmt: skip
            if not seconds:
                yield p, True, [least]
                yield p, True, [implied]
                for part in at_most:
                    yield p, False, [part]
                continue
            for part in at_most:
                yield p, False, [part]
            for q in range(p + 1):
                for low, high in itertools.product((least, implied), at_most[:3]):
                    yield q, True, [low, high, (f"{name}-at-least", {"q": q})]
                    yield q, True, [low, high, (f"implied-{name}", {"q": q})]
                yield q, True, [least, (f"{name}-at-least", {"q": q})]
    if seconds:
        for q in range(most + 1):
            for t in ["", *trees]:
                if t == "" or _size(t) == q + 1:
                    yield q, False, [(f"{name}-at-most", {"q": q, "tree": t})]


def _size(tree: str) -> int:
    """Return the number of vertices of the text of a tree."""
    bare = sum(1 for k, x in enumerate(tree) if x not in "[]" and tree[k + 1 : k + 2] != "[")
    return bare + tree.count("[")


def order_bounds(subject: Subject, claim: str, most: int = 4) -> tuple[int, int | None]:
    """Return the largest lower and the smallest upper bound of an order that is accepted."""
    low, high = 0, None
    for bound, lower, parts in _bounds(subject, claim, most):
        if lower and bound > low and subject.accepts(claim, bound - 1, "fails", parts):
            low = bound
        no_news = lower or (high is not None and bound >= high)
        if not no_news and subject.accepts(claim, bound + 1, "fails", parts):
            high = bound
    return low, high


def _witnesses(
    subject: Subject, rule: str, claim: str, own: Sequence[Mapping[str, Any]]
) -> Iterator[Mapping[str, Any]]:
    """Yield witnesses of a rule: those the package proposed, and small ones."""
    for certificate in own:
        for part in certificate["parts"]:
            if part["rule"] == rule:
                yield part["witness"]
    if rule == "not-quadratic":
        yield {"several-values": True}
    elif rule == "not-symmetric":
        yield from ({"singular": c} for c in subject.colours)
    elif rule == "unbounded":
        yield from ({"which": c, "block": n} for c in subject.colours for n in range(3))
    elif rule == "not-a-stable":
        yield from ({"y": y} for y in ("1", "1/2", "2", "0", "1/10", "100"))
        yield from ({x: True} for x in ("infinity", "pole", "axis", "start"))
    elif rule == "grows":
        yield from ({"part": n} for n in range(-1, 3))
    elif rule == "eigen":
        some = ("1", "-1", "1,-1", "", "1,exp(pi*i/2),-1,exp(3*pi*i/2)")
        yield from ({"zeta": [x for x in text.split(",") if x]} for text in some)
    elif rule == "conjugate-symplectic-at-most":
        yield from ({"q": q} for q in range(1, 6))
    elif rule == "form":
        G, D = subject.document.get("G"), subject.document.get("D")
        if G is not None and D is not None:
            yield {"G": G, "D": D}


def _filled(
    subject: Subject, text: str, claim: str, own: Sequence[Mapping[str, Any]]
) -> Iterator[Sequence[Part]]:
    """Yield lists of parts that a pattern of :data:`TRUTHS` stands for."""
    choices: list[list[Sequence[Part]]] = []
    words = text.split()
    for k, rule in enumerate(words):
        sign = words[k + 1] if k + 1 < len(words) else ""
        if rule in "?*~":
            continue
        if sign == "?":
            key = "which" if rule in ("unbounded",) else "colour"
            choices.append([[(rule, {key: c})] for c in subject.colours])
        elif sign == "*" and rule == "bounded":
            choices.append([[(rule, {"which": c}) for c in subject.colours]])
        elif sign == "*":
            some = list(_witnesses(subject, rule, claim, own))
            plain = [list(x) for x in dict.fromkeys(tuple(y["zeta"]) for y in some if "zeta" in y)]
            lists = itertools.product(plain, repeat=len(subject.colours))
            choices.append([[(rule, {"which": c, "zeta": z}) for c, z in zip(subject.colours, zs,
                             strict=True)] for zs in lists
                             if max(map(zs.count, zs)) == len(zs) or plain[0] in zs])  # fmt: skip
        elif sign == "~":
            choices.append([[(rule, w)] for w in _witnesses(subject, rule, claim, own)])
        else:
            choices.append([[(rule, {})]])
    for choice in itertools.product(*choices):
        yield [part for parts in choice for part in parts]


def directions(
    subject: Subject, claim: str, declared: object, own: Sequence[Mapping[str, Any]] = ()
) -> set[bool]:
    """Return the directions that are accepted: ``True`` for holds, ``False`` for fails.

    Parameters
    ----------
    subject : Subject
        The document.
    claim : str
        A claim that is true or false, or one of :data:`VALUES`; for an order use
        :func:`order_bounds`.
    declared : object
        Its value; ``True`` for a claim that is true or false.
    own : Sequence[Mapping[str, Any]]
        Certificates of the document whose witnesses are tried too.
    """
    found: set[bool] = set()
    for truth, patterns in zip((True, False), {**TRUTHS, **VALUES}[claim], strict=True):
        for pattern in patterns:
            if pattern == "not-symmetric" and subject.steps > STEPS:
                continue
            for parts in _filled(subject, pattern, claim, own):
                if subject.accepts(claim, declared, "holds" if truth else "fails", parts):
                    found.add(truth)
                    break
            if truth in found:
                break
    return found


def subject_of(certificate: Mapping[str, Any]) -> Subject:
    """Return the document of a certificate with its field and base."""
    statement = certificate["statement"]
    document = {k: x for k, x in certificate["document"].items() if k != "claims"}
    return Subject(document, certificate["field"], certificate.get("base"), statement["proof"])


def against_an_order(
    certificate: Mapping[str, Any], claim: str, declared: int
) -> Iterator[Sequence[Part]]:
    """Yield the parts that show another order than the declared one and are accepted."""
    subject = subject_of(certificate)
    own = [{"order": p, "principal": principal, "trees": kind}
           for p in (declared - 1, declared + 1) if p >= 0
           for principal in ("free", "identity")
           for kind in (("nystrom",) if claim.startswith("nystrom") else ("all",))]  # fmt: skip
    small = [t for t in dict.fromkeys(_trees(subject.colours, declared)) if _size(t) == declared]
    name = SECOND.get(claim, "order")
    if name in ALONE:
        least: Part = (f"{name}-at-least", {"q": declared + 1})
        most: list[Part] = [(f"{name}-at-most", {"q": declared - 1})] if declared else []
        yield from ([x] for x in (least, *most) if subject.accepts(claim, declared, "fails", [x]))
        return
    tried: list[Sequence[Part]] = [[("no-order-1", {"colour": c})] for c in subject.colours]
    tried += [[(f"implied-{name}", {"q": declared + 1})]] if claim in SECOND else []
    for w in own:
        if w["order"] > declared:
            tried += [[("order-at-least", w)], [("implied-order", w)]]
        else:
            tried += [[("order-at-most", {**w, "tree": t})] for t in small[:4]]
    if claim in SECOND and declared:
        tried += [[(f"{name}-at-most", {"q": declared - 1, "tree": t})] for t in ["", *small[:4]]]
    for parts in tried:
        if subject.accepts(claim, declared, "fails", parts):
            yield parts


def contradicts(certificate: Mapping[str, Any]) -> Iterator[object]:
    """Yield what is accepted against the statement of a certificate that is accepted."""
    statement = certificate["statement"]
    claim, declared = statement["claim"], statement["declared"]
    holds, subject = statement["verdict"] == "holds", subject_of(certificate)
    if claim in (*ORDERS, *SECOND):
        exact = certificate["field"]["kind"] in ("rational", "tower")
        if holds and declared <= (5 if exact else 2):
            yield from against_an_order(certificate, claim, declared)
    elif claim in TRUTHS:
        found = directions(subject, claim, True, [certificate])
        if found - {(declared is True) == holds}:
            yield claim, found
    elif claim in VALUES:
        found = directions(subject, claim, declared, [certificate])
        if found - {holds}:
            yield claim, found
