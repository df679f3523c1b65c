"""libgz joint: apply forces to joints of a running SDF world, and set targets and gains of their controllers."""

from __future__ import annotations

import argparse
from typing import Any

from libgz.apps.console import finite_number, say
from libgz.apps.server_link import add_world, ask, publish, world_node
from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.visible import one_line
from libgz.classic import msgs

__all__ = ["configure", "run"]

GAINS = {"t": "target", "p": "p_gain", "i": "i_gain", "d": "d_gain"}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add_world(parser)
    add("-m", "--model-name", required=True, metavar="NAME", help="name of the model")
    add("-j", "--joint-name", metavar="JOINT", help="name of the joint")
    add("-i", "--info", action="store_true", help="print the joint's position, or those of all joints")
    add("-d", "--delete", dest="reset", action="store_true", help="reset forces and targets")
    add("-f", "--force", type=finite_number("force"), metavar="N", help="apply a constant force or torque [N or N m]")
    for kind, word, unit in (("pos", "position", "rad or m"), ("vel", "velocity", "rad/s or m/s")):
        add(f"--{kind}-t", type=finite_number("target"), metavar="N", help=f"{word} target [{unit}]")
        for letter, gain in (("p", "proportional"), ("i", "integral"), ("d", "derivative")):
            text = f"{gain} gain of the {word} controller"
            add(f"--{kind}-{letter}", type=finite_number("gain"), metavar="N", help=text)


def run(options: argparse.Namespace) -> int:
    """Print positions, or send a command.

    Raises:
        ServerError: there is no server.
        NotFoundError: there is no such model or joint.
        ParameterError: the command line is incomplete.
    """
    with world_node(options) as (node, _link):
        model = ask(node, "entity_info", options.model_name)
        joints = {joint.name.rpartition("::")[2]: joint for joint in model.joint}
        if options.joint_name is not None and options.joint_name not in joints:
            known = ", ".join(joints) or "none"
            hint = nearest(options.joint_name, joints)
            raise NotFoundError(
                f"model {options.model_name!r} has no joint {options.joint_name!r}; it has {known}{hint}"
            )
        if options.info:
            for name, joint in joints.items():
                if options.joint_name in (None, name):
                    say(one_line(name), *(f"{angle:.6f}" for angle in joint.angle))
            return 0
        if options.joint_name is None:
            raise ParameterError("no joint is given; use -j JOINT, or -i for all joints")
        publish(
            node, f"~/{model.name.replace('::', '/')}/joint_cmd", _command(joints[options.joint_name].name, options)
        )
    return 0


def _command(name: str, options: argparse.Namespace) -> Any:
    message = msgs.JointCmd(name=name)
    if options.reset:
        message.reset = True
    if options.force is not None:
        message.force = options.force
    for kind, field in (("pos", "position"), ("vel", "velocity")):
        for letter, gain in GAINS.items():
            value = getattr(options, f"{kind}_{letter}")
            if value is not None:
                setattr(getattr(message, field), gain, value)
    if len(message.ListFields()) == 1:
        raise ParameterError("no action is given; use -f N, --pos-t N, --vel-t N, gains such as --pos-p N, -d, or -i")
    return message
