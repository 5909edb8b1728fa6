"""Design: what is varied, what is asked for, what it costs."""
