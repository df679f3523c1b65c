"""What Gazebo throws is what libgz raises."""

from libgz.base.errors import GazeboError

__all__ = ["AssertionInternalError", "InternalError"]

AssertionInternalError = InternalError = GazeboError
