"""What an author of components writes with: declarations, connectors, equations, units."""
