"""Floaters: hulls described by their members."""
