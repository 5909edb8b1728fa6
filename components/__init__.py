"""The library of parts; installed as `fowtlib.components`."""
