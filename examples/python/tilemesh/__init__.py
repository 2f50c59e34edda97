"""3D Gaussian maps rendered on a mesh of small tiles.

    import tilemesh
    with tilemesh.Renderer("room.ply", width=640, height=360, depth=True) as renderer:
        frame = renderer.render(renderer.start)
    print(frame.colour.shape, frame.depth.max(), frame.report["map"]["gaussians"])

The package calls the C interface, libtilemesh_c.so, through ctypes. It needs Python 3.9 or later, and nothing else. With numpy, pictures are numpy
arrays; without it they are memoryviews of the same shape. Both own their memory: they stay valid whatever happens to the renderer.

Axes: x right, y down, z forward, as in OpenCV. Pictures have their first row at the top; colours are linear, 0 to 1, as composited.
"""
from __future__ import annotations

import csv as _csv
import ctypes
import json
import os
import shutil
import subprocess
import threading
import weakref
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Iterable, Mapping, Sequence, Union

try:
    import numpy
except ImportError:  # pictures are memoryviews then
    numpy = None  # type: ignore[assignment]

__all__ = ["Camera", "Error", "Frame", "Renderer", "TrackedFrame", "explore", "front", "read_points"]

Picture = Any  # numpy.ndarray of float32, or a memoryview of floats
Text = Union[str, "os.PathLike[str]"]


class Error(Exception):
    """What went wrong, in one line: "<problem> (<why>); <what to do>". `code` is a number of tilemesh_status in tilemesh.h; None: the error
    is of this package."""

    def __init__(self, text: str, code: int | None = None) -> None:
        super().__init__(text)
        self.code = code


@dataclass(frozen=True)
class Camera:
    """A pinhole camera. `rotation` has the rows of the rotation from world to camera, `position` is the camera's centre in the coordinates
    of the map's file; `fx`, `fy`, `cx`, `cy` are in pixels, and the centre of the first pixel is at (0.5, 0.5)."""

    rotation: tuple[float, ...]  # 9 numbers, row by row
    position: tuple[float, float, float]
    fx: float
    fy: float
    cx: float
    cy: float
    near: float = 0.2

    @classmethod
    def of(cls, numbers: Iterable[float]) -> Camera:
        """From the 17 numbers of the C interface."""
        n = [float(v) for v in numbers]
        if len(n) != 17:
            raise Error(f"a camera of {len(n)} numbers (it has 17: rotation, position, fx, fy, cx, cy, near); give all of them")
        return cls(tuple(n[:9]), (n[9], n[10], n[11]), *n[12:])

    @property
    def numbers(self) -> list[float]:
        return [*self.rotation, *self.position, self.fx, self.fy, self.cx, self.cy, self.near]

    def moved(self, right: float = 0.0, down: float = 0.0, forward: float = 0.0) -> Camera:
        """The camera after steps along its own axes, in units of the map."""
        step = [sum(by * self.rotation[3 * row + axis] for row, by in enumerate((right, down, forward))) for axis in range(3)]
        return replace(self, position=tuple(p + s for p, s in zip(self.position, step)))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Frame:
    """A rendered frame. `colour` has the shape (height, width, 3); `depth` and `alpha` have (height, width), or are None without the
    setting. `summary` has the numbers of the frame ("frame" in tilemesh.h), `report` is report.json of render_map."""

    colour: Picture
    depth: Picture | None
    alpha: Picture | None
    summary: dict[str, Any] = field(repr=False)
    report: dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class TrackedFrame:
    """A frame that was tracked. `verdict` is "converged", "weak" or "lost"; the camera of a lost frame is a prediction, and `why` says why.
    `facts` has all members of "track" in tilemesh.h."""

    camera: Camera
    verdict: str
    why: str
    facts: dict[str, Any] = field(repr=False)


_VERSION = 2
_library: ctypes.CDLL | None = None
_library_lock = threading.Lock()


