"""The interfaces through which programs read and command models, one module each.

Each module declares its struct once. The ctypes structure, the old functions (`gz_position_open` and so on), the numpy
views, the C header and the reference page are made from the declaration.
"""
