"""Rotors in the wind."""
