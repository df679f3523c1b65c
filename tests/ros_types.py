"""Types of ROS 2 as the library rosbags and rclpy describe them."""

import re

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from libgz.ros.types import MessageType

NOETIC, JAZZY = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_JAZZY)


def stored(kind: MessageType, store):
    """The full name of a type in a store of rosbags, which learns it from our text if it does not know it."""
    name = kind.name.replace("/", "/msg/")
    if name not in store.fielddefs:
        for part in [kind, *kind.parts]:
            own = part.name.replace("/", "/msg/")
            if own not in store.fielddefs:
                text = part.own_text
                if store is JAZZY:
                    text = re.sub(
                        r"^(time|duration)\b", lambda m: f"builtin_interfaces/{m[1].title()}", text, flags=re.M
                    )
                store.register(get_types_from_msg(text, own))
    return name


def described(kind: MessageType):
    """What a ROS 2 says of a type and all in it, in the form of rclpy."""
    found, waiting = {}, [stored(kind, JAZZY)]
    while waiting:
        name = waiting.pop()
        rows = found[name.replace("/msg/", "/")] = {}
        for field, (node, about) in JAZZY.fielddefs[name][1]:
            number, rest = int(node), about
            inner, size = (rest[0], rest[1]) if number in (3, 4) else ((node, about), None)
            base = inner[1] if int(inner[0]) == 2 else inner[1][0]
            if int(inner[0]) == 2:
                if "builtin_interfaces" not in base and base not in waiting:
                    waiting.append(base)
                base = base.replace("/msg/", "/")
            rows[field] = base if size is None else f"{base}[{size}]" if number == 3 else f"sequence<{base}>"
    return found
