"""Images of a world: contexts, scenes, cameras, meshes and textures."""
