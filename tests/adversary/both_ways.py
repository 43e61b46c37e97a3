"""Both directions of a claim: statements, witnesses for and against them, and what is accepted.

A rule whose theorem has a hypothesis that nobody evaluates gives itself away without anybody knowing
the truth: it accepts a claim in one direction, and another rule accepts it in the other.

:func:`accepted` is the one place that knows the program that judges certificates.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from glmref import judge
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.judge import claims
from glmref.judge.claims import ORDERS, PROVES, SECOND
from glmref.judge.statements import RULES
from glmref.prove.verifier import facts_for
from tests.build import SOURCE

Document = Mapping[str, Any]
Part = tuple[str, Mapping[str, Any]]
#: Those of the underlying one-step method, whose parts stand alone.
ALONE = ("hamiltonian", "conjugate-symplectic", "energy")
#: Claims that are true or false, and claims with a value, of which both directions are asked.
TRUTHS = [x for x in PROVES if x not in (*claims.VALUES, "dense-order", "symmetric-reduced")]
VALUES = [
    x for x in claims.VALUES if x in PROVES and x not in ("embedded-order", "order-to-digits")
]
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
    name = SECOND.get(claim, "order")
    if name in ALONE:
        for q, which in itertools.product(range(most + 2), ("least", "most")):
            yield q, which == "least", [(f"{name}-at-{which}", {"q": q})]
        return
    for rule, c in itertools.product(("no-order-1", "not-preconsistent"), subject.colours):
        yield 0, False, [(rule, {"colour": c})]
    kinds = ("nystrom", "nystrom-paths") if claim.startswith("nystrom") else ("all", "paths")
    for principal, kind in itertools.product(("free", "identity"), kinds[: len(subject.colours)]):
        lows: list[tuple[int, Part]] = []
        highs: list[tuple[int, Part]] = []
        for p in range(most + 1):
            own = {"order": p, "principal": principal, "trees": kind}
            lows += [(p, (rule, own)) for rule in ("order-at-least", "implied-order")]
            of_next = [t for t in trees if _size(t) == p + 1][:6]
            highs += [(p, ("order-at-most", {**own, "tree": t})) for t in of_next]
        yield from ((p, True, [low]) for p, low in lows if claim not in SECOND)
        yield from ((p, False, [high]) for p, high in highs)
        for (p, low), (n, high) in itertools.product(lows, highs):
            if kind.endswith("paths"):
                yield n, False, [low, high]
            for q in range(p + 1) if claim in SECOND and n >= p else ():
                yield q, True, [low, high, (f"{name}-at-least", {"q": q})]
                yield q, True, [low, high, (f"implied-{name}", {"q": q})]
        for before in ([], *([low] for _, low in lows)) if claim in SECOND else ():
            for q in range(most + 1):
                yield q, True, [*before, (f"{name}-at-least", {"q": q})]
                for t in ["", *(t for t in trees if _size(t) == q + 1)]:
                    yield q, False, [*before, (f"{name}-at-most", {"q": q, "tree": t})]


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


#: Small witnesses of rules; those of components are made for each colour.
SMALL: dict[str, Sequence[Mapping[str, Any]]] = {
    "not-quadratic": ({"several-values": True}, {}),
    "not-symmetric": ({},),
    "not-a-stable": (*({"y": y} for y in ("1", "1/2", "2", "0", "1/10", "100")),
                     *({x: True} for x in ("infinity", "pole", "axis", "start"))),
    "grows": [{"part": n} for n in range(-1, 3)],
    "eigen": [{"zeta": text.split()} for text in (
        "1", "-1", "1 -1", "", "1 exp(pi*i/2) -1 exp(3*pi*i/2)")],
    "conjugate-symplectic-at-most": [{"q": q} for q in range(1, 6)],
}  # fmt: skip


def _witnesses(
    subject: Subject, rule: str, own: Sequence[Mapping[str, Any]]
) -> Iterator[Mapping[str, Any]]:
    """Yield witnesses of a rule: those the package proposed, and small ones."""
    for certificate in own:
        for part in certificate["parts"]:
            if part["rule"] == rule:
                yield part["witness"]
    yield from SMALL.get(rule, ())
    members = [x.name for x in fields(RULES[rule].witness)]
    if not members:
        yield {}
    for key in {"colour", "which", "singular"} & {*members}:
        yield from ({key: c} for c in subject.colours)
    if rule == "unbounded":
        yield from ({"which": c, "block": n} for c in subject.colours for n in range(3))
    elif rule == "form" and {"G", "D"} <= set(subject.document):
        yield {"G": subject.document["G"], "D": subject.document["D"]}


def _filled(
    subject: Subject, text: str, own: Sequence[Mapping[str, Any]]
) -> Iterator[Sequence[Part]]:
    """Yield lists of parts that an alternative of :data:`PROVES` stands for."""
    choices: list[list[Sequence[Part]]] = []
    for word in text.split():
        rule = word.rstrip("*")
        some = list(_witnesses(subject, rule, own))
        if rule == "eigen":
            plain = [list(x) for x in dict.fromkeys(tuple(y["zeta"]) for y in some if "zeta" in y)]
            lists = itertools.product(plain, repeat=len(subject.colours))
            choices.append([[(rule, {"which": c, "zeta": z}) for c, z in zip(subject.colours, zs,
                             strict=True)] for zs in lists
                             if max(map(zs.count, zs)) == len(zs) or plain[0] in zs])  # fmt: skip
        elif word != rule:
            choices.append([[(rule, {"which": c}) for c in subject.colours]])
        else:
            choices.append([[(rule, w)] for w in some])
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
    for truth, patterns in zip((True, False), PROVES[claim], strict=True):
        implied = "|implied" if truth or claim == "growth" else ""
        for pattern in (patterns + implied).split("|"):
            if pattern == "not-symmetric" and subject.steps > STEPS:
                continue
            for parts in _filled(subject, pattern, own):
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
