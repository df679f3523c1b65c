"""Sensors that models build on."""
