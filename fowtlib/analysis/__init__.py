"""Analyses of results and linear models: free decay, response amplitude operators, spectra."""
