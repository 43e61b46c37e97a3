"""Order 6 with a free principal start: one to five implicit stages, five, four or three stages.

Dropping stage order 2 or the identity start (Khan 2018, section 3.4, has both) opens these
families. Free parameters are fixed rationally; ``name`` picks one method, all are derived
without.
"""

from __future__ import annotations

from collections.abc import Mapping

from .solved import deriver, rough_solutions

OPTIONS: Mapping[str, str] = {"name": "all", "start": "yes"}
ROUGH = rough_solutions("conjugation6")

derive = deriver("conjugation6", ROUGH)
