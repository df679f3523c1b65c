"""WindPlugin: lets the wind of a world vary, and act on links."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.common import gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Entity, Wind, World
    from libgz.classic.sensors.noise import Noise
    from libgz.sdf.element import Element


class WindPlugin(WorldPlugin):
    """Applies F = factor m (wind - v) to each link in the wind, with v its velocity.

    The wind rises to that of the world: the means of its horizontal speed and direction and of its vertical speed come
    nearer by step / time_for_rise in each step (in Gazebo so often as there are links in the wind). To them a sine and
    noise are added. Only links that `enable_wind` puts into the wind are moved, and as in Gazebo none without a factor.

    Elements:
        force_approximation_scaling_factor: factor [1/s] (0); with 0 no force is applied.
        horizontal magnitude: time_for_rise [s] (1), sin amplitude_percent (0) and period [s] (1), noise.
        horizontal direction: time_for_rise [s] (1), sin amplitude [degrees] (0) and period [s] (1), noise [degrees].
        vertical: time_for_rise [s] (1), noise [m/s].
    """

    STATE = ("speed", "direction", "vertical", "advanced", "noises")

    def Load(self, world: World, sdf: Element) -> None:
        """Read the parameters, and make the wind vary.

        Raises:
            ParameterError: a time or period is not positive, or the factor is negative.
        """
        self.world = world
        self.speed = self.direction = self.vertical = 0.0  # means [m/s], [degrees], [m/s]
        self.advanced = -1  # the iteration of the means
        self.noises: dict[str, Noise] = {}
        self.factor = sdf.Get(float, "force_approximation_scaling_factor", 0.0)[0]
        if not 0.0 <= self.factor < math.inf:
            raise ParameterError(
                f"{sdf.where}: <force_approximation_scaling_factor> is {self.factor:g}; it must be 0 or more"
            )
        if self.factor == 0.0:
            gzwarn(f"{sdf.where}: the wind applies no force without a <force_approximation_scaling_factor>")
        horizontal, upward = _part(sdf, "horizontal"), _part(sdf, "vertical")
        speed, direction = _part(horizontal, "magnitude"), _part(horizontal, "direction")
        self.speed_rise, self.direction_rise = _time(speed, "time_for_rise"), _time(direction, "time_for_rise")
        self.vertical_rise = _time(upward, "time_for_rise")
        sine = _part(speed, "sin")
        self.speed_sine, self.speed_period = _number(sine, "amplitude_percent"), _time(sine, "period")
        sine = _part(direction, "sin")
        self.direction_sine, self.direction_period = _number(sine, "amplitude"), _time(sine, "period")
        for channel, (name, part) in enumerate((("speed", speed), ("direction", direction), ("vertical", upward))):
            if part is not None and part.HasElement("noise"):
                self.noises[name] = self._noise(part.GetElement("noise"), channel)
        world.Wind().SetLinearVelFunc(self.LinearVel)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _noise(self, element: Element, channel: int) -> Noise:
        from libgz.classic.sensors.noise import new_noise

        return new_noise(element, self.world.core.seed, f"{self.world.Name()}::{self.GetHandle()}", channel)

    def Reset(self) -> None:
        """Let the wind rise again."""
        self.speed = self.direction = self.vertical = 0.0
        self.advanced = -1
        for noise in self.noises.values():
            noise.restart()

    def LinearVel(self, wind: Wind, entity: Entity) -> Vector3d:
        """The wind at an entity [m/s]."""
        if self.advanced != self.world.Iterations():
            self.advanced = self.world.Iterations()
            self._advance(wind.LinearVel())
        now = float(self.world.SimTime())
        speed = self.speed * (1.0 + self.speed_sine * math.sin(2.0 * math.pi * now / self.speed_period))
        direction = self.direction + self.direction_sine * math.sin(2.0 * math.pi * now / self.direction_period)
        speed, direction = self._with_noise("speed", speed), self._with_noise("direction", direction)
        turn = math.radians(direction)
        return Vector3d(speed * math.cos(turn), speed * math.sin(turn), self._with_noise("vertical", self.vertical))

    def _advance(self, whole: Vector3d) -> None:
        """Bring the means nearer to the wind of the world."""
        step = self.world.Physics().GetMaxStepSize()
        self.speed += step / self.speed_rise * (math.hypot(whole.X(), whole.Y()) - self.speed)
        target = math.degrees(math.atan2(whole.Y(), whole.X()))
        self.direction += step / self.direction_rise * (target - self.direction)
        self.vertical += step / self.vertical_rise * (whole.Z() - self.vertical)

    def _with_noise(self, name: str, value: float) -> float:
        noise = self.noises.get(name)
        return noise.Apply(value) if noise is not None else value

    def OnUpdate(self) -> None:
        """Apply the force of the wind to each link in it."""
        if self.factor == 0.0:
            return
        for model in self.world.all_models():
            for link in model.GetLinks():
                if link.WindMode():
                    mass = link.GetInertial().Mass()
                    relative = link.RelativeWindLinearVel() - link.RelativeLinearVel()
                    link.AddRelativeForce(relative * (self.factor * mass))


def _part(element: Element | None, name: str) -> Element | None:
    """A part of the plugin's element, if it is there."""
    return element.GetElement(name) if element is not None and element.HasElement(name) else None


def _number(element: Element | None, name: str, default: float = 0.0) -> float:
    return default if element is None else element.Get(float, name, default)[0]


def _time(element: Element | None, name: str) -> float:
    """A time [s] of a part.

    Raises:
        ParameterError: it is not positive.
    """
    value = _number(element, name, 1.0)
    if element is not None and not 0.0 < value < math.inf:
        raise ParameterError(f"{element.where}: <{name}> is {value:g}; it must be positive")
    return value


GZ_REGISTER_WORLD_PLUGIN(WindPlugin)
