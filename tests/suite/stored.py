"""What data/measurements/verification.json says, and whether it is what ``glmref verify`` says."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from glmref.catalogue.lookup import data_root

FILE = data_root() / "measurements" / "verification.json"
RENEW = (
    "glmref verify --format json | python -m json.tool --compact --no-ensure-ascii "
    "> data/measurements/verification.json"
)
STORED: Mapping[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
Findings = Sequence[Mapping[str, Any]]


def stored(name: str) -> Findings:
    """Stored findings of a file."""
    return [one for one in STORED["findings"] if one["method"] == name]


def same(one: Findings, other: Findings) -> bool:
    """Whether findings are the same word for word.

    The residual of an enclosure is the width of a ball, which depends on the order of operations:
    of it only whether it is zero is compared.
    """
    told = [[{**x, "residual": x["residual"] == 0} for x in side] for side in (one, other)]
    return told[0] == told[1]
