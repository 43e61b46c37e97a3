"""What a recipe returns, how its methods are made one after another, and how options are read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any, TypeVar

from ...catalogue.reader import load_document
from ...errors import ExactnessError, GlmrefError, UsageError
from ...exact import Exact
from ...exact.expression import parse
from ...findings import Proof
from ...prove.verifier import verify
from ...system.arguments import one_of
from ..search import Found

#: Largest residual in double precision of an end that is taken for a solution.
SOLVED = 1e-10

#: Called with (what is done, steps done, steps in all).
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Statement:
    """One thing that was found, and how it was proved."""

    text: str
    proof: Proof


@dataclass(frozen=True)
class Derivation:
    """What a recipe found."""

    recipe: str  #: Its name.
    documents: Sequence[Mapping[str, Any]]  #: Method documents, complete and proved.
    statements: Sequence[Statement]  #: What was proved on the way.
    refused: bool = False  #: Whether the requested method does not exist.


_Numbers = TypeVar("_Numbers")
#: Makes a document with what was proved of it.
Make = Callable[[], tuple[dict[str, Any], Sequence[Statement]]]


def in_turn(recipe: str, makers: Mapping[str, Make], progress: Progress) -> Derivation:
    """Return the derivation of several methods, one after another, by their names."""
    documents, statements = [], list[Statement]()
    for k, (name, make) in enumerate(makers.items()):
        progress(name, k, len(makers))
        document, proved = make()
        documents.append(document)
        statements += proved
    progress("done", len(makers), len(makers))
    return Derivation(recipe, documents, statements)


def completed(
    recipe: str,
    numbers: Mapping[str, _Numbers],
    complete: Callable[[str, _Numbers, str], tuple[dict[str, Any], Sequence[Statement]]],
    progress: Progress,
    where: str = "",
) -> Derivation:
    """Return the derivation of methods from their numbers, by name.

    ``where`` says for the files what was given, by default the recipe and the name.
    """
    makers = {
        name: partial(complete, name, of, where or f"recipe {recipe}, name = {name}")
        for name, of in numbers.items()
    }
    return in_turn(recipe, makers, progress)


def searched(
    recipe: str,
    ends: Iterable[Found],
    make: Callable[[Found], tuple[dict[str, Any] | None, Sequence[Statement]]],
    *,
    wanted: int,
    methods: str = "methods",
) -> Derivation:
    """Return the derivation of the first methods that are wanted of a search.

    ``make`` completes an end that is a solution, to ``None`` where it is not of the kind requested;
    ``methods`` is what they are called.
    """
    documents, statements = [], list[Statement]()
    best, count = float("inf"), 0
    for found in ends:
        best, count = min(best, found.residual), count + 1
        if found.residual > SOLVED or len(documents) >= wanted:
            continue
        try:
            document, proved = make(found)
        except GlmrefError as error:
            document, proved = None, [Statement(f"start {found.number}: {error}", Proof.MEASURED)]
        documents += [document] if document else []
        statements += proved
    text = f"{count} starts, smallest residual {best:.3g}, {len(documents)} {methods} completed"
    return Derivation(recipe, documents, [*statements, Statement(text, Proof.MEASURED)])


def proved_exactly(document: Mapping[str, Any]) -> Statement:
    """Verify all claims of a method document exactly.

    Raises
    ------
    ExactnessError
        Naming the claims that fail, which would be an error of the recipe.
    """
    findings = verify(load_document(document, where=document["name"]))
    failing = [x.claim for x in findings if str(x.verdict) != "holds"]
    if failing or any(x.proof is not Proof.EXACT for x in findings):
        raise ExactnessError(f"{document['name']}: not proved exactly: {', '.join(failing)}")
    return Statement(f"{document['name']}: {', '.join(x.claim for x in findings)}", Proof.EXACT)


def complete_exactly(
    document: dict[str, Any], claims: Mapping[str, Any], source: Mapping[str, Any],
    notes: Sequence[str],
) -> None:  # fmt: skip
    """Add claims, of which each is proved exactly, source and notes to a document.

    Raises
    ------
    ExactnessError
        Naming the claims that are not.
    """
    document |= {"claims": dict(claims), "source": dict(source)}
    if notes:
        document["notes"] = list(notes)
    proved_exactly(document)


def rational_option(name: str, text: str) -> Fraction:
    """Read an option that is a rational number.

    Raises
    ------
    UsageError
        For any other text.
    """
    value = parse(text)
    fraction = value.as_fraction() if isinstance(value, Exact) else None
    if fraction is None:
        raise UsageError(f"`{name}` must be rational, such as 1/3, got {text!r}")
    return fraction


def chosen(name: str, shipped: Mapping[str, _Numbers]) -> Mapping[str, _Numbers]:
    """Return the shipped method of the name that is given, or all of them.

    Raises
    ------
    UsageError
        For a name that is not shipped.
    """
    return {name: shipped[one_of("name", name, shipped)]} if name else shipped
