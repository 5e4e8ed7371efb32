"""Doors to the screen: pictures, plots and the report."""
