"""LiftScanner.cc in Python, line by line."""

import math

from libgz import (
    DTOR,
    GZ_REGISTER_PLUGIN,
    Body,
    BoxGeom,
    CylinderGeom,
    GzColor,
    Model,
    RayProximity,
    SliderJoint,
    dParamFMax,
    dParamHiStop,
    dParamLoStop,
    dParamVel,
    gz_laser_alloc,
    gz_laser_create,
    gz_laser_destroy,
    gz_laser_lock,
    gz_laser_post,
    gz_laser_unlock,
    gz_position_alloc,
    gz_position_create,
    gz_position_destroy,
    gz_position_lock,
    gz_position_unlock,
)

RAY_COUNT = 61
MAX_RANGE = 5.0  # [m]
STROKE = 0.5  # [m]
MAX_FORCE = 200.0  # [N]


class LiftScanner(Model):
    """A laser on a mast that a slider lifts."""

    STATE = ("updateTime", "rays")

    def Load(self, file, node):
        self.updatePeriod = 1.0 / (node.GetDouble("scanRate", 10.0) + 1e-6)
        self.updateTime = -self.updatePeriod

        self.base = Body(self.world)
        box = BoxGeom(self.base, self.modelSpaceId, 0.4, 0.4, 0.1)
        box.SetRelativePosition((0, 0, 0.05))
        box.SetMass(20.0)
        self.AddBody(self.base, True)

        self.head = Body(self.world, "head")
        cylinder = CylinderGeom(self.head, self.modelSpaceId, 0.05, 0.1)
        cylinder.SetMass(2.0)
        cylinder.SetColor(GzColor(0.1, 0.1, 0.1))
        self.AddBody(self.head)
        self.head.SetPosition((0, 0, 0.3))

        self.slider = SliderJoint(self.world)
        self.slider.Attach(self.head, self.base)
        self.slider.SetAxis(0, 0, 1)
        self.slider.SetParam(dParamLoStop, 0.0)
        self.slider.SetParam(dParamHiStop, STROKE)

        self.fov = fov = node.GetAngle("fov", DTOR(180))
        self.rays = RayProximity(self.world, self.head, RAY_COUNT)
        for i in range(RAY_COUNT):
            angle = fov * i / (RAY_COUNT - 1) - fov / 2
            start = (0.06 * math.cos(angle), 0.06 * math.sin(angle), 0)
            self.rays.SetRay(i, start, (MAX_RANGE * math.cos(angle), MAX_RANGE * math.sin(angle), 0))
        return 0

    def Init(self, file, node):
        owner = (self.GetId(), "LiftScanner", self.GetIntId(), self.GetParentIntId())
        self.laser, self.position = gz_laser_alloc(), gz_position_alloc()
        if gz_laser_create(self.laser, self.world.gz_server, *owner) != 0:
            return -1
        return gz_position_create(self.position, self.world.gz_server, *owner)

    def Fini(self):
        gz_position_destroy(self.position)
        gz_laser_destroy(self.laser)

    def Update(self, step):
        now = self.world.GetSimTime()
        if step == 0 or now - self.updateTime < self.updatePeriod - 1e-9:
            return
        self.updateTime = now

        if gz_position_lock(self.position) == 0:
            data = self.position.data
            self.slider.SetParam(dParamVel, data.cmd_vel_pos[2])
            self.slider.SetParam(dParamFMax, MAX_FORCE)
            data.time = now
            data.pos[2] = self.slider.GetPosition()
            data.vel_pos[2] = self.slider.GetPositionRate()
            gz_position_unlock(self.position)

        self.rays.Update()
        if gz_laser_lock(self.laser) == 0:
            data = self.laser.data
            data.time = now
            data.min_angle, data.max_angle = -self.fov / 2, self.fov / 2
            data.res_angle = self.fov / (RAY_COUNT - 1)
            data.max_range, data.range_count = MAX_RANGE, RAY_COUNT
            for i in range(RAY_COUNT):
                data.ranges[i] = min(0.06 + self.rays.GetRange(i), MAX_RANGE)
                data.intensity[i] = int(self.rays.GetRetro(i))
            gz_laser_unlock(self.laser)
            gz_laser_post(self.laser)


GZ_REGISTER_PLUGIN("LiftScanner", LiftScanner)
