"""Hypothesis profiles: `dev` by default, the same examples every time; HYPOTHESIS_PROFILE=thorough for a long search
with new ones."""

import os

from hypothesis import HealthCheck, settings

settings.register_profile(
    "dev", deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", parent=settings.get_profile("dev"), max_examples=2000, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "dev"))
