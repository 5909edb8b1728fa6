"""fowtlib: acausal models of floating wind turbines, from components to results."""
