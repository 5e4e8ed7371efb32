"""Full-field strain between two textured 3D shapes of one object."""

__version__ = "0.1.0"
