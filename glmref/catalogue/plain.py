"""The plain dialect: a tableau as its owner writes it, turned into a document of the format.

A file without ``format`` is in this dialect. Its numbers may be numbers or texts; an order stands
on top, under ``claims``, with a row or with a part; embedded rows may have no names. Each order is
at least what the owner says, not the largest: see :class:`Said`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice
from numbers import Integral, Number
from typing import Any

from ..errors import DataError, did_you_mean
from ..exact import Scalar
from ..exact.expression import parse
from ..system.arguments import listed, unknown_key, whole
from ..system.arguments import shown as printable
from .claims import (
    ABSCISSAE,
    DENSE_ORDER,
    EMBEDDED_DIFFERENCE,
    EMBEDDED_ORDER,
    NYSTROM_ORDER,
    ORDER,
    W_ORDER,
    PlainClaims,
    Said,
)
from .keys import BLOCKS, COMMON, FORMATS, MAX_SIZE, class_of_keys, name_of, needed_keys, of_second
from .keys import MAX_ORDER as MAX_CLAIMED
from .numbers import entry, listed_out, rational_text
from .strict_json import shown

#: Orders on top of a document, by the claim that each is.
_ORDERS = {"order": ORDER.key, "w_order": W_ORDER.key, "dense_order": DENSE_ORDER.key}
#: Keys of embedded rows: of the weights of a solution, and of those of an error estimate.
_WEIGHTS = {"nystrom": ("b", "b_prime"), "glm": ("b", "v")}
_ERRORS = {"b": "error", "b_prime": "error_prime"}
#: Blocks whose entries are one vector, which may be given as a matrix of one row or one column.
_VECTORS = frozenset(["b", "c", "b_prime", "b_hat"])
#: Blocks that hold words.
_WORDS = frozenset(["base", "first", "stages", "name", "kind"])
MAX_DIGITS, MAX_ORDER = 150, 100
_ROW = '{"b": [1, 0], "order": 1}'
_NYSTROM_ROW = '{"b": [1, 0], "b_prime": [1, 0], "order": 1}'


def normalised(document: Mapping[str, Any], where: str) -> tuple[dict[str, Any], PlainClaims]:
    """Turn a plain document into one of the format, with what it says of itself.

    Its keys are those of a class of the format, and ``order``, ``w_order``, ``dense_order``,
    ``digits``. Entries may be numbers of any kind, also of numpy, mpmath, sympy. A method without a
    name is called after its file, ``where``.

    Raises
    ------
    DataError
        For what is not understood, naming the key.
    """
    return _Plain(document, where).read()


def as_written(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document with its decimals taken as the numbers that they write."""

    def written(value: Any) -> Any:
        if isinstance(value, str):
            return rational_text(value)
        if isinstance(value, Mapping):
            return {k: x if k in _WORDS else written(x) for k, x in value.items()}
        return list(map(written, value)) if isinstance(value, list | tuple) else value

    kept = {k: x if k in COMMON | _WORDS else written(x) for k, x in document.items()}
    kept.pop("digits", None)
    return {**kept, "constants": written(kept["constants"])} if "constants" in kept else kept


