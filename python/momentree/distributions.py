"""Distributions of the parameters of sweeps."""

from __future__ import annotations

from dataclasses import dataclass

from momentree._arguments import number

__all__ = ["Distribution", "exponential", "lognormal", "normal", "triangular", "uniform", "weibull"]


@dataclass(frozen=True)
class Distribution:
    """What a parameter of :func:`sweep` is drawn from; :func:`uniform` and others make one."""

    kind: str
    """``"uniform"``, ``"normal"`` …"""
    numbers: tuple[float, ...]
    """Its parameters."""


def _of(kind: str, *numbers: float) -> Distribution:
    return Distribution(kind, tuple(number(each, kind) for each in numbers))


def uniform(low: float, high: float) -> Distribution:
    """A uniform distribution.

    Args:
        low: Least value.
        high: Greatest value.
    """
    return _of("uniform", low, high)


def normal(mean: float, deviation: float, within: tuple[float, float] | None = None) -> Distribution:
    """A normal distribution.

    Args:
        mean: Its mean, before it is truncated.
        deviation: Its standard deviation, likewise.
        within: Least and greatest value of a truncated distribution.
    """
    return _of("normal", mean, deviation, *(within or ()))


def lognormal(mean: float, deviation: float) -> Distribution:
    """A lognormal distribution.

    Args:
        mean: Mean of the natural logarithm.
        deviation: Standard deviation of the natural logarithm.
    """
    return _of("lognormal", mean, deviation)


def exponential(mean: float) -> Distribution:
    """An exponential distribution.

    Args:
        mean: Its mean.
    """
    return _of("exponential", mean)


def weibull(scale: float, shape: float) -> Distribution:
    """A Weibull distribution, as for strengths.

    Args:
        scale: The value below which 63.2 % of the values lie.
        shape: Its shape parameter; the greater, the less the values scatter.
    """
    return _of("weibull", scale, shape)


def triangular(low: float, mode: float, high: float) -> Distribution:
    """A triangular distribution.

    Args:
        low: Least value.
        mode: Most likely value.
        high: Greatest value.
    """
    return _of("triangular", low, mode, high)
