"""Loaded worlds in the formats of other simulators."""
