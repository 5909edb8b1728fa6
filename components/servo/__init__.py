"""Controllers of pitch and generator torque."""
