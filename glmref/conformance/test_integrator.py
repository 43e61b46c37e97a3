"""The suite as pytest sees it: one test for each check of the adapter."""

from __future__ import annotations

from typing import Any


def test_integrator(glmref_check: Any) -> None:
    """The integrator does what the check asks."""
    glmref_check()
