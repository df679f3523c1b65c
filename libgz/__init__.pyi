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
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_ACTSTATE_BRAKED as GAZEBO_ACTARRAY_ACTSTATE_BRAKED,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_ACTSTATE_IDLE as GAZEBO_ACTARRAY_ACTSTATE_IDLE,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_ACTSTATE_MOVING as GAZEBO_ACTARRAY_ACTSTATE_MOVING,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_ACTSTATE_STALLED as GAZEBO_ACTARRAY_ACTSTATE_STALLED,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_JOINT_CURRENT_MODE as GAZEBO_ACTARRAY_JOINT_CURRENT_MODE,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_JOINT_POSITION_MODE as GAZEBO_ACTARRAY_JOINT_POSITION_MODE,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_JOINT_SPEED_MODE as GAZEBO_ACTARRAY_JOINT_SPEED_MODE,
)
from libgz.interfaces.actarray import (
    GAZEBO_ACTARRAY_NUM_ACTUATORS as GAZEBO_ACTARRAY_NUM_ACTUATORS,
)
from libgz.interfaces.actarray import (
    Actarray as Actarray,
)
from libgz.interfaces.actarray import (
    ActarrayActuator as ActarrayActuator,
)
from libgz.interfaces.actarray import (
    ActarrayData as ActarrayData,
)
from libgz.interfaces.actarray import (
    gz_actarray_alloc as gz_actarray_alloc,
)
from libgz.interfaces.actarray import (
    gz_actarray_close as gz_actarray_close,
)
from libgz.interfaces.actarray import (
    gz_actarray_create as gz_actarray_create,
)
from libgz.interfaces.actarray import (
    gz_actarray_destroy as gz_actarray_destroy,
)
from libgz.interfaces.actarray import (
    gz_actarray_free as gz_actarray_free,
)
from libgz.interfaces.actarray import (
    gz_actarray_lock as gz_actarray_lock,
)
from libgz.interfaces.actarray import (
    gz_actarray_open as gz_actarray_open,
)
from libgz.interfaces.actarray import (
    gz_actarray_post as gz_actarray_post,
)
from libgz.interfaces.actarray import (
    gz_actarray_unlock as gz_actarray_unlock,
)
from libgz.interfaces.camera import (
    GAZEBO_CAMERA_MAX_IMAGE_SIZE as GAZEBO_CAMERA_MAX_IMAGE_SIZE,
)
from libgz.interfaces.camera import (
    Camera as Camera,
)
from libgz.interfaces.camera import (
    CameraData as CameraData,
)
from libgz.interfaces.camera import (
    gz_camera_alloc as gz_camera_alloc,
)
from libgz.interfaces.camera import (
    gz_camera_close as gz_camera_close,
)
from libgz.interfaces.camera import (
    gz_camera_create as gz_camera_create,
)
from libgz.interfaces.camera import (
    gz_camera_destroy as gz_camera_destroy,
)
from libgz.interfaces.camera import (
    gz_camera_free as gz_camera_free,
)
from libgz.interfaces.camera import (
    gz_camera_lock as gz_camera_lock,
)
from libgz.interfaces.camera import (
    gz_camera_open as gz_camera_open,
)
from libgz.interfaces.camera import (
    gz_camera_post as gz_camera_post,
)
from libgz.interfaces.camera import (
    gz_camera_unlock as gz_camera_unlock,
)
from libgz.interfaces.client import Client as Client
from libgz.interfaces.factory import (
    GAZEBO_FACTORY_MAX_STRING as GAZEBO_FACTORY_MAX_STRING,
)
from libgz.interfaces.factory import (
    Factory as Factory,
)
from libgz.interfaces.factory import (
    FactoryData as FactoryData,
)
from libgz.interfaces.factory import (
    gz_factory_alloc as gz_factory_alloc,
)
from libgz.interfaces.factory import (
    gz_factory_close as gz_factory_close,
)
from libgz.interfaces.factory import (
    gz_factory_create as gz_factory_create,
)
from libgz.interfaces.factory import (
    gz_factory_destroy as gz_factory_destroy,
)
from libgz.interfaces.factory import (
    gz_factory_free as gz_factory_free,
)
from libgz.interfaces.factory import (
    gz_factory_lock as gz_factory_lock,
)
from libgz.interfaces.factory import (
    gz_factory_open as gz_factory_open,
)
from libgz.interfaces.factory import (
    gz_factory_unlock as gz_factory_unlock,
)
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
from libgz.interfaces.gps import (
    Gps as Gps,
)
from libgz.interfaces.gps import (
    GpsData as GpsData,
)
from libgz.interfaces.gps import (
    gz_gps_alloc as gz_gps_alloc,
)
from libgz.interfaces.gps import (
    gz_gps_close as gz_gps_close,
)
from libgz.interfaces.gps import (
    gz_gps_create as gz_gps_create,
)
from libgz.interfaces.gps import (
    gz_gps_destroy as gz_gps_destroy,
)
from libgz.interfaces.gps import (
    gz_gps_free as gz_gps_free,
)
from libgz.interfaces.gps import (
    gz_gps_lock as gz_gps_lock,
)
from libgz.interfaces.gps import (
    gz_gps_open as gz_gps_open,
)
from libgz.interfaces.gps import (
    gz_gps_post as gz_gps_post,
)
from libgz.interfaces.gps import (
    gz_gps_unlock as gz_gps_unlock,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_CMD_CLOSE as GAZEBO_GRIPPER_CMD_CLOSE,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_CMD_OPEN as GAZEBO_GRIPPER_CMD_OPEN,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_CMD_RETRIEVE as GAZEBO_GRIPPER_CMD_RETRIEVE,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_CMD_STOP as GAZEBO_GRIPPER_CMD_STOP,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_CMD_STORE as GAZEBO_GRIPPER_CMD_STORE,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_STATE_CLOSED as GAZEBO_GRIPPER_STATE_CLOSED,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_STATE_ERROR as GAZEBO_GRIPPER_STATE_ERROR,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_STATE_MOVING as GAZEBO_GRIPPER_STATE_MOVING,
)
from libgz.interfaces.gripper import (
    GAZEBO_GRIPPER_STATE_OPEN as GAZEBO_GRIPPER_STATE_OPEN,
)
from libgz.interfaces.gripper import (
    Gripper as Gripper,
)
from libgz.interfaces.gripper import (
    GripperData as GripperData,
)
from libgz.interfaces.gripper import (
    GripperDataCvs as GripperDataCvs,
)
from libgz.interfaces.gripper import (
    gz_gripper_alloc as gz_gripper_alloc,
)
from libgz.interfaces.gripper import (
    gz_gripper_close as gz_gripper_close,
)
from libgz.interfaces.gripper import (
    gz_gripper_create as gz_gripper_create,
)
from libgz.interfaces.gripper import (
    gz_gripper_destroy as gz_gripper_destroy,
)
from libgz.interfaces.gripper import (
    gz_gripper_free as gz_gripper_free,
)
from libgz.interfaces.gripper import (
    gz_gripper_lock as gz_gripper_lock,
)
from libgz.interfaces.gripper import (
    gz_gripper_open as gz_gripper_open,
)
from libgz.interfaces.gripper import (
    gz_gripper_unlock as gz_gripper_unlock,
)
from libgz.interfaces.guicam import (
    GAZEBO_GUICAM_MAX_IMAGE_SIZE as GAZEBO_GUICAM_MAX_IMAGE_SIZE,
)
from libgz.interfaces.guicam import (
    Guicam as Guicam,
)
from libgz.interfaces.guicam import (
    GuicamData as GuicamData,
)
from libgz.interfaces.guicam import (
    gz_guicam_alloc as gz_guicam_alloc,
)
from libgz.interfaces.guicam import (
    gz_guicam_close as gz_guicam_close,
)
from libgz.interfaces.guicam import (
    gz_guicam_create as gz_guicam_create,
)
from libgz.interfaces.guicam import (
    gz_guicam_destroy as gz_guicam_destroy,
)
from libgz.interfaces.guicam import (
    gz_guicam_free as gz_guicam_free,
)
from libgz.interfaces.guicam import (
    gz_guicam_lock as gz_guicam_lock,
)
from libgz.interfaces.guicam import (
    gz_guicam_open as gz_guicam_open,
)
from libgz.interfaces.guicam import (
    gz_guicam_post as gz_guicam_post,
)
from libgz.interfaces.guicam import (
    gz_guicam_unlock as gz_guicam_unlock,
)
from libgz.interfaces.ir import (
    GZ_IR_MAX_RANGES as GZ_IR_MAX_RANGES,
)
from libgz.interfaces.ir import (
    Ir as Ir,
)
from libgz.interfaces.ir import (
    IrData as IrData,
)
from libgz.interfaces.ir import (
    gz_ir_alloc as gz_ir_alloc,
)
from libgz.interfaces.ir import (
    gz_ir_close as gz_ir_close,
)
from libgz.interfaces.ir import (
    gz_ir_create as gz_ir_create,
)
from libgz.interfaces.ir import (
    gz_ir_destroy as gz_ir_destroy,
)
from libgz.interfaces.ir import (
    gz_ir_free as gz_ir_free,
)
from libgz.interfaces.ir import (
    gz_ir_lock as gz_ir_lock,
)
from libgz.interfaces.ir import (
    gz_ir_open as gz_ir_open,
)
from libgz.interfaces.ir import (
    gz_ir_unlock as gz_ir_unlock,
)
from libgz.interfaces.joint import (
    GAZEBO_JOINT_MAX_JOINTS as GAZEBO_JOINT_MAX_JOINTS,
)
from libgz.interfaces.joint import (
    JointData as JointData,
)
from libgz.interfaces.joint import (
    Joints as Joints,
)
from libgz.interfaces.joint import (
    JointsData as JointsData,
)
from libgz.interfaces.joint import (
    gz_joint_alloc as gz_joint_alloc,
)
from libgz.interfaces.joint import (
    gz_joint_close as gz_joint_close,
)
from libgz.interfaces.joint import (
    gz_joint_create as gz_joint_create,
)
from libgz.interfaces.joint import (
    gz_joint_destroy as gz_joint_destroy,
)
from libgz.interfaces.joint import (
    gz_joint_free as gz_joint_free,
)
from libgz.interfaces.joint import (
    gz_joint_lock as gz_joint_lock,
)
from libgz.interfaces.joint import (
    gz_joint_open as gz_joint_open,
)
from libgz.interfaces.joint import (
    gz_joint_post as gz_joint_post,
)
from libgz.interfaces.joint import (
    gz_joint_unlock as gz_joint_unlock,
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
from libgz.interfaces.stereo import (
    GAZEBO_STEREO_MAX_DISPARITY_SIZE as GAZEBO_STEREO_MAX_DISPARITY_SIZE,
)
from libgz.interfaces.stereo import (
    GAZEBO_STEREO_MAX_RGB_SIZE as GAZEBO_STEREO_MAX_RGB_SIZE,
)
from libgz.interfaces.stereo import (
    Stereo as Stereo,
)
from libgz.interfaces.stereo import (
    StereoData as StereoData,
)
from libgz.interfaces.stereo import (
    gz_stereo_alloc as gz_stereo_alloc,
)
from libgz.interfaces.stereo import (
    gz_stereo_close as gz_stereo_close,
)
from libgz.interfaces.stereo import (
    gz_stereo_create as gz_stereo_create,
)
from libgz.interfaces.stereo import (
    gz_stereo_destroy as gz_stereo_destroy,
)
from libgz.interfaces.stereo import (
    gz_stereo_free as gz_stereo_free,
)
from libgz.interfaces.stereo import (
    gz_stereo_lock as gz_stereo_lock,
)
from libgz.interfaces.stereo import (
    gz_stereo_open as gz_stereo_open,
)
from libgz.interfaces.stereo import (
    gz_stereo_post as gz_stereo_post,
)
from libgz.interfaces.stereo import (
    gz_stereo_unlock as gz_stereo_unlock,
)
from libgz.interfaces.truth import (
    Truth as Truth,
)
from libgz.interfaces.truth import (
    TruthData as TruthData,
)
from libgz.interfaces.truth import (
    gz_truth_alloc as gz_truth_alloc,
)
from libgz.interfaces.truth import (
    gz_truth_close as gz_truth_close,
)
from libgz.interfaces.truth import (
    gz_truth_create as gz_truth_create,
)
from libgz.interfaces.truth import (
    gz_truth_destroy as gz_truth_destroy,
)
from libgz.interfaces.truth import (
    gz_truth_euler_from_quatern as gz_truth_euler_from_quatern,
)
from libgz.interfaces.truth import (
    gz_truth_free as gz_truth_free,
)
from libgz.interfaces.truth import (
    gz_truth_lock as gz_truth_lock,
)
from libgz.interfaces.truth import (
    gz_truth_open as gz_truth_open,
)
from libgz.interfaces.truth import (
    gz_truth_post as gz_truth_post,
)
from libgz.interfaces.truth import (
    gz_truth_quatern_from_euler as gz_truth_quatern_from_euler,
)
from libgz.interfaces.truth import (
    gz_truth_unlock as gz_truth_unlock,
)
from libgz.interfaces.wifi import (
    GAZEBO_WIFI_MAX_LINKS as GAZEBO_WIFI_MAX_LINKS,
)
from libgz.interfaces.wifi import (
    GAZEBO_WIFI_QUAL_DBM as GAZEBO_WIFI_QUAL_DBM,
)
from libgz.interfaces.wifi import (
    Wifi as Wifi,
)
from libgz.interfaces.wifi import (
    WifiData as WifiData,
)
from libgz.interfaces.wifi import (
    WifiLink as WifiLink,
)
from libgz.interfaces.wifi import (
    gz_wifi_alloc as gz_wifi_alloc,
)
from libgz.interfaces.wifi import (
    gz_wifi_close as gz_wifi_close,
)
from libgz.interfaces.wifi import (
    gz_wifi_create as gz_wifi_create,
)
from libgz.interfaces.wifi import (
    gz_wifi_destroy as gz_wifi_destroy,
)
from libgz.interfaces.wifi import (
    gz_wifi_free as gz_wifi_free,
)
from libgz.interfaces.wifi import (
    gz_wifi_lock as gz_wifi_lock,
)
from libgz.interfaces.wifi import (
    gz_wifi_open as gz_wifi_open,
)
from libgz.interfaces.wifi import (
    gz_wifi_unlock as gz_wifi_unlock,
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
    DomeGeom as DomeGeom,
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
from libgz.physics.surfaces import (
    PointSetGeom as PointSetGeom,
)
from libgz.physics.surfaces import (
    RoadGeom as RoadGeom,
)
from libgz.physics.surfaces import (
    TerrainGeom as TerrainGeom,
)
from libgz.physics.two_axes import (
    Hinge2Joint as Hinge2Joint,
)
from libgz.physics.two_axes import (
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
from libgz.transport.layout import (
    GAZEBO_MAX_MODEL_TYPE as GAZEBO_MAX_MODEL_TYPE,
)
from libgz.transport.layout import (
    LIBGAZEBO_VERSION as LIBGAZEBO_VERSION,
)
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
from libgz.transport.semaphores import GZ_SEM_KEY as GZ_SEM_KEY
from libgz.worldfile.file import WorldFile as WorldFile
from libgz.worldfile.node import WorldFileNode as WorldFileNode
