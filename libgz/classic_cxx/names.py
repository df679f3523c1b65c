"""Names of classic's headers beside those of the table: each includes the whole API, or says why it cannot."""

__all__ = ["ABSENT", "BASE_PLUGINS", "HEADERS", "IGNITION_MATH"]

# Plugins of Gazebo that plugins of users are derived from, by the header that has them; each has a header and a library
# of its name, too.
BASE_PLUGINS = {
    "sensor_plugins": (
        *("CameraPlugin", "ContactPlugin", "DepthCameraPlugin", "ForceTorquePlugin"),
        *("GpuRayPlugin", "ImuSensorPlugin", "RayPlugin", "SonarPlugin"),
    ),
    "model_plugins": ("ElevatorPlugin", "HarnessPlugin", "LinearBatteryPlugin", "WheelSlipPlugin"),
}

_FILES = {
    "gazebo": "Gazebo.hh Master.hh Server.hh gazebo_client.hh gazebo_config.h gazebo_core.hh",
    "gazebo/common": (
        "Assert.hh AudioDecoder.hh BVHLoader.hh Color.hh ColladaLoader.hh Dem.hh FuelModelDatabase.hh GTSMeshUtils.hh "
        "HeightmapData.hh ImageHeightmap.hh MeshCSG.hh MeshLoader.hh OBJLoader.hh STLLoader.hh SVGLoader.hh "
        "Video.hh VideoEncoder.hh common.hh "
    ),
    "gazebo/gui": (
        "Actions.hh Conversions.hh GLWidget.hh Gui.hh GuiEvents.hh GuiIface.hh GuiPlugin.hh GuiTypes.hh "
        "KeyEventHandler.hh MainWindow.hh MouseEventHandler.hh RenderWidget.hh gui.hh qt.h "
    ),
    "gazebo/math": (
        "Angle.hh Box.hh Helpers.hh MathTypes.hh Matrix3.hh Matrix4.hh Plane.hh Pose.hh "
        "Quaternion.hh Rand.hh RotationSpline.hh Spline.hh Vector2d.hh Vector2i.hh Vector3.hh "
        "Vector4.hh gzmath.hh "
    ),
    "gazebo/msgs": "MessageTypes.hh",
    "gazebo/physics": (
        "AdiabaticAtmosphere.hh AtmosphereFactory.hh BallJoint.hh FixedJoint.hh GearboxJoint.hh "
        "Hinge2Joint.hh HingeJoint.hh MapShape.hh PhysicsFactory.hh PhysicsIface.hh Population.hh Road.hh "
        "ScrewJoint.hh SliderJoint.hh UniversalJoint.hh UserCmdManager.hh physics.hh "
    ),
    "gazebo/physics/ode": (
        "ODEBallJoint.hh ODEBoxShape.hh ODECollision.hh ODECylinderShape.hh ODEFixedJoint.hh "
        "ODEGearboxJoint.hh ODEHeightmapShape.hh ODEHinge2Joint.hh ODEHingeJoint.hh ODEJoint.hh ODELink.hh "
        "ODEMesh.hh ODEMeshShape.hh ODEMultiRayShape.hh ODEPhysics.hh ODEPlaneShape.hh ODEPolylineShape.hh "
        "ODERayShape.hh ODEScrewJoint.hh ODESliderJoint.hh ODESphereShape.hh ODESurfaceParams.hh ODETypes.hh "
        "ODEUniversalJoint.hh ode_inc.h "
    ),
    "gazebo/rendering": (
        "ApplyWrenchVisual.hh CameraVisual.hh ContactVisual.hh Conversions.hh CustomPSSMShadowCameraSetup.hh "
        "DynamicRenderable.hh FPSViewController.hh GpuLaserDataIteratorImpl.hh Heightmap.hh InertiaVisual.hh "
        "LinkFrameVisual.hh LogicalCameraVisual.hh Material.hh MovableText.hh OrbitViewController.hh "
        "OriginVisual.hh OrthoViewController.hh RFIDTagVisual.hh RFIDVisual.hh RTShaderSystem.hh RayQuery.hh "
        "RenderEngine.hh Road2d.hh SelectionObj.hh TransmitterVisual.hh VideoVisual.hh ViewController.hh "
        "WireBox.hh WrenchVisual.hh ogre_gazebo.h rendering.hh "
    ),
    "gazebo/sdf": "sdf.hh",
    "gazebo/sensors": "SensorFactory.hh sensors.hh",
    "gazebo/transport": (
        "CallbackHelper.hh ConnectionManager.hh IOManager.hh Publication.hh PublicationTransport.hh "
        "SubscriptionTransport.hh transport.hh "
    ),
    "gazebo/util": "IntrospectionClient.hh IntrospectionManager.hh OpenAL.hh system.hh util.hh",
}
# Headers of ignition-math 2 to 4, which version 6 has, too.
IGNITION_MATH = (
    *("Angle", "Box", "Color", "Filter", "Frustum", "Helpers", "Inertial", "Kmeans", "Line2", "Line3", "MassMatrix3"),
    *("Matrix3", "Matrix4", "MovingWindowFilter", "OrientedBox", "PID", "Plane", "Pose3", "Quaternion", "Rand"),
    *("RotationSpline", "SemanticVersion", "SignalStats", "SphericalCoordinates", "Spline", "Temperature", "Triangle"),
    *("Triangle3", "Vector2", "Vector3", "Vector3Stats", "Vector4"),
)
HEADERS = tuple(f"{folder}/{name}" for folder, names in _FILES.items() for name in names.split())

