"""What can be set in a world while it runs, for tests that change it around a state."""

from libgz.base.geometry import GzColor
from libgz.classic.common import Time
from libgz.classic.math import Angle, Rand


def _sensors(world):
    return world.facade.server.sensors.sensors.values()


# Clocks, seeds and settings of worlds of both eras.
OF_WORLDS = {
    "seed": lambda world: world.reseed(77),
    "generators": lambda world: world.random.spawn(3),
    "sim time": lambda world: world.set_sim_time(50.0),
    "pause": lambda world: setattr(world, "paused", True),
    "start of pause": lambda world: setattr(world, "starts_paused", True),
    "day time": lambda world: setattr(world.clock, "day_time", 300.0),
    "UTC": lambda world: setattr(world, "utcOffset", 5.0),
    "speed": lambda world: setattr(world, "simSpeed", 3.0),
    "name": lambda world: setattr(world, "name", "other"),
    "sky": lambda world: setattr(world, "skyColor", GzColor(1.0, 0.0, 0.0)),
    "physics": lambda world: setattr(world, "physics_enabled", not world.physics_enabled),
    "step time": lambda world: setattr(world.engine, "step_time", 0.0037),
    "gravity": lambda world: setattr(world.engine, "gravity", (0.0, 1.0, -3.0)),
    "solver": lambda world: setattr(world.engine, "solver", "quick"),
    "iterations": lambda world: world.engine.set_quick_step(7, 1.1),
    "constraints": lambda world: world.engine.set_constraints(0.3, 1e-4, 5.0),
    "contacts": lambda world: setattr(world.engine, "max_contacts", 3),
    "contact records": lambda world: setattr(world.engine, "record_contacts", True),
    "surface layer": lambda world: setattr(world.engine, "surface_layer", 0.01),
    "motion": lambda world: setattr(world.engine, "record_motion", True),
    "gyroscopic torque": lambda world: setattr(world.engine, "explicit_gyroscopic", True),
    "exact rest": lambda world: setattr(world.engine, "exact_rest", not world.engine.exact_rest),
}
# Those of SDF worlds, with sensors, by the API of Gazebo classic.
OF_CLASSIC = {
    "update rates": lambda world: [sensor.SetUpdateRate(17.0) for sensor in _sensors(world)],
    "sensors": lambda world: [sensor.SetActive(False) for sensor in _sensors(world)],
    "max step size": lambda world: world.facade.Physics().SetMaxStepSize(0.003),
    "real-time update rate": lambda world: world.facade.Physics().SetRealTimeUpdateRate(10.0),
    "solver_type": lambda world: world.facade.Physics().SetParam("solver_type", "world"),
    "iters": lambda world: world.facade.Physics().SetParam("iters", 11),
    "sor": lambda world: world.facade.Physics().SetParam("sor", 1.2),
    "cfm": lambda world: world.facade.Physics().SetParam("cfm", 1e-3),
    "max_contacts": lambda world: world.facade.Physics().SetParam("max_contacts", 3),
    "SetGravity": lambda world: world.facade.SetGravity((0.0, 0.0, -2.0)),
    "SetPhysicsEnabled": lambda world: world.facade.SetPhysicsEnabled(False),
    "Rand": lambda _: Rand.Seed(99),
    "SetSeed": lambda world: world.facade.Physics().SetSeed(5),
    "SetPaused": lambda world: world.facade.SetPaused(True),
    "wind": lambda world: world.facade.SetWindEnabled(True),
    "velocity of wind": lambda world: world.facade.Wind().SetLinearVel((1.0, 2.0, 3.0)),
    "magnetic field": lambda world: world.facade.SetMagneticField((1.0, 2.0, 3.0)),
    "temperature": lambda world: world.facade.Atmosphere().SetTemperature(300.0),
    "atmosphere": lambda world: world.facade.SetAtmosphereEnabled(False),
    "latitude": lambda world: world.facade.SphericalCoords().SetLatitudeReference(Angle(0.5)),
    "SetSimTime": lambda world: world.facade.SetSimTime(Time(100.0)),
    "ResetTime": lambda world: world.facade.ResetTime(),
    "ResetEntities": lambda world: world.facade.ResetEntities(),
    "Step": lambda world: world.facade.Step(3),
}
KEPT_BY_RESET = ("pause", "SetPaused")  # of SDF worlds, as Gazebo does
