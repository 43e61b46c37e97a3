"""How many examples hypothesis tries: all of them in CI, a fifth in the quick run."""

from __future__ import annotations

from hypothesis import settings


def examples(whole: int) -> settings:
    """Return settings with so many examples, or their share where `conftest.py` asks for fewer."""
    return settings(max_examples=max(1, whole * settings().max_examples // 100), deadline=None)
