"""From a flat system to numbers: initial values, time simulation, linear models, results."""
