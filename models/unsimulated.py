"""Models of Gazebo 0.4 that are known by name only: their attributes stand in no manual that is left."""

from __future__ import annotations

from libgz.physics.body import Body
from libgz.simulation.model import Model
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


class _Unsimulated(Model):
    """A place without a shape, so that a world with one loads, and what is nested in it stands where it should."""

    instead = ""

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:
        self.AddBody(Body(self.world, dummy=True), True)
        for child in node.children:
            if child.GetNSPrefix() != "model":
                for inside in child.walk():
                    inside.used = True
        node.warn(f"{self.GetName()} is not simulated, for no more than its name is known: {self.instead}")


class TotemPole(_Unsimulated):
    """A pole of coloured solids, once a landmark."""

    instead = "put SimpleSolids on top of each other in its place"


class PointSet(_Unsimulated):
    """Points of a file, once drawn."""

    instead = "it only drew points, and touched nothing"
