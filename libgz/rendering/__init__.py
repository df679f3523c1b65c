"""Images of a world: contexts, scenes, cameras, meshes and textures.

- Skins are bent when somebody looks. An actor moves its bones; `Scene` calls `SkinGeom.bend`, which counts in `bends`,
  not in `Appearance.version`: the published scene has the skin at rest with its bones, and pages bend it themselves.
- All GL of a context runs in its one thread. `Camera.Start` calls `Scene.start`, which takes a `Shot` of the world and
  has `Renderer` record the calls for it on a `Tape`. Native code plays them in the context's thread, without the
  interpreter lock, while physics and other worlds continue. The geometry of a geom is compiled once, and again when
  `appearance.version` grows.
- The image that a legacy camera takes in a step is served at the end of that step, before clients are woken.
- Images are rendered upside down (the projection's y negated, front faces clockwise), and so read top row first.
"""
