"""Store an audit: lines of ``glmref audit --all`` as one file of ``data/audits``.

``glmref audit CHECKOUT/src/ts/impls --from petsc --all | python -m tools.audit_record petsc
PETSC-COMMIT DATE PAGE LICENCE src/ts/impls`` writes ``data/audits/petsc.json``. The licence is that
of the checkout (SPDX), the folder what was read of it, "." for all: paths are relative to the
checkout. Only facts about each table are kept, no source. A last argument says how many files were
read of a code in which no table is recognised.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path, PurePosixPath

from glmref import __version__
from glmref.audit.sources import FORMAT
from glmref.audit.table_verdicts import summary
from glmref.catalogue.canonical import canonical

AUDITS = Path(__file__).resolve().parents[1] / "data" / "audits"


def main(arguments: list[str]) -> None:
    """Write the record of one code from the lines on the standard input."""
    if not 6 <= len(arguments) <= 7 or "--help" in arguments:
        raise SystemExit(__doc__)
    code, commit, date, page, licence, folder, *files = arguments
    records = []
    for line in sys.stdin:
        row = json.loads(line)
        row = {k: v for k, v in row.items() if k != "format" and v not in (None, [], "")}
        row.pop("nearest", None) if not row.get("nearest", {}).get("entries") else None
        if isinstance(row.get("residual"), float):
            row["residual"] = f"{row['residual']:.1e}"
        row["path"] = str(PurePosixPath(folder) / row["path"])
        records.append(row)
    document = {
        "format": FORMAT,
        "name": code,
        "source": {"page": page, "commit": commit, "date": date, "licence": licence},
        "reader": f"glmref {__version__}",
        **({"files": int(files[0])} if files else {}),
        "counts": summary(records),
        "tables": records,
    }
    AUDITS.mkdir(exist_ok=True)
    (AUDITS / f"{code}.json").write_text(canonical(document), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
