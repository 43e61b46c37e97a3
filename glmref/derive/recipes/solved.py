"""From an ansatz and a rough solution to a complete, proved document."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Any

from ...catalogue.writer import DIGITS, SYMMETRIC, fill
from ...exact import Exact
from ...exact.linalg import Matrix
from ...findings import Proof
from ...prove.enclosure import Enclosure, conditions_of, prove
from ...prove.starting import Target
from ...system.arguments import one_of
from ..ansatz import Ansatz
from ..linear_start import linear_start
from ..parity_start import complete, finishing_block, starting_block
from ..polish import polish
from .derivation import Derivation, Progress, Statement, in_turn
from .sources import GROWS, derived_source, long_notes, stored


@dataclass(frozen=True)
class Rough:
    """An ansatz with a solution to about ten digits."""

    ansatz: Ansatz  #: What is solved.
    start: str  #: Value of each unknown, in the order of the document.
    where: str  #: What the method is, for its source record.
    claims: Mapping[str, Any] = field(default_factory=dict)  #: Claims besides the usual ones.
    #: How much its parasitic part grows in data/measurements/long-runs.json, in a word.
    grows: str = ""


def rough_solutions(recipe: str) -> Mapping[str, Rough]:
    """Return the table of a recipe in ``rough.json``, by the names of its methods."""
    return {
        name: Rough(**{**row, "ansatz": Ansatz.from_table({"name": name, **row["ansatz"]}, name)})
        for name, row in stored("rough.json")[recipe].items()
    }


def rough_starts() -> Mapping[str, Any]:
    """Return parameters of starts and finishes by method: rationals, and roughly those to solve."""
    return stored("starts.json")["methods"]


def with_start(
    document: Mapping[str, Any], target: Target, parity: int, L: Matrix = ()
) -> dict[str, Any]:
    """Add the start and the finish that are on record for the method of a document.

    L reverses it; asked for where the weights of the start are solved for linearly.
    """
    record = rough_starts()[document["name"]]
    claims = {**document["claims"], "starting-order": target.order}
    if "linear" in record:
        linear = record["linear"]
        pairs = stored("starts.json")["pairs"][str(linear["moments"])]
        opening, closing = linear_start(pairs, target, L, **linear)
        blocks = {"starting": opening, "finishing": closing}
        return {**document, **blocks, "digits": DIGITS, "claims": claims}
    opening, closing = complete(
        starting_block(
            record["start"]["pairs"],
            record["start"]["values"],
            root="i" if document["V"][1][1] == "0" else "w3",
            free="finish" in record,
            last_even=parity < 0,
        ),
        finishing_block(**record["finish"]) if "finish" in record else None,
        target,
    )
    blocks = (
        {"starting": opening} if closing is None else {"starting": opening, "finishing": closing}
    )
    return {**document, **blocks, "digits": DIGITS, "claims": claims}


def finish(rough: Rough, *, start: bool = True) -> tuple[dict[str, Any], list[Statement]]:
    """Polish, prove and complete one method, with start and finish where they are on record.

    Raises
    ------
    ConvergenceError, ExactnessError
        When the start leads to no root, or the proof fails.
    """
    document = rough.ansatz.document()
    point = [Exact(Fraction(x)) for x in rough.start.split()]
    document = fill(document, polish(conditions_of(document).residuals, point))
    enclosure = prove(document)
    r = len(document["V"])
    document["claims"] = {
        "order": enclosure.order,
        "stage-order": enclosure.root.enclosed.q,
        **rough.claims,
        **SYMMETRIC,
        "conjugate-symplectic": True,
        "explicit": False,
        "growth": ["0"] * (r - 1),
    }
    document["source"] = derived_source(rough.where)
    notes = [GROWS.format(rough.grows)] if rough.grows else []
    if notes := notes + long_notes(document["name"]):
        document["notes"] = notes
    statements = [_statement(document, enclosure)]
    if start and document["name"] in rough_starts():
        target = Target.of(document, enclosure.root.record)
        assert enclosure.signs is not None  # it has an involution
        document = with_start(document, target, enclosure.signs[0][3], enclosure.involution)
        stages = [len(document[x]["A"]) for x in ("starting", "finishing")]
        text = (
            f"{document['name']}: start of {stages[0]} stages and finish of {stages[1]} "
            f"exact within the digits on all trees of order {enclosure.order} or less"
        )
        statements.append(Statement(text, Proof.ENCLOSED))
    return document, statements


def deriver(
    recipe: str, table: Mapping[str, Rough]
) -> Callable[[Mapping[str, str], Progress], Derivation]:
    """Return the derivation of one method of a table, or of all of them.

    It raises a UsageError for a name that is not in the table.
    """

    def derive(options: Mapping[str, str], progress: Progress) -> Derivation:
        name = one_of("name", options["name"], ("all", *table))
        start = one_of("start", options["start"], ("yes", "no")) == "yes"
        chosen = list(table) if name == "all" else [name]
        makers = {each: partial(finish, table[each], start=start) for each in chosen}
        return in_turn(recipe, makers, progress)

    return derive


def _statement(document: Mapping[str, Any], enclosure: Enclosure) -> Statement:
    text = (
        f"{document['name']}: exactly one solution within 1e-60 of the digits; "
        f"order {enclosure.order}, G-symplectic, symmetric and "
        f"parasitism-free there; order {enclosure.order + 1} refuted by {enclosure.next_order:.2e}"
    )
    return Statement(text, Proof.ENCLOSED)
