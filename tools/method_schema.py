"""Write what follows from the table of claims: JSON Schemas and the order of ``data/README.md``.

The schema of ``glmref-method-2`` is that of ``glmref-method-1`` with the keys and classes below.

When a claim is true is said in the table of ``data/README.md`` and nowhere else. ``python -m
tools.method_schema`` rewrites the schemas, brings the rows of the table into the order of the
claims, and the two lists of hashes up to date. Tests in ``tests/repo/test_claims.py`` compare the
files with what is generated here.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from glmref.catalogue.canonical import refresh
from glmref.catalogue.claims import ABSCISSAE, CLAIMS, SIZE, ClaimSpec

DATA = Path(__file__).resolve().parents[1] / "data"
SCHEMA, CONTRACT = DATA / "schema" / "glmref-method-1.schema.json", DATA / "README.md"
SECOND = DATA / "schema" / "glmref-method-2.schema.json"
_VECTOR, _MATRIX = {"$ref": "#/$defs/vector"}, {"$ref": "#/$defs/matrix"}


def _row(*choices: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of `embedded`: objects with a name and the keys of one of the choices."""
    kinds = [
        {
            "type": "object",
            "required": ["name", *keys],
            "additionalProperties": False,
            "properties": {"name": {"$ref": "#/$defs/sentence"}, **keys},
        }
        for keys in choices
    ]
    return {"type": "array", "minItems": 1, "items": {"anyOf": kinds}}


#: What a file has whose digits enclose a method.
ENCLOSED = {
    "unknowns": {"$ref": "#/$defs/named"},
    "enclosure": {"$ref": "#/$defs/enclosure"},
}
#: Keys of the second format by class: those that are needed, and those that may be left out.
NEW: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "glm": ({}, {"embedded": _row({"b": _VECTOR, "v": _VECTOR})}),
    "rk": (
        {},
        {
            "c": _VECTOR,
            "dense": _MATRIX,
            **ENCLOSED,
            "embedded": _row({"b": _VECTOR}, {"error": _VECTOR}),
        },
    ),
    "additive": ({}, {"embedded": _row({"b": _MATRIX})}),
    "nystrom": (
        {"A": _MATRIX, "b": _VECTOR, "b_prime": _VECTOR, "c": _VECTOR},
        {"A_prime": _MATRIX, "embedded": _row({"b": _VECTOR, "b_prime": _VECTOR})},
    ),
    "rosenbrock": (
        {"alpha": _MATRIX, "gamma": _MATRIX, "b": _VECTOR},
        {"embedded": _row({"b": _VECTOR}), **ENCLOSED},
    ),
}


def second_schema(schema: str) -> str:
    """Return the text of the schema of ``glmref-method-2`` from that of the first."""
    found = json.loads(schema.replace("glmref-method-1", "glmref-method-2"))
    kinds, defs = found["properties"]["class"]["enum"], found["$defs"]
    for kind, (needed, optional) in NEW.items():
        if kind not in kinds:
            kinds.append(kind)
            found["allOf"].append(
                {
                    "if": {"properties": {"class": {"const": kind}}},
                    "then": {"$ref": f"#/$defs/{kind}"},
                }
            )
            shared = {k: x for k, x in defs["additive"]["properties"].items() if k != "parts"}
            names = [*(x for x in defs["additive"]["required"] if x != "parts"), *needed]
            defs[kind] = {
                "required": names, "additionalProperties": False, "properties": shared,
            }  # fmt: skip
        defs[kind]["properties"] |= {**needed, **optional}
    return json.dumps(found, indent=2, ensure_ascii=False) + "\n"


def schema_of(claim: ClaimSpec) -> dict[str, Any]:
    """Return the JSON Schema of the value of a claim."""
    order, number = {"$ref": "#/$defs/order"}, {"$ref": "#/$defs/expression"}
    numbers = {"type": "array", "maxItems": 200, "items": number}
    size = {"type": "string", "pattern": f"^{SIZE.pattern}$"}
    sized = {"type": "array", "minItems": 2, "maxItems": 2, "prefixItems": [order, size]}
    return {
        int: order,
        bool: {"type": "boolean"},
        str: number,
        list: _VECTOR if claim is ABSCISSAE else numbers,
        dict: {
            "type": "object",
            "minProperties": 1,
            "additionalProperties": {**sized, "items": False} if claim.sized else order,
        },
    }[claim.type]


def with_claims(schema: str) -> str:
    """Replace the properties of ``claims`` in the text of the schema of method files."""
    rows = (f'        "{key}": {json.dumps(schema_of(spec))}' for key, spec in CLAIMS.items())
    pattern = r'(\n    "claims": \{\n(?:      ".*\n)*?      "properties": \{\n)(?:        .*\n)+'
    return _replaced(pattern, ",\n".join(rows) + "\n", schema)


def with_table(contract: str) -> str:
    """Put the rows of the table of claims in the data contract into the order of the claims."""
    table = r"(<!-- table: claims -->\n\| claim .*\n\|---.*\n)((?:\|.*\n)*)(?=<!-- end)"
    found = "".join(x[1] for x in re.findall(table, contract))
    rows, order = re.findall(r"(\| `([\w-]+)` .*\n)", found), list(CLAIMS)
    if found and sorted(key for _, key in rows) != sorted(order):
        differ = {key for _, key in rows} ^ CLAIMS.keys()
        raise ValueError(f"a claim has one row in its table; see {sorted(differ) or 'those twice'}")
    rows.sort(key=lambda row: order.index(row[1]))
    return _replaced(table, "".join(line for line, _ in rows), contract)


def _replaced(pattern: str, new: str, text: str) -> str:
    """Replace what follows the first group of the one match of a pattern."""
    text, count = re.subn(pattern, lambda match: match[1] + new, text)
    if count != 1:
        raise ValueError(f"the place of the claims was found {count} times, and must be there once")
    return text


def main() -> None:
    """Write both files where their text is another one, and the lists of hashes."""
    for path, generated in ((SCHEMA, with_claims), (CONTRACT, with_table)):
        text = path.read_text(encoding="utf-8")
        if generated(text) != text:
            path.write_text(generated(text), encoding="utf-8")
            sys.stdout.write(f"wrote {path}\n")
    text = second_schema(SCHEMA.read_text(encoding="utf-8"))
    if not SECOND.is_file() or SECOND.read_text(encoding="utf-8") != text:
        SECOND.write_text(text, encoding="utf-8")
        sys.stdout.write(f"wrote {SECOND}\n")
    sys.stdout.writelines(f"wrote {path}\n" for path in refresh(DATA))


if __name__ == "__main__":
    main()
