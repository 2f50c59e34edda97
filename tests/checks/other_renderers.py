#!/usr/bin/env python3
"""Two renderers as other people write them, for the scenes of render_map --judge-scenes. Each has one fault that a judge must name.

usage: other_renderers.py exact|half|sort16 FOLDER NAME OUT.pfm

exact: in double. half: opacity, colour, alpha, transmittance and sums in float16. sort16: order by 16 bits of depth from 0 to 20, then by row."""
import json
import sys

import numpy as np


def read_ply(path):
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    lines = data[:end].decode().split("\n")
    names = [line.split()[2] for line in lines if line.startswith("property float")]
    rows = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    table = np.frombuffer(data[end:], "<f4").reshape(rows, len(names)).astype(np.float64)
    return lambda *of: np.stack([table[:, names.index(name)] for name in of], 1), names


def colours(column, names, direction):
    sh = 0.28209479177387814
    out = 0.5 + sh * column("f_dc_0", "f_dc_1", "f_dc_2")
    rest = [n for n in names if n.startswith("f_rest_")]
    if not rest:
        return np.maximum(out, 0)
    x, y, z = direction.T
    basis = [-0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x,
             1.0925484305920792 * x * y, -1.0925484305920792 * y * z, 0.31539156525252005 * (2 * z * z - x * x - y * y),
             -1.0925484305920792 * x * z, 0.5462742152960396 * (x * x - y * y),
             -0.5900435899266435 * y * (3 * x * x - y * y), 2.890611442640554 * x * y * z, -0.4570457994644658 * y * (4 * z * z - x * x - y * y),
             0.3731763325901154 * z * (2 * z * z - 3 * x * x - 3 * y * y), -0.4570457994644658 * x * (4 * z * z - x * x - y * y),
             1.445305721320277 * z * (x * x - y * y), -0.5900435899266435 * x * (x * x - 3 * y * y)]
    each = len(rest) // 3
    for c in range(3):
        values = column(*[f"f_rest_{c * each + k}" for k in range(each)])
        out[:, c] += sum(values[:, k] * basis[k] for k in range(each))
    return np.maximum(out, 0)


def main(way, folder, name, out):
    rules = json.load(open(f"{folder}/scenes.json"))["rules"]
    camera = json.load(open(f"{folder}/{name}.json"))["cameras"][0]
    column, names = read_ply(f"{folder}/{name}.ply")
    pose = np.array(camera["world_to_camera"])
    w, t = pose[:3, :3], pose[:3, 3]
    fx, fy, cx, cy, width, height = (camera[k] for k in ("fx", "fy", "cx", "cy", "width", "height"))
    means = column("x", "y", "z")
    view = means @ w.T + t
    direction = means - (-w.T @ t)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    colour = colours(column, names, direction)
    opacity = 1 / (1 + np.exp(-column("opacity")[:, 0]))
    scale = np.exp(column("scale_0", "scale_1", "scale_2"))
    q = column("rot_0", "rot_1", "rot_2", "rot_3")
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    number = np.float16 if way == "half" else np.float64
    depth = np.floor(view[:, 2] / 20 * 65535) if way == "sort16" else view[:, 2]
    ys, xs = np.mgrid[0:height, 0:width] + 0.5
    picture, through = np.zeros((height, width, 3), number), np.ones((height, width), number)
    going = np.ones((height, width), bool)
    for i in np.lexsort((np.arange(len(depth)), depth)):
        x, y, z = view[i]
        if z <= np.float32(rules["near"]):
            continue
        a, b, c, d = q[i]
        r = np.array([[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
                      [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
                      [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]])
        lx, ly = (rules["slope_limit"] * max(m, s - m) / f for m, s, f in ((cx, width, fx), (cy, height, fy)))
        sx, sy = min(lx, max(-lx, x / z)), min(ly, max(-ly, y / z))
        v = np.array([[fx / z, 0, -fx * sx / z], [0, fy / z, -fy * sy / z]]) @ w @ r @ np.diag(scale[i])
        cov = v @ v.T + rules["dilation"] * np.eye(2)
        det = np.sum(np.cross(v[0], v[1]) ** 2) + rules["dilation"] * np.sum(v * v) + rules["dilation"] ** 2
        dx, dy = xs - (fx * x / z + cx), ys - (fy * y / z + cy)
        power = -0.5 * (cov[1, 1] * dx * dx - 2 * cov[0, 1] * dx * dy + cov[0, 0] * dy * dy) / det
        alpha = (number(opacity[i]) * np.exp(power).astype(number)).astype(number)
        seen = going & (alpha >= number(rules["alpha_min"]))
        alpha = np.where(seen, np.minimum(alpha, number(rules["alpha_max"])), number(0))
        weight = alpha * through
        picture += (weight[..., None] * colour[i].astype(number)).astype(number)
        through = (through * (number(1) - alpha)).astype(number)
        going &= ~(seen & (through < number(rules["transmittance_min"])))
    picture = picture.astype(np.float64) + through[..., None] * np.array(rules["background"])
    with open(out, "wb") as file:
        file.write(f"PF\n{width} {height}\n-1.0\n".encode() + picture[::-1].astype("<f4").tobytes())


if __name__ == "__main__":
    if len(sys.argv) != 5 or sys.argv[1] not in ("exact", "half", "sort16"):
        sys.exit(__doc__)
    main(*sys.argv[1:])
