"""Write what follows from the table of claims: its JSON Schema and its rows in ``data/README.md``.

``python -m tools.method_schema`` rewrites both and brings the two lists of hashes up to date. Tests
in ``tests/repo/test_claims.py`` compare the files with what is generated here.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

from glmref.catalogue.canonical import refresh
from glmref.catalogue.claims import CLAIMS

DATA = Path(__file__).resolve().parents[1] / "data"
SCHEMA, CONTRACT = DATA / "schema" / "glmref-method-1.schema.json", DATA / "README.md"


def with_claims(schema: str) -> str:
    """Replace the properties of ``claims`` in the text of the schema of method files."""
    rows = (f'        "{key}": {json.dumps(spec.schema)}' for key, spec in CLAIMS.items())
    pattern = r'(\n    "claims": \{\n(?:      ".*\n)*?      "properties": \{\n)(?:        .*\n)+'
    return _replaced(pattern, ",\n".join(rows) + "\n", schema)


def with_table(contract: str) -> str:
    """Replace the table of claims in the text of the data contract."""
    rows = (f"| `{key}` | {spec.sentence} |\n" for key, spec in CLAIMS.items())
    table = "| claim | true when |\n|---|---|\n" + "".join(rows)
    return _replaced(r"(<!-- table: claims -->\n)(?:\|.*\n)*(?=<!-- end)", table, contract)


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
    sys.stdout.writelines(f"wrote {path}\n" for path in refresh(DATA))


if __name__ == "__main__":
    main()
