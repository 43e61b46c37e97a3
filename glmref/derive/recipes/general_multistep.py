"""Explicit symmetric partitioned multistep methods for systems that are not separable.

Options: ``name`` one shipped method (all of them by default); or ``q`` and ``p``, the real parts of
the roots of the two halves, fractions separated by blanks, with -1 at the end for the root -1. With
``match`` = ``p`` one more pair of roots of p is found, such that the error constants agree. With
``kind`` = ``semi-separable`` the method is for q' = f(p), p' = k(q, p): q_n may contain f(p_n).

The halves have no root but 1 in common. A step evaluates both functions once, at the solution.
Everything but the roots follows exactly (:mod:`glmref.derive.general_multistep`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from ...catalogue.reader import load_document
from ...errors import ExactnessError, UsageError
from ...findings import Proof
from ...theory.residues import in_order, residues
from ..general_multistep import general_document, matching_cosine
from ..halves import EndedHalf, GeneralHalf
from .derivation import Derivation, Progress, Statement, chosen, complete_exactly, completed
from .multistep import CLAIMS
from .sources import derived_source

OPTIONS: Mapping[str, str] = {"name": "", "q": "", "p": "", "match": "", "kind": ""}


@dataclass(frozen=True)
class Shipped:
    """Real parts of the roots of the halves, -1 last.

    For general systems one more of p is found by its constant.
    """

    q: str
    p: str
    notes: Sequence[str] = ()
    semi: bool = False  #: Whether the method is for semi-separable systems.


#: Where the conditions stand, for general and for semi-separable systems.
_PAGES = ("docs/nonseparable.md", "docs/velocities.md")

_RESIDUES = (
    "The largest residue, which is the rate of a parasitic part over |H_pq|, decides for which "
    f"systems the method is bounded; a run that is being lost has a notice, see {_PAGES[False]}."
)

_VELOCITIES = (
    "For systems q' = f(p), p' = g(q, p), where f is evaluated before the stage of q; only the "
    "residues of p are rates of a parasitic part, over g_p; a run that is being lost has a notice, "
    f"see {_PAGES[True]}."
)

SHIPPED: Mapping[str, Shipped] = {
    "multistep-general-6": Shipped("69/100 -37/100 -1", "-7/100 -43/50", (_RESIDUES,)),
    "multistep-general-8": Shipped("169/200 149/200 7/40 -1", "29/50 -3/200 -81/100", (_RESIDUES,)),
    "multistep-general-8b": Shipped("3/4 21/100 -7/20 -1", "9/25 -9/50 -24/25", (_RESIDUES,)),
    "multistep-general-8c": Shipped(
        "16/25 51/100 1/20 -49/50", "39/100 -9/100 -399/400", (_RESIDUES,)
    ),
    "multistep-kinetic-6": Shipped("6/25 -1", "3/100 -2/5 -99/100", (_VELOCITIES,), semi=True),
    "multistep-kinetic-8": Shipped(
        "22/25 -53/100 -33/50", "69/100 17/50 -2/25 -1", (_VELOCITIES,), semi=True
    ),
    "multistep-kinetic-10": Shipped(
        "71/100 13/25 -47/100 -1", "89/100 41/50 23/50 0 -47/50", (_VELOCITIES,), semi=True
    ),
    "multistep-kinetic-12": Shipped(
        "81/100 3/5 7/25 -73/100 -1",
        "17/20 19/25 69/100 23/50 -7/100 -49/50",
        (_VELOCITIES,),
        semi=True,
    ),
}


def half_of(text: str, key: str, *, semi: bool = False) -> GeneralHalf:
    """Read a half from the real parts of its roots; that of q is implicit where ``semi`` says so.

    Raises
    ------
    UsageError
        For text that is not fractions, or roots that no half has.
    """
    try:
        found = [Fraction(x) for x in text.split()]
    except (ValueError, ZeroDivisionError) as error:
        raise UsageError(f"`{key}` must be fractions with blanks between ({error})") from None
    minus_one = -1 in found
    cosines = tuple(x for x in found if x != -1)
    return EndedHalf(cosines, minus_one, key == "p") if semi else GeneralHalf(cosines, minus_one)


def halves_of(roots: Shipped, *, matched: bool = True) -> tuple[GeneralHalf, GeneralHalf]:
    """Return both halves; for general systems ``matched`` adds the pair of roots of p by C_q."""
    q, p = (half_of(x, key, semi=roots.semi) for x, key in ((roots.q, "q"), (roots.p, "p")))
    if matched and not roots.semi:
        cosine = matching_cosine(q, p.cosines, minus_one=p.minus_one)
        p = GeneralHalf((cosine, *p.cosines), p.minus_one)
    return q, p


def _complete(
    name: str, roots: Shipped, where: str, *, matched: bool
) -> tuple[dict[str, Any], Sequence[Statement]]:
    """Build a document and prove its claims.

    Raises
    ------
    ExactnessError
        When a claim is not proved.
    """
    q, p = halves_of(roots, matched=matched)
    order, semi = q.order, roots.semi
    systems = "semi-separable systems" if semi else "systems that are not separable"
    title = (
        f"{'Symmetric' if semi else 'Explicit symmetric'} partitioned multistep method of order "
        f"{order} with one evaluation, for {systems}"
    )
    document = general_document(name, q, p, title=title)
    found = residues(load_document(document))
    if found is None:
        raise ExactnessError(f"{name}: the residues are not found")
    claims = {
        "order": order,
        "order-identity": order,
        "starting-order": order,
        **CLAIMS,
        "explicit": not semi,
        "parasitism-free": False,
        "growth": [str(x.as_fraction()) for x in in_order(found)],
    }
    complete_exactly(
        document, claims, derived_source(where, "general-multistep", _PAGES[semi]), roots.notes
    )
    largest = max(abs(complex(x.mu)) for half in found.values() for x in half)
    text = (
        f"{name}: order {order} on all systems, symmetric, one evaluation a step"
        f"{' where q is moved by p only' if semi else ''}; the largest "
        f"residue is {largest:.4g}, the error constants are {float(q.error_constant):.4g} and "
        f"{float(p.error_constant):.4g}"
    )
    return document, [Statement(text, Proof.EXACT)]


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Build and prove the shipped methods, or the one with given roots.

    Raises
    ------
    UsageError
        For a name that is not shipped, or roots that cannot be read.
    """
    if options["match"] not in ("", "p"):
        raise UsageError(f"`match` must be p or empty, got {options['match']!r}")
    if options["kind"] not in ("", "general", "semi-separable"):
        raise UsageError(
            f"`kind` must be general, semi-separable or empty, got {options['kind']!r}"
        )
    if options["q"] or options["p"]:
        semi = options["kind"] == "semi-separable"
        name = f"multistep-{'kinetic' if semi else 'general'}-found"
        given = {name: Shipped(options["q"], options["p"], semi=semi)}
        where, matched = f"roots {options['q']}; {options['p']}", options["match"] == "p"
    else:
        given, where, matched = chosen(options["name"], SHIPPED), "", True
    complete = partial(_complete, matched=matched)
    return completed("general-multistep", given, complete, progress, where)
