"""Images of a world: contexts, scenes, cameras, meshes and textures.

- Skins are bent when somebody looks. An actor moves its bones; `Scene` calls `SkinGeom.bend`, which counts in `bends`,
  not in `Appearance.version`: the published scene has the skin at rest with its bones, and pages bend it themselves.
- All GL of a context runs in its one thread. `Camera.Update` calls `Scene.render`, which takes a `Shot` of the world,
  plain data of one moment; then `RenderThread` has `Renderer` render it in the context's thread, so that physics can
  continue meanwhile. The geometry of a geom is compiled once, and again when `appearance.version` grows.
- Images are rendered upside down (the projection's y negated, front faces clockwise), and so read top row first.
"""
