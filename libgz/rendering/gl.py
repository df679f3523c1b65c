"""The OpenGL functions that libgz calls: one line each, bound through the context that they belong to.

They are bound by ctypes and not by a GL package, whose one platform would be fixed for the life of the process: here
OSMesa and EGL can be tried in turn, and stand side by side. A call costs a quarter of a microsecond.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import POINTER, c_double, c_float, c_int, c_uint, c_void_p
from typing import Any

from libgz.errors import LibraryError

__all__ = ["GL", "Constant", "floats"]


class Constant:
    """Values of the GL headers, without the prefix GL_."""

    POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES = 0, 1, 2, 3, 4
    DEPTH_BUFFER_BIT, COLOR_BUFFER_BIT = 0x100, 0x4000
    LEQUAL, FRONT, BACK, FRONT_AND_BACK, CW, CCW = 0x0203, 0x0404, 0x0405, 0x0408, 0x0900, 0x0901
    SRC_ALPHA, ONE_MINUS_SRC_ALPHA = 0x0302, 0x0303
    CULL_FACE, LIGHTING, FOG, DEPTH_TEST, BLEND, DITHER = 0x0B44, 0x0B50, 0x0B60, 0x0B71, 0x0BE2, 0x0BD0
    LIGHT_MODEL_TWO_SIDE, LIGHT0 = 0x0B52, 0x4000
    AMBIENT, DIFFUSE, SPECULAR, POSITION, EMISSION, SHININESS = 0x1200, 0x1201, 0x1202, 0x1203, 0x1600, 0x1601
    CONSTANT_ATTENUATION, LINEAR_ATTENUATION, QUADRATIC_ATTENUATION = 0x1207, 0x1208, 0x1209
    SPOT_DIRECTION, SPOT_EXPONENT, SPOT_CUTOFF, LIGHT_MODEL_AMBIENT = 0x1204, 0x1205, 0x1206, 0x0B53
    FOG_DENSITY, FOG_START, FOG_END, FOG_MODE, FOG_COLOR = 0x0B62, 0x0B63, 0x0B64, 0x0B65, 0x0B66
    EXP, EXP2 = 0x0800, 0x0801
    MODELVIEW, PROJECTION, TEXTURE = 0x1700, 0x1701, 0x1702
    TEXTURE_2D, TEXTURE_ENV, TEXTURE_ENV_MODE, MODULATE, REPLACE = 0x0DE1, 0x2300, 0x2200, 0x2100, 0x1E01
    TEXTURE_MAG_FILTER, TEXTURE_MIN_FILTER, TEXTURE_WRAP_S, TEXTURE_WRAP_T = 0x2800, 0x2801, 0x2802, 0x2803
    LINEAR, NEAREST_MIPMAP_NEAREST, REPEAT, CLAMP_TO_EDGE = 0x2601, 0x2700, 0x2901, 0x812F
    GENERATE_MIPMAP = 0x8191
    RGB, RGBA, RGBA8, DEPTH_COMPONENT, DEPTH_COMPONENT24 = 0x1907, 0x1908, 0x8058, 0x1902, 0x81A6
    UNSIGNED_BYTE, UNSIGNED_INT, FLOAT, DOUBLE = 0x1401, 0x1405, 0x1406, 0x140A
    UNPACK_ALIGNMENT, PACK_ALIGNMENT = 0x0CF5, 0x0D05
    VERTEX_ARRAY, NORMAL_ARRAY, TEXTURE_COORD_ARRAY = 0x8074, 0x8075, 0x8078
    COMPILE, LINE, FILL, FLAT, SMOOTH = 0x1300, 0x1B01, 0x1B02, 0x1D00, 0x1D01
    FRAMEBUFFER, RENDERBUFFER, COLOR_ATTACHMENT0, DEPTH_ATTACHMENT = 0x8D40, 0x8D41, 0x8CE0, 0x8D00
    FRAMEBUFFER_COMPLETE, RENDERER, VERSION = 0x8CD5, 0x1F01, 0x1F02


_E, _I, _F, _P = c_uint, c_int, c_float, c_void_p

# Name -> result, arguments. Those that draw or wait let other Python threads run meanwhile.
_WAITING: dict[str, tuple[Any, ...]] = {
    "glReadPixels": (None, _I, _I, _I, _I, _E, _E, _P),
    "glFinish": (None,),
}
_QUICK: dict[str, tuple[Any, ...]] = {
    "glBegin": (None, _E),
    "glBindFramebuffer": (None, _E, c_uint),
    "glBindRenderbuffer": (None, _E, c_uint),
    "glBindTexture": (None, _E, c_uint),
    "glBlendFunc": (None, _E, _E),
    "glCallList": (None, c_uint),
    "glCheckFramebufferStatus": (c_uint, _E),
    "glClear": (None, c_uint),
    "glClearColor": (None, _F, _F, _F, _F),
    "glColor3f": (None, _F, _F, _F),
    "glColor3ub": (None, ctypes.c_ubyte, ctypes.c_ubyte, ctypes.c_ubyte),
    "glCullFace": (None, _E),
    "glDeleteFramebuffers": (None, _I, POINTER(c_uint)),
    "glDeleteLists": (None, c_uint, _I),
    "glDeleteRenderbuffers": (None, _I, POINTER(c_uint)),
    "glDeleteTextures": (None, _I, POINTER(c_uint)),
    "glDepthFunc": (None, _E),
    "glDepthMask": (None, ctypes.c_ubyte),
    "glDisable": (None, _E),
    "glDisableClientState": (None, _E),
    "glDrawArrays": (None, _E, _I, _I),
    "glDrawElements": (None, _E, _I, _E, _P),
    "glEnable": (None, _E),
    "glEnableClientState": (None, _E),
    "glEnd": (None,),
    "glEndList": (None,),
    "glFogf": (None, _E, _F),
    "glFogfv": (None, _E, POINTER(c_float)),
    "glFogi": (None, _E, _I),
    "glFramebufferRenderbuffer": (None, _E, _E, _E, c_uint),
    "glFrontFace": (None, _E),
    "glGenFramebuffers": (None, _I, POINTER(c_uint)),
    "glGenLists": (c_uint, _I),
    "glGenRenderbuffers": (None, _I, POINTER(c_uint)),
    "glGenTextures": (None, _I, POINTER(c_uint)),
    "glGetError": (c_uint,),
    "glGetString": (ctypes.c_char_p, _E),
    "glLightModelfv": (None, _E, POINTER(c_float)),
    "glLightModeli": (None, _E, _I),
    "glLightf": (None, _E, _E, _F),
    "glLightfv": (None, _E, _E, POINTER(c_float)),
    "glLineWidth": (None, _F),
    "glLoadIdentity": (None,),
    "glLoadMatrixd": (None, _P),
    "glMaterialf": (None, _E, _E, _F),
    "glMaterialfv": (None, _E, _E, POINTER(c_float)),
    "glMatrixMode": (None, _E),
    "glNewList": (None, c_uint, _E),
    "glNormalPointer": (None, _E, _I, _P),
    "glPixelStorei": (None, _E, _I),
    "glPointSize": (None, _F),
    "glPolygonMode": (None, _E, _E),
    "glRenderbufferStorage": (None, _E, _E, _I, _I),
    "glShadeModel": (None, _E),
    "glTexCoordPointer": (None, _I, _E, _I, _P),
    "glTexEnvi": (None, _E, _E, _I),
    "glTexImage2D": (None, _E, _I, _I, _I, _I, _I, _E, _E, _P),
    "glTexParameteri": (None, _E, _E, _I),
    "glTranslated": (None, c_double, c_double, c_double),
    "glVertex3d": (None, c_double, c_double, c_double),
    "glVertexPointer": (None, _I, _E, _I, _P),
    "glViewport": (None, _I, _I, _I, _I),
}


class GL:
    """All declared functions of one context, as attributes: ``gl.glClear(...)``.

    Args:
        address_of: the context's getProcAddress: a function's address, 0 or None if there is none.

    Raises:
        LibraryError: the context lacks a function.
    """

    def __init__(self, address_of: Callable[[bytes], int | None]) -> None:
        for table, kind in ((_WAITING, ctypes.CFUNCTYPE), (_QUICK, ctypes.PYFUNCTYPE)):
            for name, (result, *arguments) in table.items():
                address = address_of(name.encode())
                if not address:
                    raise LibraryError(f"this OpenGL has no function {name}")
                signature: Any = kind(result, *arguments)
                setattr(self, name, signature(address))

    def __getattr__(self, name: str) -> Callable[..., int]:
        raise AttributeError(f"{name} is not declared in {__name__}")

    def check(self) -> None:
        """Raise what GL has complained about since the last check.

        Raises:
            LibraryError: there is an error pending.
        """
        code = self.glGetError()
        if code:
            raise LibraryError(f"OpenGL reports error {code:#06x}")


def floats(*values: float) -> ctypes.Array[c_float]:
    """Values as the float array that GL's vector functions take."""
    return (c_float * len(values))(*values)
