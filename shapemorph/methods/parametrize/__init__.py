"""Flattenings: each takes vertices (V, 3) and faces (F, 3) and returns a plane (V, 2)."""
