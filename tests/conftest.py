"""Settings that every test shares: the profile of hypothesis."""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

# Machines are shared and slow at times: no example is failed for its duration. In CI the examples
# are the same in every run, so that a failure there can be repeated; elsewhere they are random.
settings.register_profile(
    "glmref", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.register_profile("ci", settings.get_profile("glmref"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "glmref")
