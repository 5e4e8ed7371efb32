"""Morph laws: where a simple rule sends the points of the reference picture."""
