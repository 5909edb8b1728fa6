"""Mooring lines."""
