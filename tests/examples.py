"""How many examples hypothesis tries: a tenth of them in runs of quick tests only, else all."""

from __future__ import annotations

from hypothesis import settings


def examples(whole: int) -> settings:
    """Return settings with so many examples, or their share where `conftest.py` asks for fewer."""
    return settings(max_examples=max(1, whole * settings().max_examples // 100), deadline=None)