def _load_library() -> ctypes.CDLL:
    """The library beside this file, or the one that TILEMESH_LIBRARY names."""
    global _library
    with _library_lock:
        if _library is not None:
            return _library
        path = os.environ.get("TILEMESH_LIBRARY") or str(Path(__file__).with_name("libtilemesh_c.so"))
        try:
            library = ctypes.CDLL(path)
            library.tilemesh_version.restype = ctypes.c_int
            version = library.tilemesh_version()
        except (OSError, AttributeError) as error:
            raise Error(f"cannot load {path} ({error}); build it with cmake --workflow --preset python, or name it in TILEMESH_LIBRARY") from None
        if version < _VERSION:
            raise Error(f"{path} has version {version} of the C interface (this package needs {_VERSION}); build both from the same sources")
        handle, text, number = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int
        for name, result, arguments in [
            ("create", handle, []), ("destroy", None, [handle]), ("error", text, [handle]), ("error_code", number, [handle]),
            ("load_file", number, [handle, text]), ("load", number, [handle, text, text, ctypes.c_size_t]), ("set", number, [handle, text]),
            ("render", number, [handle, handle]), ("pixels", handle, [handle, text]), ("report", text, [handle, text]),
            ("track_begin", number, [handle, handle, number]),
            ("track", number, [handle, handle, handle, ctypes.c_size_t, ctypes.c_double, handle]),
        ]:
            function = getattr(library, "tilemesh_" + name)
            function.restype, function.argtypes = result, arguments
        _library = library
        return library


