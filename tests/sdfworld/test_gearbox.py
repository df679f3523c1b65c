"""Gearboxes beside the real Gazebo 11.1: rates of both gears and of what carries them, also after a ratio changed."""

import pytest
from sdf_worlds import inertial, joint, link, model, world

STEPS = 600
TORQUE = 0.3  # [N m] on the first gear
CHANGED = 501  # the step before which a parameter changes


def gears(ratio, axes=("0 1 0", "0 1 0"), held=True, reference=True, order=("a", "b")):
    """Two wheels on a base, that the gearbox joins as its parent and its child."""
    wheels = (
        link("a", inertial(1.0, (0.05,) * 3), pose="0 0 .5 0 0 0"),
        link("b", inertial(1.0, (0.08,) * 3), pose="0 .5 .5 0 0 0"),
        joint("ja", "revolute", "base", "a", axes[0]),
        joint("jb", "revolute", "base", "b", axes[1]),
    )
    carrier = "<gearbox_reference_body>base</gearbox_reference_body>" if reference else ""
    second = f"<axis2><xyz>{axes[1]}</xyz></axis2>"
    gearbox = joint("gear", "gearbox", *order, axes[0], f"{second}<gearbox_ratio>{ratio}</gearbox_ratio>{carrier}")
    fixed = joint("hold", "fixed", "world", "base", "") if held else ""
    return world(model("g", link("base", inertial(5.0, (0.5,) * 3)), *wheels, fixed, gearbox), gravity="0 0 0")


ACROSS = {"axes": ("1 0 0", "0 1 0"), "order": ("b", "a")}
AFTER = {600: (0.782609, -1.17391, 0)}
# (what gears are given, parameter that changes, its value, {step: rates of both gears and the base in Gazebo [rad/s]})
RECORDED = [
    (
        (1.5, {}),
        "ratio",
        2.5,
        {500: (0.652174, -0.978261, 0), 501: (-11.4659, -4.00927, 0), 505: (-4.44891, -2.26103, 0)},
    ),
    (
        (-2.0, {}),
        "ratio",
        -1.0,
        {500: (0.405405, 0.810811, 0), 501: (13.1562, -7.15466, 0), 600: (0.885655, 0.885655, 0)},
    ),
    ((1.5, {}), "reference_angle1", 0.2, {501: (21.523, 7.71543, 0), 505: (9.20703, 2.57376, 0), **AFTER}),
    ((1.5, {}), "reference_angle2", -0.2, {501: (-30.6509, -14.0237, 0), 505: (-12.164, -6.33085, 0), **AFTER}),
    ((2.0, {"reference": False}), "", 0.0, {500: (0.405405, -0.810811, 0), 600: (0.486486, -0.972973, 0)}),
    ((-1.5, {"held": False}), "", 0.0, {500: (0.604857, 0.997904, -0.183067), 600: (0.725684, 1.19745, -0.219682)}),
    ((1.5, ACROSS), "", 0.0, {500: (1.75325, -1.16883, 0), 600: (2.1039, -1.4026, 0)}),
]


@pytest.mark.parametrize(("given", "key", "value", "recorded"), RECORDED)
def test_gears_turn_as_in_gazebo(load, given, key, value, recorded):
    ratio, options = given
    made = load(gears(ratio, **options))
    joints = made.model("g").sdf_joints
    columns = [
        ("xyz".index("xyz"[axis.split().index("1")])) for axis in (*options.get("axes", ("0 1 0",) * 2), "0 1 0")
    ]
    for step in range(1, STEPS + 1):
        joints["ja"].add_force(TORQUE)
        if step == CHANGED and key:
            joints["gear"].set_param(key, value)
        made.step()
        if step in recorded:
            rates = [made.body("g", n).GetAngularRate()[k] for n, k in zip(("a", "b", "base"), columns, strict=True)]
            assert rates == pytest.approx(recorded[step], rel=2e-5, abs=2e-5)


def test_endless_numbers_of_a_gearbox_are_bounded(load):
    made = load(gears(2.0))
    gear = made.model("g").sdf_joints["gear"]
    for key in ("ratio", "reference_angle1", "reference_angle2"):
        gear.set_param(key, float("inf"))
    made.step(3)
    assert abs(made.body("g", "a").GetAngularRate().y) < 1e6


@pytest.mark.parametrize("ratio", [1e-4, -1e4])
def test_gears_of_extreme_ratios_correct_any_error(load, ratio):
    made = load(gears(ratio))
    gear = made.model("g").sdf_joints["gear"]
    for key in ("reference_angle1", "reference_angle2"):
        gear.set_param(key, 3.1)
        made.step(5)
    assert made.model("g").failed is None
