"""Choose where tasks are carried out.

The choice is a text::

    here                      in this process, one after another
    local, local:4            as many processes as there are cores, or four
    dask, dask:4              a Dask cluster on this machine, with a worker a core, or four
    dask:tcp://HOST:8786      the Dask cluster with this scheduler
    dask:scheduler.json       the same, by the file that its scheduler wrote
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from ..errors import UsageError
from .cluster import cluster
from .executors import Executor, Here, Local

#: The environment variable that chooses where nothing else does.
ENVIRONMENT = "GLMREF_EXECUTOR"


@contextmanager
def executor(text: str | None = None) -> Iterator[Executor]:
    """Open the executor that a text chooses, and close it in the end.

    Parameters
    ----------
    text : str or None
        See the module; by default what :data:`ENVIRONMENT` says, else ``"here"``.

    Raises
    ------
    UsageError
        For a text that chooses nothing, a cluster that does not answer, or Dask where it is not
        installed.
    """
    asked = text or os.environ.get(ENVIRONMENT) or "here"
    kind, _, rest = asked.partition(":")
    if kind == "dask":
        with cluster(rest) as found:
            yield found
    elif kind == "local" and (not rest or (rest.isdecimal() and len(rest) < 5 and int(rest))):
        yield Local(int(rest) if rest else None)
    elif asked == "here":
        yield Here()
    else:
        raise UsageError(
            f"there is no executor {asked[:100]!r}; write here, local, local:N, dask, dask:N, "
            f"dask:tcp://HOST:PORT or dask:FILE with the file of a scheduler"
        )
