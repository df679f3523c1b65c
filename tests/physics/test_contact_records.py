"""Records of contact points, and feedback of joints."""

import numpy as np
import pytest
from engine_parts import dressed_box as box, dressed_ground as ground, use_classic

import libgz
from libgz.ode.types import ContactRule
from libgz.physics.engine import Engine
from libgz.physics.space import Space


@pytest.fixture
def engine(classic_engine):
    classic_engine.gravity = (0, 0, -10)
    classic_engine.record_contacts = True
    return classic_engine


def steps(engine, count):
    for _ in range(count):
        engine.step()


def test_a_box_at_rest_is_carried_at_its_corners(engine):
    plane, geom = ground(engine), box(engine, (0, 0, 0.5), mass=3.0)
    steps(engine, 300)
    found = engine.contacts
    assert len(found) == engine.contact_count == 4
    for one, two, sign, force in (
        (geom.row, plane.row, 1.0, "force1"),
        (plane.row, geom.row, -1.0, "force2"),
    ):
        mine = found[found["geom1"] == one]
        assert set(mine["geom2"]) <= {two}
        assert (np.abs(mine["normal"] - (0, 0, sign)) < 1e-9).all()
        assert (mine[force][:, 2] > 0).all()
    assert engine.geoms[int(found["geom1"][0])].body in (geom.body, plane.body)
    total = found["force1"] + found["force2"]
    assert total.sum(axis=0) == pytest.approx((0, 0, 30.0), abs=1e-3)
    assert sorted(map(tuple, np.round(found["position"][:, :2], 6))) == [
        (-0.5, -0.5),
        (-0.5, 0.5),
        (0.5, -0.5),
        (0.5, 0.5),
    ]
    assert np.abs((found["torque1"] + found["torque2"]).sum(axis=0)).max() < 1e-3


def test_two_bodies_feel_opposite_forces(engine):
    ground(engine)
    low, high = box(engine, (0, 0, 0.5), mass=2.0), box(engine, (0.1, 0, 1.5), mass=4.0)
    steps(engine, 300)
    found = engine.contacts
    rows = {low.row, high.row}
    between = found[[{int(r["geom1"]), int(r["geom2"])} == rows for r in found]]
    assert len(between) >= 4
    assert np.abs(between["force1"] + between["force2"]).max() < 1e-9
    up = np.where(between["geom1"] == high.row, between["force1"][:, 2], between["force2"][:, 2]).sum()
    assert up == pytest.approx(40.0, abs=0.05)


def test_after_collide_alone_the_points_are_there_and_the_forces_are_not(engine):
    ground(engine)
    box(engine, (0, 0, 0.499))
    engine.collide()
    found = engine.contacts
    assert len(found) == 4
    assert found["depth"] == pytest.approx(0.001)
    assert not found["force1"].any()
    assert not found["force2"].any()
    engine.solve()
    assert engine.contacts["depth"] == pytest.approx(0.001)
    assert (engine.contacts["force1"] + engine.contacts["force2"])[:, 2].sum() > 1.0


def test_ghosts_are_recorded_without_effect(engine):
    ground(engine, GHOST_BITS=1)
    falls = box(engine, (0, 0, 0.5), GHOST=1, GHOST_BITS=1)
    unseen = box(engine, (3, 0, 0.5), GHOST=1, GHOST_BITS=2)
    steps(engine, 100)
    found = engine.contacts
    assert falls.body.GetPosition().z == pytest.approx(unseen.body.GetPosition().z) == pytest.approx(0.45, abs=1e-3)
    assert len(found) == 4
    assert unseen.row not in {*found["geom1"], *found["geom2"]}
    assert not found["force1"].any()
    assert not found["force2"].any()
    assert engine.contact_count == 0


