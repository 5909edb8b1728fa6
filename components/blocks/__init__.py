"""Signal blocks: gains, integrators, filters, actuators, limiters, tables."""
