"""Shipped model files and their data; installed as `fowtlib.models`."""
