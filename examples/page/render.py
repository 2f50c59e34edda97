#!/usr/bin/env python3
"""Renders a frame of a map into a numpy array, through the C interface: render.py LIBTILEMESH_C.so [MAP.ply [PICTURE.npy]]"""
import ctypes
import json
import sys
import numpy

chip = ctypes.CDLL(sys.argv[1])
chip.tilemesh_create.restype = ctypes.c_void_p
chip.tilemesh_error.restype = chip.tilemesh_report.restype = ctypes.c_char_p
chip.tilemesh_pixels.restype = ctypes.POINTER(ctypes.c_float)
handle = ctypes.c_void_p(chip.tilemesh_create())


def ask(name, *arguments):
    result = getattr(chip, "tilemesh_" + name)(handle, *arguments)
    return result or sys.exit("render.py: " + chip.tilemesh_error(handle).decode())


if len(sys.argv) > 2:
    data = open(sys.argv[2], "rb").read()
    ask("load", sys.argv[2].encode(), data, ctypes.c_size_t(len(data)))
ask("set", json.dumps({"width": 640, "height": 360}).encode())
start = json.loads(ask("report", b"map"))["start"]
ask("render", (ctypes.c_double * 17)(*start))
frame = json.loads(ask("report", b"frame"))
picture = numpy.ctypeslib.as_array(ask("pixels", b"rgb_float"), (frame["height"], frame["width"], 3)).copy()  # the handle owns the pixels
print(f"{picture.shape} mean {picture.mean():.6f}, {frame['supersteps']} supersteps, {frame['modelled_ms']:.4f} ms modelled")
if len(sys.argv) > 3:
    numpy.save(sys.argv[3], picture)
