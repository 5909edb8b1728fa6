"""The command line, `fowt`."""
