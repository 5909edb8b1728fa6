"""From a YAML model file to a tree of components, with the line number in every error; and back."""

from fowtlib.modelfile.files import data_path, shipped_models
from fowtlib.modelfile.loading import load, models

__all__ = ["data_path", "load", "models", "shipped_models"]
