"""From a YAML model file to a tree of components, with the line number in every error."""
