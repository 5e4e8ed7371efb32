"""Nouns: what the data are."""
