"""The judge: decides whether a certificate of format glmref-certificate-1 proves its statement.

The judge imports the standard library and itself, nothing else of glmref. The sections that its
modules name are those of docs/certificates.md. ``python -m glmref.judge FILE...`` runs it,
``python -m glmref.judge.join`` writes it as one file for machines without glmref.
"""

from .statements import judged, verdict

__all__ = ["judged", "verdict"]
