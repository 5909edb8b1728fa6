"""Pictures of models and results."""

from fowtlib.view.plots import plot_decay, plot_modes, plot_rao, plot_result, plot_spectra, save_figure
from fowtlib.view.rotor import plot_rotor

__all__ = ["plot_decay", "plot_modes", "plot_rao", "plot_result", "plot_rotor", "plot_spectra", "save_figure"]
