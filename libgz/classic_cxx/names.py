"""Names of classic's headers beside those of the table: each is there, and includes the whole API."""

__all__ = ["BASE_PLUGINS", "HEADERS"]

# Plugins of Gazebo that plugins of users are derived from, by the header that has them; each has a header and a library
# of its name, too.
BASE_PLUGINS = {
    "sensor_plugins": ("CameraPlugin", "DepthCameraPlugin", "GpuRayPlugin", "RayPlugin"),
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
        "Gui.hh GuiEvents.hh GuiIface.hh GuiPlugin.hh GuiTypes.hh KeyEventHandler.hh MouseEventHandler.hh gui.hh "
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
HEADERS = tuple(f"{folder}/{name}" for folder, names in _FILES.items() for name in names.split())
