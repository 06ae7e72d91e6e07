"""Dynamics of mechanisms whose topology changes while they move."""

from momentree._core import __version__

__all__ = ["__version__"]
