"""What is in the shipped files, each read once: from here the cases of a family are chosen.

Tests are collected by every worker before the first one runs; to read the whole catalogue for each
family would take longer than the quick tests of several subpackages.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from glmref.catalogue.files import document


@cache
def shipped(name: str) -> Mapping[str, Any]:
    """Return the members of a shipped file, to be read and not to be changed."""
    return MappingProxyType(document(name))
