"""The built-in models, one module each.

`MODELS` lists them. A new model is a module of this package, named like its class in lower case, and a line here. Its
module is imported when a world first uses the model, so that unused models cost nothing.
"""

__all__ = ["MODELS"]

# Name in worldfiles -> "module:class", the form of an entry point.
MODELS: dict[str, str] = {
    name: f"{__name__}.{name.lower()}:{name}"
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