class Renderer:
    """A map on a machine, and the settings of both. `map` is a file, or None for the built-in map; settings are those of `set`.

    Threads: calls on one renderer wait for each other, and run without Python's global lock. Renderers share nothing.
    """

    def __init__(self, map: Text | None = None, **settings: Any) -> None:
        self._c = _load_library()
        self._lock = threading.Lock()
        handle = self._c.tilemesh_create()
        if not handle:
            raise Error("no renderer (memory is short); free some", 2)
        self._handle: int | None = handle
        self._free = weakref.finalize(self, self._c.tilemesh_destroy, handle)
        self._track_size: tuple[int, int] | None = None
        try:
            self.set(**{"program": "auto", "threads": min(os.cpu_count() or 1, 256), **settings})
            if map is not None:
                self.load(map)
        except BaseException:
            self.close()
            raise

    # --- what a renderer is

    def load(self, map: Text | None) -> None:
        """Another map: PLY, compressed PLY, .splat, SPZ or SOG; None: the built-in one. An error leaves the old map."""
        with self._lock:
            if map is None:
                self._call("load", None, None, 0)
            else:
                path = os.fsencode(map)
                if b"\0" in path:
                    raise Error("a map whose name has a zero byte (no file has such a name); name a file")
                self._call("load_file", path)
            self._track_size = None

    def set(self, **settings: Any) -> None:
        """Changes settings: width, height, quality, program, depth, alpha, threads, preset, machine, slots ... (tilemesh.h lists all). An
        error changes none. The next frame uses them."""
        try:
            text = json.dumps(settings, allow_nan=False)
        except (TypeError, ValueError) as error:
            raise Error(f"settings that are no JSON ({error}); give numbers, texts, true or false") from None
        with self._lock:
            self._call("set", text.encode())

    @property
    def settings(self) -> dict[str, Any]:
        """All settings, with "limits" and "choices"."""
        return self._report("settings")

    @property
    def map(self) -> dict[str, Any]:
        """The map: "name", "gaussians", "rejected", "sh_degree", "notes", "target" ..."""
        return self._report("map")

    @property
    def start(self) -> Camera:
        """A camera that shows the map, for the settings' width and height."""
        return Camera.of(self.map["start"])

    @property
    def build(self) -> dict[str, Any]:
        """The library: "formats" of maps, "fused" ..."""
        return self._report("build")

    # --- what it does

    def render(self, camera: Camera | Iterable[float] | None = None) -> Frame:
        """Renders a frame; None: from `start`. Records begin on the tiles where the last frame left them."""
        numbers = _numbers(self.start if camera is None else camera)
        with self._lock:
            self._call("render", numbers)
            summary = self._json("frame")
            size = summary["height"], summary["width"]
            planes = {what: self._copy(what, size) if self._wanted(what) else None for what in ("depth", "alpha")}
            return Frame(self._copy("rgb_float", (*size, 3)), planes["depth"], planes["alpha"], summary, self._json("run"))

    def track_begin(self, camera: Camera | Iterable[float], depth: bool = False) -> None:
        """Begins to track with the settings' width and height: `camera` is the guess for the first picture. `depth`: pictures have one."""
        numbers = _numbers(camera)
        with self._lock:
            self._call("track_begin", numbers, 1 if depth else 0)
            settings = self._json("settings")
            self._track_size = settings["height"], settings["width"]

    def track(self, colour: Picture, depth: Picture | None = None, seconds: float = 0.0) -> TrackedFrame:
        """Finds the camera of the next picture: `colour` of the shape (height, width, 3), linear, 0 to 1; `depth` of (height, width)."""
        with self._lock:
            size = self._track_size or (0, 0)
            rgb, rgb_at = _floats(colour, (*size, 3), "picture", self._track_size is not None)
            deep, deep_at = (None, None) if depth is None else _floats(depth, size, "depth", self._track_size is not None)
            self._call("track", rgb_at, deep_at, size[0] * size[1], float(seconds), None)
            del rgb, deep  # not before: they own what the call read
            facts = self._json("track")
        return TrackedFrame(Camera.of(facts["camera"]), facts["verdict"], facts["why"], facts)

    def close(self) -> None:
        """Frees the renderer. Pictures of it stay valid."""
        with self._lock:
            self._handle = None
            self._free()

    def __enter__(self) -> Renderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- with the lock held

    def _call(self, name: str, *arguments: Any) -> Any:
        if self._handle is None:
            raise Error("a renderer after close() (its memory is freed); make another one")
        result = getattr(self._c, "tilemesh_" + name)(self._handle, *arguments)
        if not result:
            raise Error(self._c.tilemesh_error(self._handle).decode(errors="replace"), self._c.tilemesh_error_code(self._handle))
        return result

    def _json(self, what: str) -> dict[str, Any]:
        return json.loads(self._call("report", what.encode()))

    def _wanted(self, what: str) -> bool:
        return bool(self._json("settings")[what])

    def _copy(self, what: str, shape: Sequence[int]) -> Picture:
        """Floats of the last frame, copied: the handle owns its own until the next call."""
        at = self._call("pixels", what.encode())
        count = 1
        for side in shape:
            count *= side
        if numpy is not None:
            picture = numpy.empty(shape, numpy.float32)
            ctypes.memmove(picture.ctypes.data, at, 4 * count)
            return picture
        return memoryview(bytearray(ctypes.string_at(at, 4 * count))).cast("f", list(shape))

    def _report(self, what: str) -> dict[str, Any]:
        with self._lock:
            return self._json(what)


def _numbers(camera: Camera | Iterable[float]) -> Any:
    try:
        return (ctypes.c_double * 17)(*(camera if isinstance(camera, Camera) else Camera.of(camera)).numbers)
    except (TypeError, ValueError, OverflowError) as error:
        raise Error(f"a camera that is no 17 numbers ({error}); give a tilemesh.Camera") from None


