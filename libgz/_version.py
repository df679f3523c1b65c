"""The version, in one place: setup.cfg and the commands read it from here."""

__version__ = "0.1.0"
