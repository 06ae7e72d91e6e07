"""Settings of the tests: the same examples every time, and no time limits."""

from hypothesis import HealthCheck, settings

settings.register_profile(
    "same", derandomize=True, deadline=None, database=None, max_examples=25, suppress_health_check=list(HealthCheck)
)
settings.load_profile("same")
