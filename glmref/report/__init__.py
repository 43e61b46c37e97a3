"""The report: stored records as pages that anybody can read, on any screen, without a network.

Nothing is measured here and nothing is proved: numbers come from records (`glmref run`), findings
(`glmref verify --format json`), portraits (`glmref show NAME --plot`) and the data, and stand on
the pages as they are stored, to six digits.

Public names::

    read(paths) -> Results                   everything that is stored below some paths
    build(results, folder, single=False)     write the pages; returns their paths
"""

from __future__ import annotations

from .build import build
from .store import Results, read

__all__ = ["Results", "build", "read"]
