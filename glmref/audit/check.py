"""Check one tableau, however it comes: :func:`check`, and what the command line prints of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ..catalogue.claims import PlainClaims
from ..catalogue.reader import load_document
from ..errors import DataError, GlmrefError
from ..findings import Finding, Verdict
from ..prove.verifier import verify
from ..system.shown import ShownList
from ..views.tables import shown_value


class CheckFailed(GlmrefError, AssertionError):
    """A tableau is not what is said of it; ``findings`` holds everything that was found."""

    findings: tuple[Finding, ...]

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = tuple(findings)
        wrong = [x for x in findings if x.verdict is Verdict.FAILS]
        super().__init__("; ".join(sentence(x) for x in wrong))


def sentence(x: Finding) -> str:
    """Return one finding in words."""
    head = f"{x.method}: " if x.method else ""
    row = x.claim.removeprefix("order of ")
    declared, found = shown_value(x.declared), f"found {shown_value(x.value)}"
    head += f"{x.claim} {declared}" if row == x.claim else f"order {declared} of {row}"
    if x.verdict is Verdict.HOLDS:
        return f"{head} holds" + (f" ({x.witness})" if x.witness else "")
    if x.verdict is Verdict.OPEN:
        return f"{head} is not decided: {x.witness}"
    more = isinstance(x.value, int) and isinstance(x.declared, int) and x.value > x.declared
    if x.witness == found or (x.witness and not more):
        return f"{head} fails: {x.witness}"
    return f"{head} fails: " + "; ".join(y for y in (found, x.witness) if y)


def check(
    A: Any,
    b: Any = None,
    c: Any = None,
    *,
    order: int | None = None,
    embedded: Any = None,
    digits: int | None = None,
    **more: Any,
) -> list[Finding]:
    """Check a tableau against what is said of it.

    Parameters
    ----------
    A : array_like, mapping or object
        Matrix (s, s); or everything at once, a mapping with the keys below or an object with
        attributes ``A``, ``b`` and possibly ``c``. Entries are integers, ``Fraction``, strings as
        ``"(3-sqrt(3))/6"``, mpmath, sympy and numpy numbers. A float is the decimal as which it
        prints; one of more than 11 digits after the point is rounded, and known to its digits.
    b : array_like
        Weights (s,).
    c : array_like, optional
        Abscissae (s,). Where they differ from A 1, the order is that on ``y' = f(t, y)``.
    order : int
        The order that the tableau is said to have, at least.
    embedded : array_like or (array_like, int) or mapping or list of these, optional
        Further rows of weights, each with its order: ``([1, 0], 1)`` or ``{"b": .., "order": 1}``,
        or without, when the weights of the error estimate must sum to 0;
        ``{"error": .., "order": ..}`` gives b minus the row. A row of a Nystrom method has
        ``b_prime`` beside ``b``, or ``error_prime`` beside ``error``.
    digits : int, optional
        Digits after the point to which floats and decimals are known; no verdict is drawn from
        what lies within them.
    **more
        ``U``, ``B``, ``V``: a general linear method; ``beta`` with ``alpha``: a multistep method;
        ``parts``, a list of ``{"A", "b", "c", "order"}``: an additive method on shared stages;
        ``b_prime`` and ``A_prime``: a Nystrom method (A, b, b', c); ``alpha`` and ``gamma`` in
        place of A, with ``w_order``: a Rosenbrock method; ``dense`` (s, d), the coefficients of
        theta, theta^2, .. of ``b_i(theta)``, with ``dense_order``; ``name``.

    Returns
    -------
    list of Finding
        One for each thing that was said; ``open`` where the digits given do not decide it.

    Raises
    ------
    CheckFailed
        When something fails, with the first tree whose condition does. It is an
        ``AssertionError``.
    DataError
        For what is no tableau.
    """
    document = _document(A, b, c, order=order, embedded=embedded, digits=digits, **more)
    findings = examine(document)
    if any(x.verdict is Verdict.FAILS for x in findings):
        raise CheckFailed(findings)
    return ShownList(findings)


def assert_tableau(A: Any, b: Any = None, c: Any = None, **said: Any) -> None:
    """Assert in a test what is said of a tableau: :func:`check`, with nothing of ours on the stack.

    Parameters
    ----------
    A, b, c, **said
        As :func:`check` takes them. A table of rounded numbers needs ``digits``; it passes when no
        condition fails within them.

    Raises
    ------
    CheckFailed
        When something fails.
    """
    __tracebackhide__ = True
    document = _document(A, b, c, **said)
    findings = examine(document)
    if any(x.verdict is Verdict.FAILS for x in findings):
        raise CheckFailed(findings)


def _document(A: Any, b: Any, c: Any, **said: Any) -> dict[str, Any]:
    """Return everything under its key, from any of the ways to call."""
    given: dict[str, Any] = {}
    if isinstance(A, Mapping):
        given = dict(A)
    elif hasattr(A, "A") and b is None:
        given = {"A": A.A, "b": getattr(A, "b", None), "c": getattr(A, "c", None)}
        if given["b"] is None and hasattr(A, "B") and hasattr(A, "V"):
            if len(A.V) != 1:
                raise DataError(
                    f"the method carries {len(A.V)} values; a tableau of one has A and b: "
                    f"`glmref.analyze` computes the order of any method"
                )
            given["b"] = A.B[0]
    else:
        given["A"] = A
    given |= {"b": b} if b is not None else {}
    given |= {"c": c} if c is not None else {}
    given |= {key: value for key, value in said.items() if value is not None}
    return {key: value for key, value in given.items() if value is not None}


def examine(document: Mapping[str, Any], where: str = "tableau") -> tuple[Finding, ...]:
    """Return findings about everything that a document says of its tableau; see :func:`check`.

    Raises
    ------
    DataError
        For what is no tableau, naming the key, and where nothing is said.
    """
    method = load_document(document, where=where)
    if not (method.claims or getattr(method.claims, "said", ())):
        raise DataError('nothing is said that could be checked; give `order`, as in "order": 4')
    findings = verify(method)
    if isinstance(method.claims, PlainClaims):
        findings = [replace(x, method=method.claims.name) for x in findings]
    return tuple(findings)
