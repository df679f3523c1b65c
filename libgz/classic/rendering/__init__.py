"""Gazebo classic's `rendering` names: scene, visuals and cameras, as views on what is drawn."""

from libgz.classic.rendering.camera import Camera, draw_frame
from libgz.classic.rendering.depth_camera import DepthCamera
from libgz.classic.rendering.user_camera import UserCamera

__all__ = ["Camera", "CameraPtr", "DepthCamera", "DepthCameraPtr", "UserCamera", "UserCameraPtr", "draw_frame"]

CameraPtr, DepthCameraPtr, UserCameraPtr = Camera, DepthCamera, UserCamera
