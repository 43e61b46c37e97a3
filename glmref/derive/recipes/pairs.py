"""Explicit symmetric G-symplectic pairs for separable systems: the shipped ones, or a search.

Options: ``name`` one shipped pair (all of them by default); or ``n``, ``order``, ``nystrom``,
``starts`` of an ansatz with ``seed`` and ``tries`` for a search, ``wanted`` how many to complete;
``circle = yes`` passes over pairs whose parasitic eigenvalues leave the unit circle on the
oscillator at small steps (:func:`.stability.parasitic_curvature`): an inequality, which
has no place among the equations.

The shipped pairs come from such searches. Each is kept here as an ansatz whose free parameters are
fixed rationally and a dozen digits of the other unknowns; the recipe polishes them to 75 digits and
proves what their files claim. Likewise the starts, ``partitioned_starts.json``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ...catalogue.reader import load_document
from ...errors import UsageError
from ...findings import Proof
from ...prove.enclosure import Enclosure
from ...system.arguments import one_of
from ...theory.stability import parasitic_curvature
from ..parameters import fix_parameters
from ..parity_start import with_partitioned_start
from ..partitioned import PairAnsatz, complete_pair, search_pairs
from ..search import Found
from .derivation import Derivation, Progress, Statement, chosen, completed, searched
from .shipped_pairs import SHIPPED, Shipped
from .sources import derived_source, long_notes, stored

OPTIONS: Mapping[str, str] = {
    "name": "",
    "n": "",
    "order": "6",
    "nystrom": "no",
    "starts": "qp",
    "circle": "no",
    "seed": "1",
    "tries": "64",
    "wanted": "1",
}

#: Larger coefficients lose digits: such a solution is passed over.
LARGEST = 10.0


_PAGE = "docs/pairs-order.md"


def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
    """Complete and prove the shipped pairs, or search for others.

    Raises
    ------
    UsageError
        For an option that cannot be read or a name that is not shipped.
    """
    if options["n"]:
        return _search(options, progress)
    return completed("pairs", chosen(options["name"], SHIPPED), _complete, progress)


def _complete(
    name: str, shipped: Shipped, where: str
) -> tuple[dict[str, Any], Sequence[Statement]]:
    """Return a shipped pair, with its start where one is on record, and what was proved."""
    document, enclosure = complete_pair(
        shipped.ansatz,
        shipped.start.split(),
        source=derived_source(where, "pairs", _PAGE),
        notes=[*shipped.notes, *long_notes(name)],
    )
    half = rough_pair_starts().get(name)
    if half is not None:
        document = with_partitioned_start(document, enclosure, half)
    return document, [_statement(document, enclosure)]


def rough_pair_starts() -> Mapping[str, Any]:
    """Return one stage of each pair of every start, see :func:`~.parity_start.expanded`."""
    return stored("partitioned_starts.json")


def _statement(document: Mapping[str, Any], enclosure: Enclosure) -> Statement:
    order = f"order {enclosure.order}"
    if enclosure.nystrom_order > enclosure.order:
        order += f", and {enclosure.nystrom_order} on second-order systems"
    text = (
        f"{document['name']}: exactly one solution within 1e-60 of the digits; "
        f"{order}, G-symplectic, symmetric, explicit and "
        f"parasitism-free there"
    )
    if "starting" in document:
        q, p = (len(document["starting"][x]) for x in ("A", "A_hat"))
        text += f"; start of {q} stages Q and {p} stages P exact within the digits, of full order"
    return Statement(text, Proof.ENCLOSED)


def _stays_on_circle(document: Mapping[str, Any]) -> bool:
    pair = load_document(document)
    return parasitic_curvature(pair).real.sign() > 0


@dataclass(frozen=True)
class _Wanted:
    seed: int
    tries: int
    wanted: int
    circle: bool


def _read(options: Mapping[str, str]) -> tuple[PairAnsatz, _Wanted]:
    try:
        n, order = int(options["n"]), int(options["order"])
        seed, tries, count = (int(options[x]) for x in ("seed", "tries", "wanted"))
    except ValueError as error:
        raise UsageError(
            f"`n`, `order`, `seed`, `tries` and `wanted` must be whole numbers ({error})"
        ) from None
    nystrom, circle = (
        one_of(key, options[key], ("yes", "no")) == "yes" for key in ("nystrom", "circle")
    )
    name = f"pair-{'rkn-' if nystrom else ''}{order}-{n}-found"
    title = f"Explicit pair of order {order} with {n} evaluations"
    ansatz = PairAnsatz(name, n, order, nystrom=nystrom, starts=options["starts"], title=title)
    return ansatz, _Wanted(seed, tries, count, circle)


def _search(options: Mapping[str, str], progress: Progress) -> Derivation:
    ansatz, wanted = _read(options)

    def make(found: Found) -> tuple[dict[str, Any] | None, Sequence[Statement]]:
        if max(map(abs, found.point)) >= LARGEST:
            return None, []
        square, point = fix_parameters(ansatz, found.point, places=4)
        if wanted.wanted > 1:
            square = replace(square, name=f"{ansatz.name}-{found.number}")
        where = f"search, seed {wanted.seed}, start {found.number}"
        document, enclosure = complete_pair(
            square, [repr(x) for x in point], source=derived_source(where, "pairs", _PAGE)
        )
        if wanted.circle and not _stays_on_circle(document):
            text = f"start {found.number}: its parasitic eigenvalues leave the unit circle"
            return None, [Statement(text, Proof.ENCLOSED)]
        return document, [_statement(document, enclosure)]

    ends = search_pairs(
        ansatz,
        seed=wanted.seed,
        starts=wanted.tries,
        progress=lambda done, total: progress("starts", done, total),
    )
    return searched("pairs", ends, make, wanted=wanted.wanted, methods="pairs")
