"""A World plugin that reacts to events: rules in the world file insert and delete models.

A rule has one condition and any number of actions, and acts each time its condition becomes true:

    <rule>
      <inside model="ball"><min>1 -1 0</min><max>2 1 1</max></inside>   the model's origin is in this box [m]
      <above joint="gate::hinge">0.5</above>                            the joint is beyond this position [rad] or [m]
      <exists>prize</exists>                                            there is a model of this name
      <insert><model name="prize">...</model></insert>
      <delete>ball</delete>
    </rule>
"""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin, gzmsg, gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Vector3d


def children(element, name):
    """All children of one name, in order."""
    found = element.GetElement(name)
    while found is not None:
        yield found
        found = found.GetNextElement(name)


class Rule:
    def __init__(self, world, element):
        self.world, self.element = world, element
        self.was_true = False
        self.conditions = [
            *(lambda e=e: self.inside(e) for e in children(element, "inside")),
            *(lambda e=e: self.above(e) for e in children(element, "above")),
            *(lambda e=e: self.exists(e.Get(str)) for e in children(element, "exists")),
        ]

    def inside(self, element):
        model = self.world.ModelByName(element.Get(str, "model"))
        if model is None:
            return False
        low, high = element.Get(Vector3d, "min"), element.Get(Vector3d, "max")
        return all(a <= v <= b for a, v, b in zip(low, model.WorldPose().Pos(), high, strict=True))

    def above(self, element):
        model_name, _, joint_name = element.Get(str, "joint").partition("::")
        model = self.world.ModelByName(model_name)
        joint = model.GetJoint(joint_name) if model is not None else None
        return joint is not None and joint.Position(0) > element.Get(float)

    def exists(self, name):
        return self.world.ModelByName(name) is not None

    def check(self):
        is_true = bool(self.conditions) and all(condition() for condition in self.conditions)
        if is_true and not self.was_true:
            self.act()
        self.was_true = is_true

    def act(self):
        for insert in children(self.element, "insert"):
            model = insert.GetElement("model")
            gzmsg(f"{self.world.SimTime().Double():.3f} s: insert {model.Get(str, 'name')}")
            # Insertions and deletions in a callback take effect at the end of the iteration.
            self.world.InsertModelString(f"<sdf version='1.6'>{model.ToString()}</sdf>")
        for delete in children(self.element, "delete"):
            if self.exists(delete.Get(str)):
                gzmsg(f"{self.world.SimTime().Double():.3f} s: delete {delete.Get(str)}")
                self.world.RemoveModel(delete.Get(str))
            else:
                gzwarn(f"there is no {delete.Get(str)} to delete")


class EventRules(WorldPlugin):
    def Load(self, world, sdf):
        self.rules = [Rule(world, element) for element in children(sdf, "rule")]
        # A list keeps any number of connections.
        self.connections = [
            Events.ConnectWorldUpdateEnd(self.OnUpdateEnd),
            Events.ConnectAddEntity(lambda name: gzmsg(f"there is {name} now")),
            Events.ConnectDeleteEntity(lambda name: gzmsg(f"{name} is gone")),
            Events.ConnectPause(lambda paused: gzmsg("paused" if paused else "running")),
        ]

    def OnUpdateEnd(self):
        for rule in self.rules:
            rule.check()

    # Snapshots of the world keep which conditions were true.
    def SaveState(self):
        return [rule.was_true for rule in self.rules]

    def LoadState(self, state):
        for rule, was_true in zip(self.rules, state, strict=True):
            rule.was_true = was_true

    def Reset(self):
        for rule in self.rules:
            rule.was_true = False


GZ_REGISTER_WORLD_PLUGIN(EventRules)
