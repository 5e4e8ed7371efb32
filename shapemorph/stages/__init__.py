"""Verbs: one file is one step of a measurement."""
