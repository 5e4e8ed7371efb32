"""Doors to the disk: readers and writers."""