def _floats(picture: Picture, shape: Sequence[int], what: str, known: bool) -> tuple[Any, int]:
    """A picture as floats in memory, row by row, and their address. The first result owns them."""
    if numpy is not None:
        try:
            array = numpy.ascontiguousarray(picture, numpy.float32)
        except (TypeError, ValueError) as error:
            raise Error(f"a {what} that is no array of numbers ({error}); give an array of float32") from None
        if known and array.shape != tuple(shape):
            raise Error(f"a {what} of the shape {array.shape} (the tracker began with {tuple(shape)}); give that, or begin again")
        return array, array.ctypes.data
    try:
        view = memoryview(picture)
        if view.format != "f" or known and view.shape != tuple(shape):
            raise Error(f"a {what} of the shape {view.shape} and format {view.format} (the tracker began with {tuple(shape)} of f); give that")
        floats = (ctypes.c_float * (view.nbytes // 4)).from_buffer_copy(view.tobytes())
    except TypeError as error:
        raise Error(f"a {what} that is no buffer of floats ({error}); install numpy, or give a memoryview") from None
    return floats, ctypes.addressof(floats)


# --- studies


def explore(study: Text | Mapping[str, Any], out: Text, *, program: Text | None = None, arguments: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Runs a study (a dict, or a file of JSON) with the program `explore`, which writes its page and pictures into the folder `out`. Returns
    the points of `out`/points.csv. The program is `program`, the one beside the package, the one that the build has in its folder examples,
    or the one in PATH."""
    out = Path(out)
    here = Path(__file__).resolve().parent
    places = [Path(program)] if program is not None else [here / "explore", here.parent.parent / "examples" / "explore"]
    found = next((str(p) for p in places if p.is_file() and os.access(p, os.X_OK)), None)
    if found is None and program is None:
        found = shutil.which("explore")
    if found is None:
        raise Error(f"no program explore (there is none at {places[-1]}); build it: cmake --build build/demo --target explore")
    try:
        out.mkdir(parents=True, exist_ok=True)
        if isinstance(study, Mapping):
            text = json.dumps(study, allow_nan=False, indent=1)
            study = out / "study.json"
            study.write_text(text + "\n", encoding="utf-8")
    except (OSError, TypeError, ValueError) as error:
        raise Error(f"cannot write the study to {out} ({error}); name another folder, or give numbers, texts and lists") from None
    points = out / "points.csv"
    try:
        run = subprocess.run([found, os.fspath(study), "--csv", os.fspath(points), "--out", os.fspath(out), *arguments],
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    except OSError as error:
        raise Error(f"cannot run {found} ({error.strerror}); build it again") from None
    if run.returncode != 0:
        lines = run.stderr.decode(errors="replace").strip().splitlines()
        raise Error(lines[-1] if lines else f"{found} ended with status {run.returncode} (it printed no error); run it by hand")
    return read_points(points)


def read_points(csv: Text) -> list[dict[str, Any]]:
    """The points of a study's CSV file: a dict for each line, by the names of the first line. A text that is a number becomes one; an empty
    one becomes None."""
    def value(text: str) -> Any:
        for kind in (int, float):
            try:
                return kind(text)
            except ValueError:
                pass
        return text if text else None

    try:
        with open(csv, newline="", encoding="utf-8") as file:
            rows = list(_csv.reader(line for line in file if not line.startswith("#")))
    except (OSError, ValueError, _csv.Error) as error:
        raise Error(f"cannot read the points of {os.fspath(csv)} ({error}); name the CSV file of a study") from None
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise Error(f"{os.fspath(csv)} is no table of points (lines have different numbers of columns, or there is none); write it again")
    return [dict(zip(rows[0], map(value, row))) for row in rows[1:]]


def front(points: Iterable[Mapping[str, Any]], *columns: str) -> list[dict[str, Any]]:
    """The Pareto front of some columns: the points of which no other is at least as good in all columns and better in one. Less is better;
    with a minus before its name ("-psnr_db"), more is better. Points without a number in a column are left out. Sorted by the first
    column."""
    if not columns:
        raise Error("a front of no columns (it compares points by their columns); name at least one")
    points = [dict(p) for p in points]
    signs = {name.removeprefix("-"): -1 if name.startswith("-") else 1 for name in columns}
    for name in signs:
        if points and not any(name in p for p in points):
            raise Error(f"no column {name} (the points have {', '.join(map(str, points[0]))}); name one of these")

    def numbers(point: Mapping[str, Any]) -> tuple[float, ...]:
        return tuple(sign * point[c] for c, sign in signs.items())

    whole = [p for p in points if all(isinstance(p.get(c), (int, float)) and p[c] == p[c] for c in signs)]
    best = [p for p in whole
            if not any(all(a <= b for a, b in zip(numbers(q), numbers(p))) and numbers(q) != numbers(p) for q in whole)]
    return sorted(best, key=numbers)
