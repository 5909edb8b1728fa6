"""Loads of the water on a floating body."""
