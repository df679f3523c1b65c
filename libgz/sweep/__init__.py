"""Sweeps: a study runs a world many times, with other values of its elements, seeds and controllers."""