def test_records_are_off_at_first_and_change_nothing(engine):
    ends = []
    for record in (False, True):
        for solver in ("world", "quick"):
            twin = Engine(step_time=0.001, solver=solver, seed=7)
            use_classic(twin)
            assert not twin.record_contacts
            twin.record_contacts = record
            ground(twin)
            box(twin, (0, 0, 0.6)).body.SetAngularVel((1, 2, 3))
            box(twin, (0.2, 0.1, 1.7))
            steps(twin, 400)
            assert len(twin.contacts) == (twin.contact_count if record else 0)
            ends.append(twin.states.tobytes())
    assert ends[:2] == ends[2:]


def test_legacy_worlds_are_recorded_too(engine):
    engine.contact_rule = ContactRule.LEGACY
    ground(engine)
    box(engine, (0, 0, 0.5), mass=2.0)
    steps(engine, 200)
    assert (engine.contacts["force1"] + engine.contacts["force2"]).sum(axis=0) == pytest.approx((0, 0, 20), abs=0.1)


def test_both_forms_record_the_same_bits():
    def run():
        twin = Engine(step_time=0.001, solver="quick", seed=3)
        use_classic(twin)
        twin.record_contacts = twin.cone = twin.record_motion = True
        ground(twin, mu=0.8, TORSION=0.5)
        for i in range(40):
            place, spin = (0.4 * (i % 7), 0.3 * (i // 7), 0.6 + 1.1 * (i // 7)), {"MAX_CONTACTS": 3 + i % 5}
            torsion = {"PATCH_RADIUS": 0.1 * (i % 3), "BY_PATCH": i % 2, "RADIUS": 0.5, "TORSION": 0.4}
            geom = box(
                twin,
                place,
                mu=0.1 * (i % 9),
                GHOST=i % 5 == 4,
                MIN_DEPTH=1e-4 * i,
                MAX_VEL=0.01 * (i % 4),
                **spin,
                **torsion,
            )
            geom.body.SetAngularVel((i, 1, 0))
        libgz.CylinderGeom(libgz.Body(twin, dummy=True), Space(twin), 0.3, 1.0).SetRelativePosition((0.5, 0.5, 0.5))
        libgz.CylinderGeom(libgz.Body(twin), Space(twin), 0.3, 1.0).SetRelativePosition((0.5, 0.5, 1.6))
        kept = []
        for _ in range(120):
            twin.step()
            kept.append(twin.contacts.tobytes())
        return kept, twin.states.tobytes() + twin.tables.bodies.motion.tobytes()

    found = run()
    assert found == run()
    assert any(found[0])


def test_records_outlive_the_engine_that_made_them(engine):
    ground(engine)
    box(engine, (0, 0, 0.5))
    engine.step()
    found = engine.contacts
    before = found.tobytes()
    steps(engine, 10)
    engine.close()
    assert found.tobytes() == before


@pytest.mark.parametrize("first", [True, False])
def test_feedback_of_a_joint_that_carries_a_body(engine, first):
    body = libgz.Body(engine)
    libgz.BoxGeom(body, None, 1, 1, 1).SetMass(2.0)
    body.SetPosition((1.0, 0, 0))
    joint = libgz.FixedJoint(engine)
    joint.Attach(*((body, None) if first else (None, body)))
    joint.SetFixed()
    engine.step()
    assert all(tuple(v) == (0, 0, 0) for v in joint.feedback)
    joint.provide_feedback(True)
    engine.step()
    result = joint.feedback
    force, torque = result[:2] if first else result[2:]
    assert tuple(force) == pytest.approx((0, 0, 20.0))
    assert tuple(torque) == pytest.approx((0, 0, 0), abs=1e-9)
    assert all(tuple(v) == (0, 0, 0) for v in (result[2:] if first else result[:2]))
    joint.provide_feedback(False)
    assert tuple(joint.feedback[0]) == (0, 0, 0)


def test_feedback_between_two_bodies(engine):
    upper, lower = libgz.Body(engine), libgz.Body(engine)
    for body, mass, z in ((upper, 3.0, 2.0), (lower, 1.0, 1.0)):
        libgz.BoxGeom(body, None, 0.1, 0.1, 0.1).SetMass(mass)
        body.SetPosition((0, 0, z))
    hook, hinge = libgz.FixedJoint(engine), libgz.HingeJoint(engine)
    hook.Attach(upper, None)
    hook.SetFixed()
    hinge.Attach(lower, upper)
    hinge.SetAnchor((0, 0, 1.5))
    hinge.SetAxis((0, 1, 0))
    hook.provide_feedback(True)
    hinge.provide_feedback(True)
    engine.step()
    force1, _, force2, _ = hinge.feedback
    assert tuple(force1) == pytest.approx((0, 0, 10.0))
    assert tuple(force2) == pytest.approx((0, 0, -10.0))
    assert hook.feedback[0].z == pytest.approx(40.0)


def test_a_body_knows_its_model():
    with libgz.World.from_string(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:SimpleSolid><id>s</id></model:SimpleSolid></gz:world>"
    ) as world:
        assert world.model("s").GetBody().model is world.model("s")


def test_accelerations_and_applied_forces(engine):
    engine.gravity = (0, 0, -9.8)
    body = libgz.Body(engine)
    libgz.BoxGeom(body, Space(engine), 1, 1, 1).SetMass(2.0)
    body.SetPosition((0, 0, 5))
    engine.step()
    assert tuple(body.GetLinearAccel()) == (0, 0, 0)
    engine.record_motion = True
    body.SetLinearVel((3.0, 0, 0))
    body.AddForce(4.0, 0, 0)
    body.AddTorque(0, 0, 1.0)
    engine.step()
    assert tuple(body.GetLinearAccel()) == pytest.approx((2.0, 0, -9.8))
    assert tuple(body.GetAngularAccel()) == pytest.approx((0, 0, 1.0 / (2.0 / 6)))
    assert (tuple(body.GetAppliedForce()), tuple(body.GetAppliedTorque())) == ((4, 0, 0), (0, 0, 1))
    engine.step()
    assert tuple(body.GetAppliedForce()) == (0, 0, 0)
    assert tuple(body.GetLinearAccel()) == pytest.approx((0, 0, -9.8))


def test_velocity_at_a_point_and_energies(engine):
    body = libgz.Body(engine)
    libgz.BoxGeom(body, Space(engine), 1, 1, 1).SetMass(3.0)
    body.SetPosition((0, 0, 2))
    body.SetLinearVel((1, 0, 0))
    body.SetAngularVel((0, 0, 2))
    assert tuple(body.GetPointVel((0, 1, 2))) == pytest.approx((-1, 0, 0))
    assert body.GetKineticEnergy() == pytest.approx(3.0 / 2 + 0.5 * 0.5 * 4)
    assert body.GetPotentialEnergy() == pytest.approx(3 * 10 * 2)


def test_bodies_that_sleep_carry_what_they_carried():
    def run():
        engine = Engine(step_time=0.001, solver="quick", seed=3)
        use_classic(engine)
        engine.gravity, engine.record_contacts = (0, 0, -10), True
        ground(engine)
        low, high = box(engine, (0, 0, 0.5), mass=2.0), box(engine, (0.1, 0, 1.5), mass=4.0)
        for geom in (low, high):
            geom.body.set_auto_disable(True)
        steps(engine, 1500)
        assert not any(geom.body.IsEnabled() for geom in (low, high))
        asleep = engine.contacts
        state = engine.get_state()
        steps(engine, 3)
        later = engine.contacts
        engine.collide()  # alone
        assert engine.contacts.tobytes() == later.tobytes()
        engine.set_state(state)
        steps(engine, 3)
        assert engine.contacts.tobytes() == later.tobytes()
        high.body.SetPose(libgz.GzPose(libgz.GzVector(5, 0, 0.5)))  # awake: it carries what it carries there
        steps(engine, 1)
        return asleep, later, engine.contacts, (low.row, high.row)

    asleep, later, moved, (low, high) = run()
    assert asleep.tobytes() == later.tobytes()
    weight = pytest.approx(60.0, abs=1e-6)
    assert sum(abs(r["force1"] + r["force2"])[2] for r in later if high not in (r["geom1"], r["geom2"])) == weight
    assert not any({r["geom1"], r["geom2"]} == {low, high} for r in moved)
