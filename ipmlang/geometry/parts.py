"""What `comp` takes a solid apart into: its faces, its edges or its vertices.

The way in; how each kind of part comes to its scope and its words stands in `faces` and `edges`.
"""

from ipmlang.geometry.edges import edges, edges_of, vertices
from ipmlang.geometry.faces import LOOKS, Scopes, face_scopes, face_words, faces, faces_of

__all__ = [
    "LOOKS",
    "Scopes",
    "edges",
    "edges_of",
    "face_scopes",
    "face_words",
    "faces",
    "faces_of",
    "vertices",
]
