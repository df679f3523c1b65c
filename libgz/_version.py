"""The version of libgz."""

__version__ = "0.1.0"
