"""From a YAML model file to a tree of components, with the line number in every error; and back."""

from fowtlib.modelfile.files import data_path, shipped_models
from fowtlib.modelfile.loading import load, models
from fowtlib.modelfile.writing import dump

__all__ = ["data_path", "dump", "load", "models", "shipped_models"]
