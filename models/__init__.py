"""The built-in models, one module each; a module is imported when a world asks for its model."""

# Worldfile name -> "module:class".
MODELS = {
    name: f"libgz.models.{name.lower()}:{name}"
    for name in (
        "Atrv",
        "AvatarHeli",
        "B21R",
        "Bandit",
        "Blimp",
        "CanonVCC4",
        "CarChassis",
        "ClodBuster",
        "Factory",
        "GarminGPS",
        "GroundPlane",
        "LightSource",
        "MapExtruder",
        "MonoCam",
        "ObserverCam",
        "PeopleBot",
        "Pioneer2AT",
        "Pioneer2DX",
        "Pioneer2Gripper",
        "Pioneer2Sonars",
        "Road",
        "Roomba",
        "SegwayRMP",
        "Shrimp",
        "SickLMS200",
        "SimpleSolid",
        "SkyDome",
        "SonyVID30",
        "StereoHead",
        "Terrain",
        "TruthWidget",
        "WheelChair",
        "WiFi",
    )
}
