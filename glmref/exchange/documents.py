"""Methods as documents: blocks of exact expressions or decimals by name, and method files.

Nothing here is evaluated in doubles: certificates of methods without a file are about these
documents.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..catalogue.keys import completed
from ..catalogue.writer import decimal
from ..errors import ExactnessError, UsageError
from ..exact import Ball, Exact, Scalar
from ..exact.expression import parse, to_text
from ..exact.linalg import Matrix
from ..method import GLM, AdditiveGLM, Method, PartitionedGLM
from .numbers import is_zero

#: Digits after the point of decimals in JSON and CSV, where their enclosure is as narrow.
PLACES = 75

Rows = list[list[str]]


def is_one(x: Scalar) -> bool:
    """Return whether a coefficient is one, or as close to it as counts as one."""
    return (x - 1).is_zero() is True or is_zero(x - 1)


def expression(x: Scalar) -> str | None:
    """Return the exact expression of a number, or ``None`` where it has none."""
    if not isinstance(x, Exact):
        return None
    try:
        return to_text(x)
    except ExactnessError:
        return None


def _all_blocks(method: Method) -> Iterator[tuple[str, Matrix]]:
    """Yield the blocks of a method by name, vectors as one row."""
    if method.additive:
        for n, c in enumerate(method.components):
            yield from ((f"parts.{n}.A", c.A), (f"parts.{n}.b", c.B))
        return
    if method.parts == 2:
        for part, c in zip("qp", method.components, strict=True):
            yield from zip((f"{part}.{x}" for x in "AUBV"), c.matrices, strict=True)
        start = method.starting
        if start is not None:
            hats = start.LETTERS.values()
            yield from ((f"starting.{x}{y}", getattr(start, x + y)) for y in hats for x in "AB")
            yield from ((f"starting.u{y}", (getattr(start, f"u{y}"),)) for y in hats)
        return
    (c,) = method.components
    if method.is_one_step and is_one(c.V[0][0]) and all(is_one(x) for (x,) in c.U):
        yield from (("A", c.A), ("b", c.B))
    else:
        yield from zip("AUBV", c.matrices, strict=True)
    if method.starting is not None and method.starting.A:
        yield from (("starting.A", method.starting.A), ("starting.B", method.starting.B))
        yield "starting.u", (method.starting.u,)
    if method.finishing is not None:
        yield from (("finishing.A", method.finishing.A), ("finishing.b", (method.finishing.b,)))


def places_of(numbers: Sequence[Scalar], wanted: int | None) -> int:
    """Return digits after the point: as many as are wanted and as the narrowest enclosure has."""
    widest = max((x.radius() for x in numbers if isinstance(x, Ball)), default=0.0)
    known = PLACES if widest == 0 else min(PLACES, max(1, math.floor(-math.log10(2 * widest)) - 1))
    return known if wanted is None else min(wanted, known)


def fixed(x: Scalar, places: int) -> str:
    """Return a decimal with so many digits after the point, of a real number."""
    return decimal(x.ball(), places)


def _form_blocks(method: Method) -> Iterator[tuple[str, Matrix]]:
    """Yield the forms and the outputs that a method gives, by their names in a method file."""
    names = {"G": "G", "D": "D", "D_P": "D_P", "D_Q": "D_Q", "output": "output"}
    if method.parts == 2:
        names |= {"output": "q.output", "output_hat": "p.output"}
    for name, place in names.items():
        value = getattr(method, name, None)
        if value is not None:
            yield place, value if name == "G" else (value,)


def method_document(
    method: GLM | PartitionedGLM | AdditiveGLM, name: str, digits: int | None
) -> dict[str, Any]:
    """Return a method file of blocks, starting and finishing method, forms and outputs.

    It claims nothing, and has a name for a method without one. ``digits`` after the point stand for
    decimals instead of expressions.

    Raises
    ------
    UsageError
        For decimals of complex numbers.
    """
    forms = dict(_form_blocks(method))
    beside = dict(_beside(method))
    blocks, places = blocks_of(method, digits, forms | beside)
    found = {name: blocks.pop(name) for name in beside}
    document: dict[str, Any] = {}
    if method.additive:
        _check_one_value(method)
        document["parts"] = [{} for _ in method.components]
    for place, rows in blocks.items():
        *outer, letter = place.split(".")
        if outer[:1] == ["parts"]:
            document["parts"][int(outer[1])][letter] = rows[0] if letter == "b" else rows
            continue
        inside = document.setdefault(outer[0], {}) if outer else document
        inside[letter] = rows if letter[0] in "AUBVG" else rows[0]
    if method.parts == 2:
        document["separable"] = not method.shared
    elif not (method.additive or method.is_real):
        document["field"] = "complex"
    if "b" in document and forms:  # a file of class `rk` has none
        document["B"] = [document.pop("b")]
        document |= {"U": [["1"]] * len(document["A"]), "V": [["1"]]}
    if places is not None:
        document["digits"] = places
    document |= {x: found[x][0] if x == "c" else found[x] for x in ("c", "dense") if x in found}
    if method.embedded and "embedded.0" in found:
        document["embedded"] = [
            {
                "name": row.name,
                "error" if row.difference else "b": rows if method.additive else rows[0],
                **({} if row.values is None else {"v": rows[-1]}),
            }
            for n, row in enumerate(method.embedded)
            for rows in (found[f"embedded.{n}"],)
        ]
    document = completed(document, method.name or name)
    return {key: x for key, x in document.items() if x != {}}


def _beside(method: GLM | PartitionedGLM | AdditiveGLM) -> Iterator[tuple[str, Matrix]]:
    """Yield c, dense output and embedded rows, with the weights of the values last."""
    if method.rosenbrock:
        raise UsageError(f"{method.name or 'the method'} is a Rosenbrock method: save it as it is")
    if method.parts == 2:
        return
    c, dense = (getattr(method, x, None) for x in ("abscissae_given", "dense"))
    yield from (("c", (c,)),) if c is not None else ()
    yield from (("dense", dense),) if dense is not None else ()
    for n, row in enumerate(method.embedded):
        yield f"embedded.{n}", row.weights if row.values is None else (*row.weights, row.values)


def blocks_of(
    method: GLM | PartitionedGLM | AdditiveGLM,
    digits: int | None,
    more: Mapping[str, Matrix] | None = None,
) -> tuple[dict[str, Rows], int | None]:
    """Return the blocks of a method as rows of expressions, and the digits of its decimals, if any.

    Blocks are named such as ``A`` or ``starting.u`` (one row); digits are those after the point,
    ``None`` where every entry is exact.

    Raises
    ------
    UsageError
        For decimals of complex numbers.
    """
    blocks = {**dict(_all_blocks(method)), **(more or {})}
    numbers = [x for matrix in blocks.values() for row in matrix for x in row]
    texts = {id(x): None if digits is not None else expression(x) for x in numbers}
    rough = [x for x in numbers if texts[id(x)] is None and not _is_whole(x)]
    if rough and not all(x.is_real() for x in rough):
        raise UsageError(
            f"{method.name or 'the method'} is complex, and its entries are written as "
            f"expressions only; leave out the number of digits"
        )
    places = places_of(rough, digits) if rough else None

    def text(x: Scalar) -> str:
        found = texts[id(x)]
        if found is not None:
            return found
        return to_text(x) if isinstance(x, Exact) and _is_whole(x) else fixed(x, places or 1)

    return {name: [[text(x) for x in row] for row in m] for name, m in blocks.items()}, places


def _is_whole(x: Scalar) -> bool:
    fraction = x.as_fraction() if isinstance(x, Exact) else None
    return fraction is not None and fraction.denominator == 1


def held(method: Method) -> dict[str, Matrix]:
    """Return the blocks of a method: all that determines it.

    Further weights are a block ``embedded.NAME``, or ``error.NAME`` where they are those of an
    estimate, with a row for each component; those of a method of several values have a second row,
    the weights of the values. ``abscissae`` are those that are not A 1.

    Raises
    ------
    UsageError
        For a pair with embedded rows.
    """
    document, blocks = method.document or {}, dict[str, Matrix]()
    rows = {
        row.name: (
            row.difference,
            row.weights if row.values is None else (*row.weights, row.values),
        )
        for row in method.embedded
    }
    if method.rosenbrock:
        alpha, gamma, b = (getattr(method, x) for x in ("alpha", "gamma", "b"))
        blocks = {"alpha": alpha, "gamma": gamma, "b": (b,)}
        rows = {name: (what, (x[: len(b)],)) for name, (what, (x, _)) in rows.items()}
    elif method.additive:
        _check_one_value(method)
        for n, part in enumerate(method.components, 1):
            blocks |= {f"part{n}.A": part.A, f"part{n}.b": part.B}
    elif document.get("class") == "nystrom":

        def matrix(given: Sequence[Sequence[str]]) -> Matrix:
            return tuple(tuple(parse(x) for x in row) for row in given)

        blocks = {x: matrix(document[x]) for x in ("A", "A_prime") if x in document}
        blocks |= {x: matrix((document[x],)) for x in ("b", "b_prime", "c")}
        rows = {
            x["name"]: (False, matrix((x["b"], x["b_prime"]))) for x in document.get("embedded", ())
        }
    else:
        blocks = dict(_all_blocks(method))
        if rows and method.parts == 2:
            raise UsageError(f"{method.name} is a pair, and its embedded rows have no block here")
        blocks |= {name: rows for name, rows in _form_blocks(method) if "output" in name}
    c, dense = (getattr(method, x, None) for x in ("abscissae_given", "dense"))
    blocks |= {} if c is None else {"abscissae": (c,)}
    blocks |= {} if dense is None else {"dense": dense}
    weights = {f"{('embedded', 'error')[what]}.{name}": x for name, (what, x) in rows.items()}
    return {**blocks, **weights}


def _check_one_value(method: Method) -> None:
    ones = [x for row in (*method.components[0].U, *method.components[0].V) for x in row]
    if method.carried != 1 or not all(map(is_one, ones)):
        raise UsageError("an additive method is written with one value, U = 1 and V = 1, only")
