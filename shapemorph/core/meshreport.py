"""What was found and mended when a mesh was read."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MeshReport:
    """Counts for the summary; nothing here is needed to measure.

    Attributes
    ----------
    name, file_format, method : str
        `method` says how the triangles came about where the file had none.
    vertices, faces : int
        After cleaning.
    welded_vertices : int
        Vertices merged with another at the same position.
    unreferenced_vertices, degenerate_faces, duplicate_faces, non_manifold_faces : int
        Removed.
    polygons_split : int
        Quads and larger polygons cut into triangles.
    components : int
        Connected pieces in the file; the large ones are kept.
    dropped_faces : int
        Faces of the pieces that were not kept.
    boundary_loops : int
        0 is a closed surface.
    euler_characteristic : int
    texture_sizes : tuple of (int, int)
        Height and width of every texture, px.
    grey_source : str
        "texture", "vertex colours" or "point cloud".
    unit : str
    notes : tuple of str
        One sentence each for what a user should know.
    content : tuple of float
        Gradient content of luma, red, green and blue of its textures, grey levels^2 / px^2;
        empty where they are grey.
    channel : str
        What of its colours became grey.
    """

    name: str
    file_format: str
    method: str
    vertices: int
    faces: int
    welded_vertices: int
    unreferenced_vertices: int
    degenerate_faces: int
    duplicate_faces: int
    non_manifold_faces: int
    polygons_split: int
    components: int
    dropped_faces: int
    boundary_loops: int
    euler_characteristic: int
    texture_sizes: tuple[tuple[int, int], ...]
    grey_source: str
    unit: str
    notes: tuple[str, ...]
    content: tuple[float, ...] = ()
    channel: str = "luma"