_WINDOWS = (
    "AlignWidget ApplyWrenchDialog CloneWindow ConfigWidget DataLogger Editor EntityMaker InsertModelWidget "
    "JointControlWidget LayersWidget LightMaker LogPlayWidget ModelAlign ModelListWidget ModelMaker ModelManipulator "
    "ModelRightMenu ModelSnap SaveEntityDialog SpaceNav SplashScreen TimePanel TimeWidget ToolsWidget TopToolbar "
    "TopicSelector UserCmdHistory ViewAngleWidget"
)
_PLUGINS = (
    "ActorPlugin ActuatorPlugin AmbientOcclusionVisualPlugin ArduCopterPlugin ArrangePlugin AttachLightPlugin "
    "BlinkVisualPlugin BreakableJointPlugin BuoyancyPlugin CartDemoPlugin CessnaGUIPlugin CessnaPlugin "
    "ContainPlugin DiffDrivePlugin FiducialCameraPlugin FlashLightPlugin FollowerPlugin GimbalSmall2dPlugin "
    "GravityCompensationPlugin HeightmapLODPlugin HydraDemoPlugin HydraPlugin InitialVelocityPlugin "
    "JointControlPlugin JointTrajectoryPlugin JoyPlugin KeyboardGUIPlugin KeysToCmdVelPlugin KeysToJointsPlugin "
    "LedPlugin LensFlareSensorPlugin LiftDragPlugin LinearBatteryConsumerPlugin LinkPlot3DPlugin LookAtDemoPlugin "
    "MisalignmentPlugin ModelPropShop MudPlugin PlaneDemoPlugin PressurePlugin RandomVelocityPlugin "
    "RaySensorNoisePlugin ReflectancePlugin RestUiLoginDialog RestUiPlugin RestUiWidget RestWebPlugin "
    "RubblePlugin ShaderParamVisualPlugin SimpleTrackedVehiclePlugin SkidSteerDrivePlugin SphereAtlasDemoPlugin "
    "StaticMapPlugin StopWorldPlugin TimerGUIPlugin TouchPlugin TrackedVehiclePlugin TransporterPlugin "
    "VariableGearboxPlugin VehiclePlugin WheelTrackedVehiclePlugin WindPlugin"
)
_COPY_OF_ODE = (
    "collision collision_space collision_trimesh common compatibility contact error mass matrix memory misc "
    "objects ode odeconfig odecpp odecpp_collision odeinit odemath odemath_legacy rotation timer"
)
_ENGINE = (
    "BallJoint BoxShape Collision CylinderShape FixedJoint HeightmapShape Hinge2Joint HingeJoint Joint Link Mesh "
    "MeshShape Model MultiRayShape Physics PlaneShape PolylineShape RayShape ScrewJoint SliderJoint SphereShape "
    "SurfaceParams Types UniversalJoint"
)
# Headers of Gazebo 11 that a plugin cannot use here, by the reason; the compiler prints it.
ABSENT = {
    "it is of Gazebo's own window, which libgz does not have": (
        *(f"gazebo/gui/{name}.hh" for name in _WINDOWS.split()),
        *("gazebo/gui/model/ModelEditor.hh", "gazebo/gui/model/ModelEditorEvents.hh"),
        "gazebo/gui/viewers/ViewFactory.hh",
    ),
    "this plugin is written in Python here: derive from its source, which must be compiled, too": (
        *(f"gazebo/plugins/{name}.hh" for name in _PLUGINS.split()),
        "gazebo/plugins/events/RegionEventBoxPlugin.hh",
    ),
    "it belongs to the copy of ODE in Gazebo, whose objects libgz does not have": tuple(
        f"gazebo/ode/{name}.h" for name in _COPY_OF_ODE.split()
    ),
    "the engine is ODE": (
        *(f"gazebo/physics/bullet/Bullet{name}.hh" for name in _ENGINE.split() if name != "Model"),
        *(f"gazebo/physics/dart/DART{name}.hh" for name in _ENGINE.split() if name != "Types"),
        *(f"gazebo/physics/simbody/Simbody{name}.hh" for name in _ENGINE.split() if name != "SurfaceParams"),
        *(f"gazebo/physics/{name}/{name}_inc.h" for name in ("bullet", "dart", "simbody")),
    ),
    "nothing of libgz stands behind it": (
        *("gazebo/common/EnumIface.hh", "gazebo/common/Skeleton.hh", "gazebo/common/ffmpeg_inc.h"),
        *("gazebo/test/ServerFixture.hh", "gazebo/test/helper_physics_generator.hh", "gazebo/util/IgnMsgSdf.hh"),
    ),
}
