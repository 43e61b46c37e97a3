"""Order 8, parasitism-free, symmetric, G-symplectic: three to five stages, one to five implicit.

Stage order 2 or 3 makes nearly all conditions follow from others (:mod:`glmref.judge.classes`):
of the 200 trees up to order 8 there remain [oooo] of order 5 and three trees of order 7 at stage
order 2, or one at stage order 3. With the stage-order equations s = 5, r = 4 leaves two free
parameters, or none when only the middle stage is implicit; s = 3 needs two complex pairs (r = 6),
and with these s = 4 at stage order 3 has one free parameter when stages 1 and 4 are explicit.
``name`` picks one method, all are derived without; ``start`` says whether start and finish are
derived too (45 or 95 stages, seven of them coupled, and an exact inverse for the first value).
"""

from __future__ import annotations

from collections.abc import Mapping

from .solved import deriver, rough_solutions

OPTIONS: Mapping[str, str] = {"name": "all", "start": "yes"}
ROUGH = rough_solutions("order8")

derive = deriver("order8", ROUGH)
