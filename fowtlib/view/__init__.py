"""Pictures of models and results: figures, and animations in 3-D."""

from fowtlib.view.plots import plot_decay, plot_modes, plot_rao, plot_result, plot_spectra, save_figure
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
