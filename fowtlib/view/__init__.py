"""Pictures of models and results."""

from fowtlib.view.plots import plot_decay, plot_modes, plot_rao, plot_result, plot_spectra, save_figure

__all__ = ["plot_decay", "plot_modes", "plot_rao", "plot_result", "plot_spectra", "save_figure"]
