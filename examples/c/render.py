#!/usr/bin/env python3
"""Renders a frame of a map into a numpy array, through the C interface: render.py LIBTILEMESH_C.so [MAP.ply [PICTURE.npy]]"""
import ctypes
import json
import os
import sys
import numpy

chip = ctypes.CDLL(sys.argv[1])
chip.tilemesh_create.restype = ctypes.c_void_p
chip.tilemesh_error.restype = chip.tilemesh_report.restype = ctypes.c_char_p
chip.tilemesh_pixels.restype = ctypes.POINTER(ctypes.c_float)
handle = ctypes.c_void_p(chip.tilemesh_create())


def ask(name, *arguments):
    result = getattr(chip, "tilemesh_" + name)(handle, *arguments)
    return result or sys.exit("render.py: " + chip.tilemesh_error(handle).decode(errors="replace"))


def shown(name):
    """A name as one line of text: its control characters, and its bytes that are no UTF-8, are '?'."""
    return "".join(c if c.isprintable() else "?" for c in name)


picture_file = sys.argv[3] if len(sys.argv) > 3 else None
if picture_file and os.path.exists(picture_file):
    for name in sys.argv[1:3]:
        if os.path.exists(name) and os.path.samefile(name, picture_file):
            sys.exit(f"render.py: cannot write the picture to {shown(picture_file)} (this run reads that file); name another file")
if len(sys.argv) > 2:
    try:
        with open(sys.argv[2], "rb") as file:
            data = file.read()
    except OSError as error:
        sys.exit(f"render.py: cannot read {shown(sys.argv[2])} ({error.strerror}); name a map")
    ask("load", os.fsencode(sys.argv[2]), data, ctypes.c_size_t(len(data)))
ask("set", json.dumps({"width": 640, "height": 360}).encode())
start = json.loads(ask("report", b"map"))["start"]
ask("render", (ctypes.c_double * 17)(*start))
frame = json.loads(ask("report", b"frame"))
picture = numpy.ctypeslib.as_array(ask("pixels", b"rgb_float"), (frame["height"], frame["width"], 3)).copy()  # the handle owns the pixels
print(f"{picture.shape} mean {picture.mean():.6f}, {frame['supersteps']} supersteps, {frame['modelled_ms']:.4f} ms modelled")
if picture_file:
    with open(picture_file, "wb") as file: # numpy.save would add .npy to another name
        numpy.save(file, picture)
