"""Check one tableau, however it comes: :func:`check`, and what the command line prints of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isfinite
from numbers import Integral, Number
from typing import Any

from ..catalogue.keys import MAX_SIZE
from ..errors import DataError, GlmrefError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector, row_sums
from ..findings import Finding, Verdict
from ..prove.digits import rounded_up
from ..prove.kernel import Reach, reaches, vanishing
from ..system.arguments import listed, shown, whole
from .numbers import Reader
from .orders import (
    LARGEST,
    Scheme,
    additive,
    dense_output,
    further,
    merged,
    nystrom,
    reach,
    rosenbrock,
    runge_kutta,
    w_method,
)

#: Keys of a document by the kind of method; a key of another kind would say nothing.
_ALWAYS = {"name", "digits", "order"}
_KEYS: Mapping[str, set[str]] = {
    "an additive method": _ALWAYS | {"parts", "c", "embedded"},
    "a Rosenbrock method": _ALWAYS | {"alpha", "gamma", "b", "w_order", "embedded"},
    "a Nystrom method": _ALWAYS | {"A", "b", "c", "b_prime", "A_prime", "embedded"},
    "a Runge-Kutta method": _ALWAYS | {"A", "b", "c", "embedded", "dense", "dense_order"},
}
KEYS = set[str]().union(*_KEYS.values())


#: A residual of trees through order 8 that says that c is A 1 but for rounding.
_ROUNDING = 1e-9
#: Through which order decimals are looked at as they are written; rounded ones fail before.
_LITERAL = 6


class CheckFailed(GlmrefError, AssertionError):
    """A tableau is not what is said of it; ``findings`` holds everything that was found."""

    findings: tuple[Finding, ...]

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.findings = tuple(findings)
        wrong = [x for x in findings if x.verdict is Verdict.FAILS]
        super().__init__("; ".join(sentence(x) for x in wrong))


def sentence(x: Finding) -> str:
    """One finding in words."""
    head = f"{x.method}: " if x.method else ""
    row = x.claim.removeprefix("order of ")
    head += f"{x.claim} {x.declared}" if row == x.claim else f"order {x.declared} of {row}"
    if x.verdict is Verdict.HOLDS:
        return f"{head} holds" + (f" ({x.witness})" if x.witness else "")
    word = "is not decided" if x.verdict is Verdict.OPEN else "fails"
    return f"{head} {word}: {x.witness}"


def check(
    A: Any,
    b: Any = None,
    c: Any = None,
    *,
    order: int | None = None,
    embedded: Any = None,
    digits: int | None = None,
    **more: Any,
) -> tuple[Finding, ...]:
    """Check a tableau against what is said of it.

    Parameters
    ----------
    A : array_like, mapping or object
        Matrix (s, s); or everything at once, a mapping with the keys below or an object with
        attributes ``A``, ``b`` and possibly ``c``. Entries are integers, ``Fraction``, strings as
        ``"(3-sqrt(3))/6"``, mpmath, sympy and numpy numbers. A float is the binary fraction that
        it is.
    b : array_like
        Weights (s,).
    c : array_like, optional
        Abscissae (s,). Where they differ from A 1, the order is that on ``y' = f(t, y)``.
    order : int
        The order that the tableau is said to have, at least.
    embedded : (array_like, int) or mapping or list of these, optional
        Further rows of weights, each with its order: ``([1, 0], 1)`` or ``{"b": .., "order": 1}``;
        ``{"error": .., "order": ..}`` gives b minus the row. A row of a Nystrom method has
        ``b_prime`` beside ``b``, or ``error_prime`` beside ``error``.
    digits : int, optional
        Digits after the point to which floats and decimals are known; no verdict is drawn from
        what lies within them.
    **more
        ``parts``, a list of ``{"A", "b", "c", "order"}``: an additive method on shared stages;
        ``b_prime`` and ``A_prime``: a Nystrom method (A, b, b', c); ``alpha`` and ``gamma`` in
        place of A, with ``w_order``: a Rosenbrock method; ``dense`` (s, d), the coefficients of
        theta, theta^2, .. of ``b_i(theta)``, with ``dense_order``; ``name``.

    Returns
    -------
    tuple of Finding
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
    return findings


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
    """Everything under its key, from any of the ways to call."""
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


@dataclass(frozen=True)
class _Row:
    """Something that has an order: its name, what is said, and its schemes."""

    claim: str
    declared: int
    schemes: Sequence[Scheme]
    remark: str = ""


def examine(document: Mapping[str, Any]) -> tuple[Finding, ...]:
    """Findings of a plain document, whatever they are; see :func:`check` for its keys.

    Raises
    ------
    DataError
        For what is no tableau, naming the key.
    """
    unknown = [x for x in document if x not in KEYS]
    if str(document.get("format", "")).startswith("glmref-method-"):
        raise DataError("this is a method file; `glmref verify FILE` recomputes its claims")
    if unknown:
        raise DataError(f"the key {unknown[0]!r} is not known; known are {', '.join(sorted(KEYS))}")
    kind = _kind(document)
    idle = [x for x in document if x not in _KEYS[kind]]
    if idle:
        known = ", ".join(sorted(_KEYS[kind]))
        raise DataError(f"`{idle[0]}` is no key of {kind}, whose keys are {known}")
    reader = Reader(_whole(document, "digits", 1, 300))
    rows, more = _rows(document, reader)
    if not (rows or more):
        raise DataError('nothing is said that could be checked; give `order`, as in "order": 4')
    name = shown(document.get("name", ""), str, 1000)
    remark = reader.remark()
    findings = [_judged(row, name, remark, reader.digits) for row in rows]
    if reader.digits is not None and any(x.verdict is Verdict.OPEN for x in findings):
        literal, _ = _rows(document, Reader())
        findings = [
            replace(x, witness=f"{x.witness}; {_as_written(row)}")
            if x.verdict is Verdict.OPEN
            else x
            for x, row in zip(findings, literal, strict=True)
        ]
    return (*findings, *(make(name) for make in more))


def _kind(document: Mapping[str, Any]) -> str:
    """Which kind of method a document is, by the key that the other kinds have not."""
    additive, rosenbrock, nystrom, plain = _KEYS
    if "parts" in document:
        return additive
    if "alpha" in document or "gamma" in document:
        return rosenbrock
    return nystrom if "b_prime" in document else plain


def _only(given: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
    """Refuse a key, of which nothing would be checked."""
    other = [x for x in given if x not in keys]
    if other:
        raise DataError(f"`{where}` has the key {other[0]!r}; its keys are {', '.join(keys)}")


def _as_written(row: _Row) -> str:
    """The order of decimals that are taken for the numbers themselves, with the tree that fails."""
    found = merged([reach(x, min(row.declared, _LITERAL), stop=0.0) for x in row.schemes])
    if found.refuted is None:
        return f"the decimals as written have order {found.proved} or more"
    n = found.refuted
    tree, size = found.first[n - 1], found.sizes[n - 1]
    return (
        f"the decimals as written have order {n - 1} (tree {tree} has residual {_shown(size, 2)})"
    )


def _shown(size: float, digits: int = 3) -> str:
    """A size other than zero, which beyond the range of doubles is infinite, or zero."""
    if not size:
        return "below 1e-308"
    return f"{size:.{digits}g}" if isfinite(size) else "above 1e308"


def _whole(document: Mapping[str, Any], key: str, least: int, most: int) -> int | None:
    value = document.get(key)
    if value is None:
        return None
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return whole(key, value, least, most, DataError)


def _order(document: Mapping[str, Any], key: str = "order") -> int | None:
    return _whole(document, key, 1, 100)


_Rows = tuple[list[_Row], list[Callable[[str], Finding]]]
#: What b and b_prime of a Nystrom method are the weights of.
_POSITION_VELOCITY = ("the position", "the velocity")


def _rows(document: Mapping[str, Any], reader: Reader) -> _Rows:
    kind = _kind(document)
    if kind == "an additive method":
        return _additive(document, reader)
    if kind == "a Rosenbrock method":
        return _rosenbrock(document, reader)
    if "A" not in document or "b" not in document:
        missing = "A" if "A" not in document else "b"
        raise DataError(f"`{missing}` is missing; a tableau needs A and b")
    A = reader.matrix(document["A"], "A")
    s = len(A)
    b = reader.vector(document["b"], "b", s)
    c = reader.vector(document["c"], "c", s) if "c" in document else None
    if "b_prime" in document:
        return _nystrom(document, reader, A, b, c)
    rows = []
    order = _order(document)
    if order is not None:
        remark = "" if c is None else _abscissae(A, c)
        rows.append(_Row("order", order, [runge_kutta(A, b, c)], remark))
    more = _rows_beside(rows, document, reader, [b], lambda row: [runge_kutta(A, row, c)])
    if "dense_order" in document and "dense" not in document:
        raise DataError("`dense` is missing, of which `dense_order` says something")
    if "dense" in document:
        wanted = _order(document, "dense_order") or order or 1
        table = reader.table(document["dense"], "dense", s)
        rows.append(
            _Row("order of the dense output", wanted, dense_output(A, table, c, most=wanted))
        )
    return rows, more


_ROW = 'a row with its order, as ([1, 0], 1) or {"b": [1, 0], "order": 1}'


def _row_with_order(given: Any) -> bool:
    """Whether this is a row and its order, not a row of two numbers nor a list of two rows."""
    pair = isinstance(given, (list, tuple)) and len(given) == 2
    return pair and isinstance(given[1], Integral) and not isinstance(given[0], (Number, str))


def _embedded(
    document: Mapping[str, Any], reader: Reader, main: Sequence[Vector]
) -> list[tuple[list[Vector], int | None]]:
    """Weights of each embedded row, as many vectors as the method itself has, and its order."""
    given = document.get("embedded")
    if given is None:
        return []
    keys = ("b", "b_prime")[: len(main)]
    errors = ("error", "error_prime")[: len(main)]
    example = '{"b": [1, 0], "b_prime": [1, 0], "order": 1}' if len(main) > 1 else _ROW
    plain = len(main) == 1  # the weights of such a row need no key
    if isinstance(given, Mapping) or (plain and _row_with_order(given)):
        given = [given]
    given = listed("embedded", given, f"a list of rows, such as {example}", DataError)
    found: list[tuple[list[Vector], int | None]] = []
    for k, x in enumerate(given, 1):
        if k > MAX_SIZE:
            raise DataError(f"`embedded` has more than {MAX_SIZE} rows")
        where = f"embedded[{k}]"
        if isinstance(x, Mapping):
            _only(x, (*keys, *errors, "order"), where)
            used = errors if "error" in x else keys
            if x.keys() - {"order"} != set(used):
                raise DataError(
                    f"`{where}` needs either {' and '.join(keys)} or {' and '.join(errors)}, and "
                    f"an order, as {example.rpartition(' or ')[2]}; it has "
                    f"{', '.join(map(str, x)) or 'no key'}"
                )
            low = _order(x)
            weights = [
                reader.vector(x[key], where if plain else f"{where}.{key}", len(b))
                for key, b in zip(used, main, strict=True)
            ]
            if used is errors:
                weights = [linalg.sub((b,), (e,))[0] for b, e in zip(main, weights, strict=True)]
        elif plain and _row_with_order(x):
            weights, low = [reader.vector(x[0], where, len(main[0]))], _order({"order": x[1]})
        else:
            raise DataError(f"`{where}` must be {example}")
        found.append((weights, low))
    return found


def _nystrom(
    document: Mapping[str, Any], reader: Reader, A: Matrix, b: Vector, c: Vector | None
) -> _Rows:
    if c is None:
        raise DataError("a Nystrom method needs `c`, beside A, b and b_prime")
    order = _order(document)
    b_prime = reader.vector(document["b_prime"], "b_prime", len(b))
    inner = reader.matrix(document["A_prime"], "A_prime") if "A_prime" in document else None

    def schemes(b: Vector, b_prime: Vector) -> list[Scheme]:
        return [nystrom(A, b, b_prime, c, inner, roots=x) for x in "fk"]

    rows = []
    if order is not None:
        for what, scheme in zip(_POSITION_VELOCITY, schemes(b, b_prime), strict=True):
            rows.append(_Row(f"order of {what}", order, [scheme]))
    return rows, _rows_beside(rows, document, reader, [b, b_prime], schemes)


def _rosenbrock(document: Mapping[str, Any], reader: Reader) -> _Rows:
    for key in ("alpha", "gamma", "b"):
        if key not in document:
            raise DataError(f"`{key}` is missing; a Rosenbrock method needs alpha, gamma and b")
    alpha = reader.matrix(document["alpha"], "alpha")
    gamma = reader.matrix(document["gamma"], "gamma")
    if len(gamma) != len(alpha):
        raise DataError(f"`gamma` has {len(gamma)} rows and `alpha` {len(alpha)}")
    b = reader.vector(document["b"], "b", len(alpha))
    rows = []
    order, w_order = _order(document), _order(document, "w_order")
    if order is not None:
        rows.append(_Row("order", order, [rosenbrock(alpha, gamma, b)]))
    if w_order is not None:
        rows.append(_Row("W-order", w_order, [w_method(alpha, gamma, b)]))
    return rows, _rows_beside(
        rows, document, reader, [b], lambda row: [rosenbrock(alpha, gamma, row)]
    )


def _additive(document: Mapping[str, Any], reader: Reader) -> _Rows:
    parts, times, rows = [], [], []
    given = document["parts"]
    if not isinstance(given, (list, tuple)) or not 2 <= len(given) <= 4:
        raise DataError("`parts` must be a list of two to four methods, each with A and b")
    for k, part in enumerate(given, 1):
        if not isinstance(part, Mapping) or not {"A", "b"} <= part.keys():
            raise DataError(f"`parts[{k}]` needs A and b")
        _only(part, ("A", "b", "c", "order"), f"parts[{k}]")
        A = reader.matrix(part["A"], f"parts[{k}].A")
        if parts and len(A) != len(parts[0][0]):
            raise DataError(f"`parts[{k}].A` has {len(A)} stages and the first part another number")
        b = reader.vector(part["b"], f"parts[{k}].b", len(A))
        c = part.get("c", document.get("c"))
        times.append(None if c is None else reader.vector(c, f"parts[{k}].c", len(A)))
        parts.append((A, b))
        order = _order(part)
        if order is not None:
            rows.append(_Row(f"order of part {k}", order, [runge_kutta(A, b, times[-1])]))
    order = _order(document)
    if order is not None:
        rows.append(_Row("order", order, [additive(parts, times)]))
    return rows, _rows_beside(
        rows, document, reader, [parts[0][1]],
        lambda row: [additive([(A, row) for A, _ in parts], times)],
    )  # fmt: skip


def _rows_beside(
    rows: list[_Row],
    document: Mapping[str, Any],
    reader: Reader,
    main: Sequence[Vector],
    schemes: Callable[..., Sequence[Scheme]],
) -> list[Callable[[str], Finding]]:
    """Add the orders of embedded rows, and return the sums of those that say none."""
    more = []
    parts = [f"{x} of " for x in _POSITION_VELOCITY] if len(main) > 1 else [""]
    for k, (weights, low) in enumerate(_embedded(document, reader, main), 1):
        if low is None:
            for what, b, row in zip(parts, main, weights, strict=True):
                more.append(_difference(f"{what}row {k}", b, row))
        else:
            for what, scheme in zip(parts, schemes(*weights), strict=True):
                rows.append(_Row(f"order of {what}embedded row {k}", low, [scheme]))
    return more


def _difference(row: str, b: Vector, weights: Vector) -> Callable[[str], Finding]:
    total = sum((x - y for x, y in zip(b, weights, strict=True)), Exact(0))
    said = (
        f"b and the row differ in sum by {_shown(total.magnitude())}" if total.magnitude() else ""
    )
    return lambda name: vanishing(total, said).finding(name, f"error weights of {row} sum to", 0)


def _abscissae(A: Matrix, c: Vector) -> str:
    """A remark where c is not A 1: no reason to refuse, the order says what counts."""
    sums = row_sums(A)
    gaps = [abs(complex(x - y)) for x, y in zip(sums, c, strict=True)]
    worst = max(range(len(gaps)), key=gaps.__getitem__)
    if gaps[worst] == 0:
        return ""
    if gaps[worst] < _ROUNDING:
        size = rounded_up(Fraction(repr(gaps[worst])))
        return f"row {worst + 1} of A sums to c[{worst + 1}] to {size}"
    return (
        f"row {worst + 1} of A sums to {complex(sums[worst]).real:.12g} and c[{worst + 1}] is "
        f"{complex(c[worst]).real:.12g}: the order is that on y' = f(t, y)"
    )


def _looked(scheme: Scheme, declared: int) -> Reach:
    """What the conditions of a scheme say through the order declared, and a little beyond.

    Trees with leaves for t are looked at through order 8. Where c is A 1 but for rounding, those
    of ``y' = f(y)`` follow beyond: nothing is proved by them, a condition that fails does refute.
    """
    found = _reached(scheme, declared)
    plain, n = scheme.autonomous, len(found.sizes)
    if plain is None or declared <= n or n < LARGEST[2] or found.size(n) > _ROUNDING:
        return found
    beyond = _reached(plain, declared)
    return Reach(
        found.proved,
        found.sizes + beyond.sizes[n:],
        found.trees + beyond.trees[n:],
        beyond.refuted if found.refuted is None else found.refuted,
        found.exact,
        found.first + beyond.first[n:],
    )


def _reached(scheme: Scheme, declared: int) -> Reach:
    """Exact numbers until the first condition that fails, balls from there on: only sizes count."""
    exact = scheme.is_exact
    found = reach(scheme, declared + 2, stop=0.0 if exact else 1.0)
    if not exact or found.refuted is None:
        return further(found, scheme, declared)
    n, scheme = len(found.sizes), scheme.in_balls()
    beyond = further(reach(scheme, declared + 2, stop=1.0), scheme, declared)
    return replace(
        found,
        sizes=found.sizes + beyond.sizes[n:],
        trees=found.trees + beyond.trees[n:],
        first=found.first + beyond.first[n:],
    )


def _judged(row: _Row, name: str, remark: str, digits: int | None) -> Finding:
    """The verdict on an order that is said to be reached."""
    found = merged([_looked(x, row.declared) for x in row.schemes])
    looked = len(found.sizes)
    parts: list[str] = []
    if found.proved >= row.declared:
        if found.proved == LARGEST.get(len(row.schemes[0].palette), 4):
            parts = [f"trees of order {found.proved} or less were looked at"]
        elif found.proved > row.declared:
            parts = [f"the order is {found.proved}"]
        parts += [row.remark, remark]
    elif found.refuted is not None and found.refuted <= row.declared:
        n = found.refuted
        tree, size = found.first[n - 1], found.sizes[n - 1]
        parts = [f"tree {tree} of order {n} has residual {_shown(size)}", found.staircase(),
                 row.remark, remark]  # fmt: skip
    elif looked < row.declared:
        parts = [f"trees of order {looked} or less were looked at, and no condition fails"]
    else:
        size = found.size(row.declared)
        within = f"no condition fails within the {digits} digits"
        parts = [
            f"order {row.declared} to {rounded_up(Fraction(repr(size)))}: {within}",
            row.remark,
        ]
    reason = "; ".join(x for x in parts if x)
    return reaches(found, row.declared, reason).finding(name, row.claim, row.declared)
