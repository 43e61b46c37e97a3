"""The judge: decides whether a certificate of format glmref-certificate-1 proves its statement.

The judge imports the standard library and itself, nothing else of glmref. The sections that its
modules name are those of docs/certificates.md. ``python -m glmref.judge FILE...`` runs it,
``python -m glmref.judge.join`` writes it as one file for machines without glmref.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from .statements import judged, verdict

__all__ = ["judged", "verdict"]


def __getattr__(name: str) -> Callable[..., object]:
    """Load the rules when they are asked for: tables of the judge are read without them."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from . import statements  # and with it all rules, some 0.15 s

    return getattr(statements, name)
