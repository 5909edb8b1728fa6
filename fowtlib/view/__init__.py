"""Pictures of models and results: figures, and animations in 3-D."""

import sys
from types import ModuleType
from typing import Any

from fowtlib.solving.results.drawing import save_figure
from fowtlib.solving.results.plots import plot_decay, plot_modes, plot_rao, plot_result, plot_spectra
from fowtlib.view.rotor import plot_rotor
from fowtlib.view.scene import Animation, view

__all__ = [
    "Animation",
    "plot_decay",
    "plot_modes",
    "plot_rao",
    "plot_result",
    "plot_rotor",
    "plot_spectra",
    "save_figure",
    "view",
]


class _Room(ModuleType):
    """Python names a package in its parent when it is imported; this one goes on being the function `fowtlib.view`."""

    def __call__(self, *arguments: Any, **options: Any) -> Animation:
        return view(*arguments, **options)


sys.modules[__name__].__class__ = _Room
