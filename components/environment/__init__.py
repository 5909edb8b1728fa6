"""What surrounds a turbine: the world, the sea, the wind."""
