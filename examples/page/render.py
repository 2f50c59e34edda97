#!/usr/bin/env python3
"""Renders a frame of a map into a numpy array, through the C interface: render.py LIBTILEMESH_C.so [MAP.ply]"""
import ctypes
import json
import sys

import numpy

chip = ctypes.CDLL(sys.argv[1])
chip.tilemesh_create.restype = ctypes.c_void_p
for name, result, arguments in [
    ("destroy", None, []),
    ("error", ctypes.c_char_p, []),
    ("load", ctypes.c_int, [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_size_t]),
    ("set", ctypes.c_int, [ctypes.c_char_p]),
    ("render", ctypes.c_int, [ctypes.POINTER(ctypes.c_double)]),
    ("pixels", ctypes.c_void_p, [ctypes.c_char_p]),
    ("report", ctypes.c_char_p, [ctypes.c_char_p]),
]:
    function = getattr(chip, "tilemesh_" + name)
    function.restype, function.argtypes = result, [ctypes.c_void_p, *arguments]

handle = chip.tilemesh_create()


def checked(result):
    if not result:
        sys.exit("render.py: " + chip.tilemesh_error(handle).decode())
    return result


if len(sys.argv) > 2:
    data = open(sys.argv[2], "rb").read()
    checked(chip.tilemesh_load(handle, sys.argv[2].encode(), data, len(data)))
checked(chip.tilemesh_set(handle, json.dumps({"width": 640, "height": 360}).encode()))
start = json.loads(checked(chip.tilemesh_report(handle, b"map")))["start"]
checked(chip.tilemesh_render(handle, (ctypes.c_double * 17)(*start)))
frame = json.loads(checked(chip.tilemesh_report(handle, b"frame")))
pixels = ctypes.cast(checked(chip.tilemesh_pixels(handle, b"rgb_float")), ctypes.POINTER(ctypes.c_float))
picture = numpy.ctypeslib.as_array(pixels, (frame["height"], frame["width"], 3)).copy()  # the handle owns the pixels
print(f"{picture.shape} mean {picture.mean():.6f}, {frame['supersteps']} supersteps, {frame['modelled_ms']:.4f} ms modelled")
chip.tilemesh_destroy(handle)
