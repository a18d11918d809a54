"""Finite elements of parts: CalculiX and Stiffkit side by side in one run."""
