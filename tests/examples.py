"""How many examples hypothesis tries: a tenth of them in runs of quick tests only, else all."""

from collections.abc import Callable, Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st


def examples(whole: int) -> settings:
    """Return settings with so many examples, or their share where `conftest.py` asks for fewer."""
    return settings(max_examples=max(1, whole * settings().max_examples // 100), deadline=None)


def law(names: Sequence[str], tries: settings, quick: int, **sampled: Any) -> Callable[[Any], Any]:
    """Decorate a law ``test(name, data)`` of some methods, of which so many are in quick runs."""

    def decorate(test: Any) -> Any:
        drawn = given(data=st.data())(tries(test))
        return pytest.mark.sampled(quick, **sampled)(pytest.mark.parametrize("name", names)(drawn))

    return decorate
