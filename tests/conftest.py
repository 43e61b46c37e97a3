"""Settings that every test shares: the profile of hypothesis, and what is quick of a family."""

from __future__ import annotations

import os
from collections import defaultdict
from zlib import crc32

import pytest
from hypothesis import HealthCheck, settings

from glmref.verification import kept

#: Examples of a property in the quick run, of a hundred in the whole one; see `examples.py`.
QUICK = 30


def pytest_configure(config: pytest.Config) -> None:
    """Choose the profile of hypothesis, and keep no verdicts.

    Tests change the program while it runs: what it finds then must not be kept for the next run.

    Machines are shared and slow at times: no example is failed for its duration. In CI the examples
    are the same in every run, so that a failure there can be repeated; elsewhere they are random.
    """
    kept.private_folder = lambda name: None
    whole = "not slow" not in config.option.markexpr
    settings.register_profile(
        "glmref",
        deadline=None,
        suppress_health_check=[HealthCheck.too_slow],
        print_blob=True,
        derandomize=bool(os.environ.get("CI")),
        max_examples=100 if whole else QUICK,
    )
    settings.load_profile("glmref")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as slow what goes beyond the sample of a test that is marked ``sampled(n)``.

    The sample is drawn by a hash of the names of the cases: it is the same in every run, and a case
    that is added moves no other one but the last. Cases with a name that contains one of ``besides``
    take long and come last.
    """
    families: dict[str, list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sampled") and not item.get_closest_marker("slow"):
            families[item.nodeid.partition("[")[0]].append(item)
    for family in families.values():
        mark = family[0].get_closest_marker("sampled")
        assert mark is not None
        long = mark.kwargs.get("besides", ())
        family.sort(key=lambda item: (any(x in item.name for x in long), crc32(item.name.encode())))
        for item in family[mark.args[0] :]:
            item.add_marker(pytest.mark.slow)
