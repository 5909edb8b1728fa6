"""Errors of the hydrodynamic data: what is wrong, where, and what to do."""

from fowtlib.language.errors import ModelError


class HydrodynamicDataError(ModelError):
    """Hydrodynamic data are unreadable, contradict themselves, or are asked for outside of their range."""


class MissingExtraError(ModelError):
    """An optional package is needed and is not installed."""