class _Plain:
    def __init__(self, document: Mapping[str, Any], where: str) -> None:
        self.given = {str(k): x for k, x in document.items() if x is not None}
        self.where = where
        self.said: list[Said] = []
        digits = self.given.get("digits")
        self.digits = None if digits is None else _whole("digits", digits, MAX_DIGITS)

    def read(self) -> tuple[dict[str, Any], PlainClaims]:
        kind = self.given.get("class")
        kind = class_of_keys(self._keys()) if kind is None else _string("class", kind)
        if kind not in BLOCKS:
            raise DataError(self._no_class())
        said = {key: self.given[key] for key in _ORDERS if key in self.given}
        blocks = self.given.keys() - COMMON - said.keys()
        unknown = sorted(blocks - BLOCKS[kind] - ({"c"} if kind in ("additive", "glm") else set()))
        if unknown:
            keys = sorted(BLOCKS[kind] | _ORDERS.keys() | {"digits", "name"})
            weights = unknown[0].startswith("b") and "embedded" in keys
            raise DataError(
                unknown_key(unknown, keys, f" for class {kind!r}")
                + ("; the weights of an embedded method are a row of `embedded`" if weights else "")
            )
        found = {key: x for key, x in self.given.items() if key in COMMON and key != "name"}
        if self.digits is not None:
            found["digits"] = self.digits
        for key in blocks - {"parts", "embedded", "claims"}:
            found[key] = self._block(self.given[key], key)
        times = self._parts(found) if kind == "additive" else None
        claims = self._claims(kind, said)
        if "embedded" in self.given:
            found["embedded"] = self._embedded(kind, found)
            names = [row["name"] for row in found["embedded"]]
            orders = {names[x.number - 1]: x.order for x in self.said
                      if x.claim == EMBEDDED_ORDER.key and x.order <= MAX_CLAIMED}  # fmt: skip
            if len(orders) == len(names):
                claims[EMBEDDED_ORDER.key] = orders
            else:
                claims.pop(EMBEDDED_ORDER.key, None)
        if kind == "glm" and "c" in found:
            claims.setdefault(ABSCISSAE.key, found.pop("c"))
        self._finish(kind, found, claims)
        claims.said, claims.times = tuple(self.said), times
        return found, claims

    def _keys(self) -> dict[str, Any]:
        """Return the keys that tell the class: a splitting needs not say what is first."""
        keys = {k: x for k, x in self.given.items() if k not in _ORDERS}
        if keys.keys() - COMMON == {"a", "b"}:
            a, b = (len(listed(x, listed_out(keys[x]), error=DataError)) for x in "ab")
            if a != b:
                keys["first"] = self.given["first"] = "q" if a > b else "p"
        return keys

    def _no_class(self) -> str:
        given = self.given.keys() - COMMON - _ORDERS.keys()
        if "class" in self.given:
            said = f"`class` must be one of {', '.join(BLOCKS)}, got {shown(self.given['class'])}"
            return said + did_you_mean(str(self.given["class"]), BLOCKS, "; ")
        if given == {"a", "b"}:
            return (
                'the key `first` is missing; with as many a as b, "first": "q" or "first": "p" '
                "says with which of the two the step begins (a updates q, b updates p)"
            )
        for first, kind in (("b_prime", "nystrom"), ("gamma", "rosenbrock"), ("U", "glm"),
                            ("A_hat", "partitioned-rk"), ("beta", "lmm"), ("A", "rk"),
                            ("b", "rk")):  # fmt: skip
            missing = sorted(needed_keys(kind) - given)
            if first in given and missing:
                return (
                    f"the key {missing[0]!r} is missing; a tableau with {first!r} needs "
                    f"{', '.join(sorted(needed_keys(kind)))}"
                )
        return (
            f"the key `class` is missing; the class follows from the keys, such as A, b or "
            f"A, U, B, V or alpha, beta, and not from {', '.join(sorted(given)) or 'none'}"
        )

    def _finish(self, kind: str, found: dict[str, Any], claims: PlainClaims) -> None:
        """Add what a document of the format has besides."""
        text = printable(_string("name", self.given.get("name", "")), str, 1000)
        stem = self.where.removesuffix(".json").removesuffix(".toml")
        for name in (text, stem):
            slug = name_of(name)
            if slug:
                break
        found |= {"class": kind, "name": slug or "unnamed"}
        if text and text != slug:
            found.setdefault("title", "".join(x if x.isprintable() else "?" for x in text))
        claims.name = text
        found.setdefault("source", {})
        found["claims"] = claims
        found["format"] = FORMATS[bool(of_second(found))]

    # --- numbers ---------------------------------------------------------------------------------

    def _block(self, value: Any, key: str) -> Any:
        """Return a block with its numbers as texts."""
        value = listed_out(value)
        if key in _WORDS or isinstance(value, bool):
            return value
        if isinstance(value, Mapping):
            return {str(k): x if k in _WORDS or k == "order" else self._block(x, f"{key}.{k}")
                    for k, x in value.items()}  # fmt: skip
        name = key.rpartition(".")[2]
        if name in _VECTORS:
            return self._vector(value, key)
        if isinstance(value, list | tuple):
            return self._entries(value, key)
        one = entry(value, key, self.digits)
        return [[one]] if name.startswith("A") else [one]

    def _entries(self, value: Sequence[Any], key: str) -> list[Any]:
        found = [listed_out(x) for x in islice(value, MAX_SIZE + 1)]
        if len(found) > MAX_SIZE:
            raise DataError(f"`{key}` has more than {MAX_SIZE} entries")
        return [
            self._entries(x, f"{key}[{i}]")
            if isinstance(x, list | tuple)
            else entry(x, f"{key}[{i}]", self.digits)
            for i, x in enumerate(found, 1)
        ]

    def _vector(self, value: Any, key: str) -> list[Any]:
        value = listed_out(value)
        if not isinstance(value, list | tuple):
            return [entry(value, key, self.digits)]
        rows = [listed_out(x) for x in islice(value, MAX_SIZE + 1)]
        flat = [x for x in rows if isinstance(x, list | tuple)]
        if flat and len(flat) == len(rows) and (len(rows) == 1 or {len(x) for x in flat} == {1}):
            rows = [x for row in flat for x in row]
        return self._entries(rows, key)

    # --- what is said ----------------------------------------------------------------------------

    def _claims(self, kind: str, said: Mapping[str, Any]) -> PlainClaims:
        """Join the orders on top with those under ``claims``."""
        given = self.given.get("claims", {})
        if not isinstance(given, Mapping):
            raise DataError(f"`claims` must be an object of claims, got {shown(given)}")
        claims = PlainClaims(given)
        for key, claim in _ORDERS.items():
            names = [claim, NYSTROM_ORDER.key] if (kind, key) == ("nystrom", "order") else [claim]
            orders = [_whole(f"claims.{x}", claims.pop(x), MAX_ORDER) for x in names if x in claims]
            orders += [_whole(key, said[key], MAX_ORDER)] if key in said else []
            if len(set(orders)) > 1:
                raise DataError(
                    f"`{key}` is {orders[-1]} and `claims.{claim}` {orders[0]}; keep one"
                )
            if orders:
                _claim(claims, names[-1], orders[0])
                self.said.append(Said(claim, orders[0]))
        if "dense_order" in said and "dense" not in self.given:
            raise DataError("`dense` is missing, of which `dense_order` says something")
        if "w_order" in said and kind != "rosenbrock":
            raise DataError(f"`w_order` is said of Rosenbrock methods, and the class is {kind!r}")
        if "dense" in self.given and not any(x.claim == DENSE_ORDER.key for x in self.said):
            orders = [x.order for x in self.said if x.claim == ORDER.key]
            if orders:
                self.said.append(Said(DENSE_ORDER.key, orders[0]))
                _claim(claims, DENSE_ORDER.key, orders[0])
        return claims

    def _parts(self, found: dict[str, Any]) -> tuple[Any, ...] | None:
        """Read the parts of an additive method, with their orders and where they are evaluated."""
        given = self.given["parts"]
        if not isinstance(given, list | tuple) or not 2 <= len(given) <= 9:
            raise DataError("`parts` must be a list of 2 to 9 methods, each with A and b")
        common = found.pop("c", None)
        found["parts"], times = [], []
        for n, part in enumerate(given, 1):
            if not isinstance(part, Mapping) or not {"A", "b"} <= part.keys():
                raise DataError(f"`parts[{n}]` needs A and b")
            _only(part, ("A", "b", "c", "order"), f"parts[{n}]")
            read = {k: self._block(part[k], f"parts[{n}].{k}") for k in part if k != "order"}
            times.append(read.pop("c", common))
            found["parts"].append(read)
            if "order" in part:
                self.said.append(Said("part", _whole(f"parts[{n}].order", part["order"]), n))
        return tuple(times) if any(x is not None for x in times) else None

    def _embedded(self, kind: str, found: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Name the embedded rows, and take their orders out."""
        keys = _WEIGHTS.get(kind, ("b",))
        example = (
            _NYSTROM_ROW if kind == "nystrom" else f"a row with its order, as ([1, 0], 1) or {_ROW}"
        )
        given = listed_out(self.given["embedded"])
        if isinstance(given, Mapping) or _is_pair(given) or _is_row(given):
            given = [given]
        given = listed("embedded", given, f"a list of rows, such as {example}", DataError)
        if len(given) > MAX_SIZE:
            raise DataError(f"`embedded` has more than {MAX_SIZE} rows")
        orders = self.given.get("claims", {}).get(EMBEDDED_ORDER.key, {})
        rows = []
        for n, x in enumerate(given, 1):
            where, x = f"embedded[{n}]", listed_out(x)
            if _is_pair(x):
                x = {"b": x[0], "order": x[1]}
            elif len(keys) == 1 and _is_row(x):
                x = {"b": x}
            if not isinstance(x, Mapping):
                raise DataError(f"`{where}` must be {example}")
            errors = tuple(_ERRORS.get(k, k) for k in keys)
            _only(x, (*keys, *errors, "order", "name"), where)
            used = errors if errors[0] in x else keys
            if x.keys() - {"order", "name"} != set(used):
                raise DataError(
                    f"`{where}` needs either {' and '.join(keys)} or {' and '.join(errors)}, and "
                    f"an order, as {example.rpartition(' or ')[2]}; it has "
                    f"{', '.join(map(str, x)) or 'no key'}"
                )
            name = "embedded" if len(given) == 1 else f"embedded-{n}"
            name = _string(f"{where}.name", x.get("name", name))
            order = x.get("order", orders.get(name) if isinstance(orders, Mapping) else None)
            claim = EMBEDDED_DIFFERENCE.key if order is None else EMBEDDED_ORDER.key
            least = 0 if order is None else _whole(f"{where}.order", order)
            self.said.append(Said(claim, least, n))
            rows.append({"name": name, **self._row(kind, x, used, where, found)})
        return rows

    def _row(
        self, kind: str, x: Mapping[str, Any], used: Sequence[str], where: str,
        found: Mapping[str, Any],
    ) -> dict[str, Any]:  # fmt: skip
        """Return the weights of a row under the keys that its class has."""
        plain = len(used) == 1
        row: dict[str, Any] = {}
        for key in used:
            place = where if plain else f"{where}.{key}"
            given = listed_out(x[key])
            several = kind == "additive" and isinstance(listed_out(given[0]), list | tuple)
            row[key] = self._entries(given, place) if several else self._vector(given, place)
            if kind == "additive" and not several:
                row[key] = [row[key]] * len(found["parts"])
        if used[0] != "error" or kind == "rk":
            return row
        if kind == "additive":
            main = [[part["b"] for part in found["parts"]]]
            return {"b": [_minus(b, e, where) for b, e in zip(main[0], row["error"], strict=True)]}
        keys = _WEIGHTS.get(kind, ("b",))
        return {k: _minus(found[k], row[e], where) for k, e in zip(keys, used, strict=True)}


def _claim(claims: dict[str, Any], claim: str, order: int) -> None:
    """Add an order to the claims, where the format has one as large."""
    if order <= MAX_CLAIMED:
        claims[claim] = order


def _minus(b: Sequence[Any], e: Sequence[Any], where: str) -> list[Any]:
    """Return the weights of a solution: b less those of its error estimate."""
    if len(b) != len(e):
        raise DataError(f"`{where}` must have {len(b)} entries, as `b` has, got {len(e)}")
    return [_difference(x, y) for x, y in zip(b, e, strict=True)]


def _difference(x: str | Scalar, y: str | Scalar) -> Any:
    if isinstance(x, str) and isinstance(y, str):
        return f"({x})-({y})"
    return (parse(x) if isinstance(x, str) else x) - (parse(y) if isinstance(y, str) else y)


def _is_pair(given: Any) -> bool:
    """Return whether this is a row and its order, not a row of two numbers nor two rows."""
    pair = isinstance(given, list | tuple) and len(given) == 2
    return pair and isinstance(given[1], Integral) and not isinstance(given[0], Number | str)


def _is_row(given: Any) -> bool:
    """Return whether this is a list of numbers."""
    return (
        isinstance(given, list | tuple)
        and bool(given)
        and not any(isinstance(x, Mapping | list | tuple) or hasattr(x, "tolist") for x in given)
    )


def _only(given: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
    """Refuse a key, of which nothing would be checked."""
    other = [x for x in given if x not in keys]
    if other:
        raise DataError(
            f"`{where}` has the key {str(other[0])[:60]!r}; its keys are {', '.join(keys)}"
        )


def _string(where: str, value: Any) -> str:
    if not isinstance(value, str):
        raise DataError(f"`{where}` must be a text, got {shown(value)}")
    return value


def _whole(name: str, value: Any, most: int = MAX_ORDER) -> int:
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return whole(name, value, 1, most, DataError)
