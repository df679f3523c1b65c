"""Rigid bodies on ODE: bodies, geoms, joints, and the engine that steps them."""
