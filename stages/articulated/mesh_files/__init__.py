"""What each kind of mesh file can say, read or told: `read_<kind>` makes plain triangles of it for trimesh."""
