"""Look-up of joints, links and batteries that the elements of plugins name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, nearest

if TYPE_CHECKING:
    from libgz.classic.common import Battery
    from libgz.classic.physics import Joint, Link, Model
    from libgz.sdf.element import Element

__all__ = ["find_joint", "named_battery", "named_joint", "named_link"]


def find_joint(model: Model, name: str) -> Joint:
    """A joint of a model by name.

    Raises:
        NotFoundError: there is none.
    """
    joint = model.GetJoint(name)
    if joint is None:
        names = [joint.GetName() for joint in model.all_joints()]
        known = ", ".join(names) or "none"
        raise NotFoundError(f"model {model.GetName()!r} has no joint {name!r}; it has {known}{nearest(name, names)}")
    return joint


def named_joint(model: Model, sdf: Element, *tags: str) -> Joint:
    """The joint that an element of a plugin names; of several spellings of its tag, the first one present is read.

    Raises:
        NotFoundError: there is no such element, or no such joint.
    """
    tag = next((tag for tag in tags if sdf.HasElement(tag)), None)
    if tag is None:
        raise NotFoundError(f"{sdf.where}: <{tags[0]}> is missing and must name a joint")
    return find_joint(model, sdf.Get(str, tag).strip())


def named_link(model: Model, sdf: Element, tag: str = "link_name") -> Link:
    """The link that an element of a plugin names.

    Raises:
        NotFoundError: there is no such element, or no such link.
    """
    name = sdf.Get(str, tag).strip()
    link = model.GetLink(name) if name else None
    if link is None:
        names = [link.GetName() for link in model.family_links()]
        what = f"<{tag}> is {name!r}" if name else f"<{tag}> is missing and must name a link"
        raise NotFoundError(
            f"{sdf.where}: {what}; model {model.GetName()!r} has {', '.join(names)}{nearest(name, names)}"
        )
    return link


def named_battery(link: Link, sdf: Element) -> Battery:
    """The battery of a link that `<battery_name>` names.

    Raises:
        NotFoundError: there is no such element, or no such battery.
    """
    name = sdf.Get(str, "battery_name").strip()
    battery = link.Battery(name)
    if battery is None:
        names = [battery.Name() for battery in link.batteries]
        known = ", ".join(names) or "none"
        raise NotFoundError(
            f"{sdf.where}: <battery_name> is {name!r}; link {link.GetScopedName()} has {known}{nearest(name, names)}"
        )
    return battery
