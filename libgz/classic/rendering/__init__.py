"""Gazebo classic's `rendering` names: scene, visuals, lights and cameras, as views on the engine's."""

from libgz.classic.api import without
from libgz.classic.rendering.camera import Camera, render_frame
from libgz.classic.rendering.depth_camera import DepthCamera
from libgz.classic.rendering.light import Light
from libgz.classic.rendering.lines import DynamicLines
from libgz.classic.rendering.scene import Scene, get_scene
from libgz.classic.rendering.user_camera import UserCamera
from libgz.classic.rendering.visual import Visual

__all__ = [
    "RENDERING_LINE_LIST",
    "RENDERING_LINE_STRIP",
    "RENDERING_POINT_LIST",
    "Camera",
    "CameraPtr",
    "DepthCamera",
    "DepthCameraPtr",
    "DynamicLines",
    "Light",
    "LightPtr",
    "Scene",
    "ScenePtr",
    "UserCamera",
    "UserCameraPtr",
    "Visual",
    "VisualPtr",
    "get_scene",
    "render_frame",
]

__getattr__ = without(__name__)

CameraPtr, DepthCameraPtr, UserCameraPtr = Camera, DepthCamera, UserCamera
LightPtr, ScenePtr, VisualPtr = Light, Scene, Visual
RENDERING_POINT_LIST = DynamicLines.POINT_LIST
RENDERING_LINE_LIST, RENDERING_LINE_STRIP = DynamicLines.LINE_LIST, DynamicLines.LINE_STRIP
