"""The public names of libgz, and the one module that each comes from."""

from libgz._version import __version__ as __version__
from libgz.errors import (
    ClosedError as ClosedError,
)
from libgz.errors import (
    GazeboError as GazeboError,
)
from libgz.errors import (
    InterfaceError as InterfaceError,
)
from libgz.errors import (
    LibraryError as LibraryError,
)
from libgz.errors import (
    NotFoundError as NotFoundError,
)
from libgz.errors import (
    ParameterError as ParameterError,
)
from libgz.errors import (
    PluginError as PluginError,
)
from libgz.errors import (
    ServerError as ServerError,
)
from libgz.errors import (
    ServerGoneError as ServerGoneError,
)
from libgz.errors import (
    WorldFileError as WorldFileError,
)
from libgz.geometry import (
    DTOR as DTOR,
)
from libgz.geometry import (
    NORMALIZE as NORMALIZE,
)
from libgz.geometry import (
    RTOD as RTOD,
)
from libgz.geometry import (
    GzColor as GzColor,
)
from libgz.geometry import (
    GzCoordPoseAdd as GzCoordPoseAdd,
)
from libgz.geometry import (
    GzCoordPoseSolve as GzCoordPoseSolve,
)
from libgz.geometry import (
    GzCoordPoseSub as GzCoordPoseSub,
)
from libgz.geometry import (
    GzCoordPositionAdd as GzCoordPositionAdd,
)
from libgz.geometry import (
    GzCoordPositionSub as GzCoordPositionSub,
)
from libgz.geometry import (
    GzCoordRotationAdd as GzCoordRotationAdd,
)
from libgz.geometry import (
    GzCoordRotationSub as GzCoordRotationSub,
)
from libgz.geometry import (
    GzHomo as GzHomo,
)
from libgz.geometry import (
    GzHomoFromQuatern as GzHomoFromQuatern,
)
from libgz.geometry import (
    GzHomoInverse as GzHomoInverse,
)
from libgz.geometry import (
    GzHomoMul as GzHomoMul,
)
from libgz.geometry import (
    GzPose as GzPose,
)
from libgz.geometry import (
    GzPoseFinite as GzPoseFinite,
)
from libgz.geometry import (
    GzPosePointAt as GzPosePointAt,
)
from libgz.geometry import (
    GzPoseSet as GzPoseSet,
)
from libgz.geometry import (
    GzQuatern as GzQuatern,
)
from libgz.geometry import (
    GzQuaternFinite as GzQuaternFinite,
)
from libgz.geometry import (
    GzQuaternFromAxis as GzQuaternFromAxis,
)
from libgz.geometry import (
    GzQuaternFromEuler as GzQuaternFromEuler,
)
from libgz.geometry import (
    GzQuaternFromHomo as GzQuaternFromHomo,
)
from libgz.geometry import (
    GzQuaternIdent as GzQuaternIdent,
)
from libgz.geometry import (
    GzQuaternInverse as GzQuaternInverse,
)
from libgz.geometry import (
    GzQuaternMul as GzQuaternMul,
)
from libgz.geometry import (
    GzQuaternNormal as GzQuaternNormal,
)
from libgz.geometry import (
    GzQuaternScale as GzQuaternScale,
)
from libgz.geometry import (
    GzQuaternSet as GzQuaternSet,
)
from libgz.geometry import (
    GzQuaternSetVector as GzQuaternSetVector,
)
from libgz.geometry import (
    GzQuaternToAxis as GzQuaternToAxis,
)
from libgz.geometry import (
    GzQuaternToEuler as GzQuaternToEuler,
)
from libgz.geometry import (
    GzVector as GzVector,
)
from libgz.geometry import (
    GzVectorAdd as GzVectorAdd,
)
from libgz.geometry import (
    GzVectorCross as GzVectorCross,
)
from libgz.geometry import (
    GzVectorDot as GzVectorDot,
)
from libgz.geometry import (
    GzVectorFinite as GzVectorFinite,
)
from libgz.geometry import (
    GzVectorMag as GzVectorMag,
)
from libgz.geometry import (
    GzVectorMul as GzVectorMul,
)
from libgz.geometry import (
    GzVectorSet as GzVectorSet,
)
from libgz.geometry import (
    GzVectorSetQuatern as GzVectorSetQuatern,
)
from libgz.geometry import (
    GzVectorSub as GzVectorSub,
)
from libgz.geometry import (
    GzVectorUnit as GzVectorUnit,
)
from libgz.geometry import (
    GzVectorZero as GzVectorZero,
)
from libgz.interfaces.client import Client as Client
from libgz.interfaces.fiducial import (
    GZ_FIDUCIAL_MAX_FIDS as GZ_FIDUCIAL_MAX_FIDS,
)
from libgz.interfaces.fiducial import (
    Fiducial as Fiducial,
)
from libgz.interfaces.fiducial import (
    FiducialData as FiducialData,
)
from libgz.interfaces.fiducial import (
    FiducialFid as FiducialFid,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_alloc as gz_fiducial_alloc,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_close as gz_fiducial_close,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_create as gz_fiducial_create,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_destroy as gz_fiducial_destroy,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_free as gz_fiducial_free,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_lock as gz_fiducial_lock,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_open as gz_fiducial_open,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_post as gz_fiducial_post,
)
from libgz.interfaces.fiducial import (
    gz_fiducial_unlock as gz_fiducial_unlock,
)
from libgz.interfaces.laser import (
    GZ_LASER_MAX_RANGES as GZ_LASER_MAX_RANGES,
)
from libgz.interfaces.laser import (
    Laser as Laser,
)
from libgz.interfaces.laser import (
    LaserData as LaserData,
)
from libgz.interfaces.laser import (
    gz_laser_alloc as gz_laser_alloc,
)
from libgz.interfaces.laser import (
    gz_laser_close as gz_laser_close,
)
from libgz.interfaces.laser import (
    gz_laser_create as gz_laser_create,
)
from libgz.interfaces.laser import (
    gz_laser_destroy as gz_laser_destroy,
)
from libgz.interfaces.laser import (
    gz_laser_free as gz_laser_free,
)
from libgz.interfaces.laser import (
    gz_laser_lock as gz_laser_lock,
)
from libgz.interfaces.laser import (
    gz_laser_open as gz_laser_open,
)
from libgz.interfaces.laser import (
    gz_laser_post as gz_laser_post,
)
from libgz.interfaces.laser import (
    gz_laser_unlock as gz_laser_unlock,
)
from libgz.interfaces.position import (
    Position as Position,
)
from libgz.interfaces.position import (
    PositionData as PositionData,
)
from libgz.interfaces.position import (
    gz_position_alloc as gz_position_alloc,
)
from libgz.interfaces.position import (
    gz_position_close as gz_position_close,
)
from libgz.interfaces.position import (
    gz_position_create as gz_position_create,
)
from libgz.interfaces.position import (
    gz_position_destroy as gz_position_destroy,
)
from libgz.interfaces.position import (
    gz_position_free as gz_position_free,
)
from libgz.interfaces.position import (
    gz_position_lock as gz_position_lock,
)
from libgz.interfaces.position import (
    gz_position_open as gz_position_open,
)
from libgz.interfaces.position import (
    gz_position_post as gz_position_post,
)
from libgz.interfaces.position import (
    gz_position_unlock as gz_position_unlock,
)
from libgz.interfaces.power import (
    Power as Power,
)
from libgz.interfaces.power import (
    PowerData as PowerData,
)
from libgz.interfaces.power import (
    gz_power_alloc as gz_power_alloc,
)
from libgz.interfaces.power import (
    gz_power_close as gz_power_close,
)
from libgz.interfaces.power import (
    gz_power_create as gz_power_create,
)
from libgz.interfaces.power import (
    gz_power_destroy as gz_power_destroy,
)
from libgz.interfaces.power import (
    gz_power_free as gz_power_free,
)
from libgz.interfaces.power import (
    gz_power_lock as gz_power_lock,
)
from libgz.interfaces.power import (
    gz_power_open as gz_power_open,
)
from libgz.interfaces.power import (
    gz_power_post as gz_power_post,
)
from libgz.interfaces.power import (
    gz_power_unlock as gz_power_unlock,
)
from libgz.interfaces.ptz import (
    Ptz as Ptz,
)
from libgz.interfaces.ptz import (
    PtzData as PtzData,
)
from libgz.interfaces.ptz import (
    gz_ptz_alloc as gz_ptz_alloc,
)
from libgz.interfaces.ptz import (
    gz_ptz_close as gz_ptz_close,
)
from libgz.interfaces.ptz import (
    gz_ptz_create as gz_ptz_create,
)
from libgz.interfaces.ptz import (
    gz_ptz_destroy as gz_ptz_destroy,
)
from libgz.interfaces.ptz import (
    gz_ptz_free as gz_ptz_free,
)
from libgz.interfaces.ptz import (
    gz_ptz_lock as gz_ptz_lock,
)
from libgz.interfaces.ptz import (
    gz_ptz_open as gz_ptz_open,
)
from libgz.interfaces.ptz import (
    gz_ptz_post as gz_ptz_post,
)
from libgz.interfaces.ptz import (
    gz_ptz_unlock as gz_ptz_unlock,
)
from libgz.interfaces.sim import (
    Sim as Sim,
)
from libgz.interfaces.sim import (
    SimData as SimData,
)
from libgz.interfaces.sim import (
    gz_sim_alloc as gz_sim_alloc,
)
from libgz.interfaces.sim import (
    gz_sim_close as gz_sim_close,
)
from libgz.interfaces.sim import (
    gz_sim_create as gz_sim_create,
)
from libgz.interfaces.sim import (
    gz_sim_destroy as gz_sim_destroy,
)
from libgz.interfaces.sim import (
    gz_sim_free as gz_sim_free,
)
from libgz.interfaces.sim import (
    gz_sim_lock as gz_sim_lock,
)
from libgz.interfaces.sim import (
    gz_sim_open as gz_sim_open,
)
from libgz.interfaces.sim import (
    gz_sim_unlock as gz_sim_unlock,
)
from libgz.interfaces.sonar import (
    GZ_SONAR_MAX_RANGES as GZ_SONAR_MAX_RANGES,
)
from libgz.interfaces.sonar import (
    Sonar as Sonar,
)
from libgz.interfaces.sonar import (
    SonarData as SonarData,
)
from libgz.interfaces.sonar import (
    gz_sonar_alloc as gz_sonar_alloc,
)
from libgz.interfaces.sonar import (
    gz_sonar_close as gz_sonar_close,
)
from libgz.interfaces.sonar import (
    gz_sonar_create as gz_sonar_create,
)
from libgz.interfaces.sonar import (
    gz_sonar_destroy as gz_sonar_destroy,
)
from libgz.interfaces.sonar import (
    gz_sonar_free as gz_sonar_free,
)
from libgz.interfaces.sonar import (
    gz_sonar_lock as gz_sonar_lock,
)
from libgz.interfaces.sonar import (
    gz_sonar_open as gz_sonar_open,
)
from libgz.interfaces.sonar import (
    gz_sonar_unlock as gz_sonar_unlock,
)
from libgz.ode.types import (
    dInfinity as dInfinity,
)
from libgz.ode.types import (
    dParamBounce as dParamBounce,
)
from libgz.ode.types import (
    dParamBounce2 as dParamBounce2,
)
from libgz.ode.types import (
    dParamCFM as dParamCFM,
)
from libgz.ode.types import (
    dParamCFM2 as dParamCFM2,
)
from libgz.ode.types import (
    dParamERP as dParamERP,
)
from libgz.ode.types import (
    dParamERP2 as dParamERP2,
)
from libgz.ode.types import (
    dParamFMax as dParamFMax,
)
from libgz.ode.types import (
    dParamFMax2 as dParamFMax2,
)
from libgz.ode.types import (
    dParamFudgeFactor as dParamFudgeFactor,
)
from libgz.ode.types import (
    dParamFudgeFactor2 as dParamFudgeFactor2,
)
from libgz.ode.types import (
    dParamHiStop as dParamHiStop,
)
from libgz.ode.types import (
    dParamHiStop2 as dParamHiStop2,
)
from libgz.ode.types import (
    dParamHiVel as dParamHiVel,
)
from libgz.ode.types import (
    dParamHiVel2 as dParamHiVel2,
)
from libgz.ode.types import (
    dParamLoStop as dParamLoStop,
)
from libgz.ode.types import (
    dParamLoStop2 as dParamLoStop2,
)
from libgz.ode.types import (
    dParamLoVel as dParamLoVel,
)
from libgz.ode.types import (
    dParamLoVel2 as dParamLoVel2,
)
from libgz.ode.types import (
    dParamStopCFM as dParamStopCFM,
)
from libgz.ode.types import (
    dParamStopCFM2 as dParamStopCFM2,
)
from libgz.ode.types import (
    dParamStopERP as dParamStopERP,
)
from libgz.ode.types import (
    dParamStopERP2 as dParamStopERP2,
)
from libgz.ode.types import (
    dParamSuspensionCFM as dParamSuspensionCFM,
)
from libgz.ode.types import (
    dParamSuspensionCFM2 as dParamSuspensionCFM2,
)
from libgz.ode.types import (
    dParamSuspensionERP as dParamSuspensionERP,
)
from libgz.ode.types import (
    dParamSuspensionERP2 as dParamSuspensionERP2,
)
from libgz.ode.types import (
    dParamVel as dParamVel,
)
from libgz.ode.types import (
    dParamVel2 as dParamVel2,
)
from libgz.physics.body import Body as Body
from libgz.physics.geom import Geom as Geom
from libgz.physics.geoms import (
    BoxGeom as BoxGeom,
)
from libgz.physics.geoms import (
    CapsuleGeom as CapsuleGeom,
)
from libgz.physics.geoms import (
    CylinderGeom as CylinderGeom,
)
from libgz.physics.geoms import (
    FrustrumGeom as FrustrumGeom,
)
from libgz.physics.geoms import (
    HeightfieldGeom as HeightfieldGeom,
)
from libgz.physics.geoms import (
    LightGeom as LightGeom,
)
from libgz.physics.geoms import (
    PlaneGeom as PlaneGeom,
)
from libgz.physics.geoms import (
    RayGeom as RayGeom,
)
from libgz.physics.geoms import (
    SphereGeom as SphereGeom,
)
from libgz.physics.geoms import (
    TriMeshGeom as TriMeshGeom,
)
from libgz.physics.geoms import (
    WheelGeom as WheelGeom,
)
from libgz.physics.joint import (
    BallJoint as BallJoint,
)
from libgz.physics.joint import (
    FixedJoint as FixedJoint,
)
from libgz.physics.joint import (
    Hinge2Joint as Hinge2Joint,
)
from libgz.physics.joint import (
    HingeJoint as HingeJoint,
)
from libgz.physics.joint import (
    Joint as Joint,
)
from libgz.physics.joint import (
    JointGroup as JointGroup,
)
from libgz.physics.joint import (
    SliderJoint as SliderJoint,
)
from libgz.physics.joint import (
    UniversalJoint as UniversalJoint,
)
from libgz.sensors.rays import RayProximity as RayProximity
from libgz.simulation.factory import (
    GZ_REGISTER_PLUGIN as GZ_REGISTER_PLUGIN,
)
from libgz.simulation.factory import (
    GZ_REGISTER_STATIC as GZ_REGISTER_STATIC,
)
from libgz.simulation.factory import (
    ModelFactory as ModelFactory,
)
from libgz.simulation.model import Model as Model
from libgz.simulation.rate import UpdateRate as UpdateRate
from libgz.simulation.world import World as World
from libgz.transport.legacy import (
    GZ_CLIENT_ID_PLAYER as GZ_CLIENT_ID_PLAYER,
)
from libgz.transport.legacy import (
    GZ_CLIENT_ID_USER_FIRST as GZ_CLIENT_ID_USER_FIRST,
)
from libgz.transport.legacy import (
    GZ_CLIENT_ID_USER_LAST as GZ_CLIENT_ID_USER_LAST,
)
from libgz.transport.legacy import (
    GZ_CLIENT_ID_WXGAZEBO as GZ_CLIENT_ID_WXGAZEBO,
)
from libgz.transport.legacy import (
    gz_client_alloc as gz_client_alloc,
)
from libgz.transport.legacy import (
    gz_client_connect as gz_client_connect,
)
from libgz.transport.legacy import (
    gz_client_connect_wait as gz_client_connect_wait,
)
from libgz.transport.legacy import (
    gz_client_disconnect as gz_client_disconnect,
)
from libgz.transport.legacy import (
    gz_client_free as gz_client_free,
)
from libgz.transport.legacy import (
    gz_client_query as gz_client_query,
)
from libgz.transport.legacy import (
    gz_client_wait as gz_client_wait,
)
from libgz.transport.legacy import (
    gz_error_init as gz_error_init,
)
from libgz.transport.legacy import (
    gz_error_str as gz_error_str,
)
from libgz.transport.legacy import (
    gz_server_alloc as gz_server_alloc,
)
from libgz.transport.legacy import (
    gz_server_fini as gz_server_fini,
)
from libgz.transport.legacy import (
    gz_server_free as gz_server_free,
)
from libgz.transport.legacy import (
    gz_server_init as gz_server_init,
)
from libgz.transport.legacy import (
    gz_server_post as gz_server_post,
)
from libgz.worldfile.file import WorldFile as WorldFile
from libgz.worldfile.node import WorldFileNode as WorldFileNode
