"""The built-in models, one module each; a module is imported when a world asks for its model."""

# Worldfile name -> "module:class".
MODELS = {
    name: f"libgz.models.{name.lower()}:{name}"
    for name in (
        "CanonVCC4",
        "Factory",
        "GroundPlane",
        "LightSource",
        "MonoCam",
        "ObserverCam",
        "Pioneer2AT",
        "Pioneer2DX",
        "SickLMS200",
        "SimpleSolid",
        "SkyDome",
        "SonyVID30",
        "StereoHead",
    )
}
