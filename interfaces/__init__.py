"""The interfaces through which programs read and command models, one module each.

Each module declares its struct once. From the declaration come the ctypes structure, the old functions
(`gz_position_open` and so on), and the numpy views.
"""
