#!/usr/bin/env python3
"""digests.py LIBTILEMESH_C.so: ten cameras of the built-in map and the digests of their frames, through the native C interface.

A line for each camera: the 17 numbers of tilemesh_render, the digest of the picture, the digest of the counters. The first camera is the map's
own, the next four turn by 0.5 degrees, the others by 7 degrees."""
import ctypes
import json
import math
import sys

chip = ctypes.CDLL(sys.argv[1])
chip.tilemesh_create.restype = ctypes.c_void_p
for name, result, arguments in [("set", ctypes.c_int, [ctypes.c_char_p]), ("render", ctypes.c_int, [ctypes.c_void_p]), ("report", ctypes.c_char_p, [ctypes.c_char_p])]:
    function = getattr(chip, "tilemesh_" + name)
    function.restype, function.argtypes = result, [ctypes.c_void_p, *arguments]
handle = chip.tilemesh_create()
the_map = json.loads(chip.tilemesh_report(handle, b"map"))
start, target = the_map["start"], the_map["target"]


def turned(degrees):
    """The start camera, turned about the vertical axis through the target."""
    s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    turn = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    camera = list(start)
    for i in range(3):
        camera[9 + i] = target[i] + sum(turn[i][j] * (start[9 + j] - target[j]) for j in range(3))
        for row in range(3):
            camera[3 * row + i] = sum(start[3 * row + j] * turn[i][j] for j in range(3))
    return camera


print("# 17 numbers of a camera, digest of the picture, digest of the counters")
for degrees in [0, 0.5, 1, 1.5, 2, 9, 16, 23, 30, 37]:
    camera = turned(degrees)
    assert chip.tilemesh_render(handle, (ctypes.c_double * 17)(*camera)) == 1
    digest = json.loads(chip.tilemesh_report(handle, b"digest"))
    print(*(f"{number:.17g}" for number in camera), digest["picture"], digest["counters"])
