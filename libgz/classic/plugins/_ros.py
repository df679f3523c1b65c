"""Topics, joints and rates as plugins of the ROS era name them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.errors import NotFoundError

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

__all__ = ["ros_joint", "ros_rate", "ros_topic"]


def ros_topic(model: Model, sdf: Element, tag: str, default: str) -> str:
    """The topic that an element names: `/<robotNamespace>/<name>`; without a namespace, `~/<model>/<name>`."""
    name = sdf.Get(str, tag, default)[0].strip()
    if name.startswith(("/", "~")):
        return name
    space = sdf.Get(str, "robotNamespace").strip().strip("/")
    return f"/{space}/{name}" if space else f"~/{model.GetName()}/{name}"


def ros_joint(model: Model, sdf: Element, tag: str, default: str) -> Joint:
    """The joint that an element names.

    Raises:
        NotFoundError: there is no such joint.
    """
    name = sdf.Get(str, tag, default)[0].strip()
    joint = model.GetJoint(name)
    if joint is None:
        known = ", ".join(joint.GetName() for joint in model.all_joints()) or "none"
        raise NotFoundError(f"{sdf.where}: <{tag}> is {name!r}; model {model.GetName()!r} has {known}")
    return joint


def ros_rate(model: Model, sdf: Element, default: float) -> float:
    """The rate that `<updateRate>` gives [Hz]; 0 or less: that of the iterations."""
    rate: float = sdf.Get(float, "updateRate", default)[0]
    return rate if rate > 0.0 else 1.0 / model.GetWorld().Physics().GetMaxStepSize()
