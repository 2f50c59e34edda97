"""3D Gaussian maps rendered on a mesh of small tiles.

    import tilemesh
    with tilemesh.Renderer("room.ply", width=640, height=360, depth=True) as renderer:
        frame = renderer.render(renderer.start)
    print(frame.colour.shape, frame.depth.max(), frame.report["map"]["gaussians"])

The package calls the C interface, libtilemesh_c.so, through ctypes. It needs Python 3.9 or later, and nothing else. With numpy, pictures are numpy
arrays; without it they are memoryviews of the same shape. Both own their memory: they stay valid whatever happens to the renderer.

Axes: x right, y down, z forward, as in OpenCV. Pictures have their first row at the top; colours are linear, 0 to 1, as composited.

Every failure is an Error, also an argument of a wrong type. A child of fork may use the renderers of its parent. At the end of the interpreter,
calls of other threads come to their end, and none begins.
"""
from __future__ import annotations

import atexit
import csv as _csv
import ctypes
import functools
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import threading
import weakref
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, Sequence, TypeVar, Union

try:
    import numpy
except ImportError:  # pictures are memoryviews then
    numpy = None  # type: ignore[assignment]

__all__ = ["Camera", "Error", "Frame", "Renderer", "TrackedFrame", "explore", "front", "read_cameras", "read_points"]

Picture = Any  # numpy.ndarray of float32, or a memoryview of floats
Text = Union[str, "os.PathLike[str]"]
Numbers = Any  # an iterable of numbers or of such iterables, as lists and numpy arrays are
Function = TypeVar("Function", bound=Callable[..., Any])


class Error(Exception):
    """What went wrong, in one line: "<problem> (<why>); <what to do>". `code` is a number of tilemesh_status in tilemesh.h; None: the error
    is of this package."""

    def __init__(self, text: str, code: int | None = None) -> None:
        super().__init__(text)
        self.code = code


def _door(function: Function) -> Function:
    """What Python says of an argument that does not fit becomes an Error, which names the function."""
    @functools.wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except (ArithmeticError, AttributeError, RecursionError, TypeError, ValueError) as error:
            raise Error(f"{function.__qualname__.split('.__')[0]} with an argument that does not fit ({error}); correct it") from None
    return call  # type: ignore[return-value]


def _flat(numbers: Numbers) -> Iterator[float]:
    numbers = numbers.tolist() if hasattr(numbers, "tolist") else numbers
    if isinstance(numbers, (str, bytes)):
        raise TypeError(f"a text in place of numbers: {numbers[:40]!r}")
    if isinstance(numbers, Iterable):
        for each in numbers:
            yield from _flat(each)
    else:
        yield float(numbers)


def _json_text(value: Any) -> str:
    """As JSON, with numbers and arrays of numpy, and paths."""
    def plain(other: Any) -> Any:
        return other.tolist() if hasattr(other, "tolist") else os.fspath(other)
    return json.dumps(value, allow_nan=False, default=plain, indent=1)


@dataclass(frozen=True)
class Camera:
    """A camera. `rotation` has the rows of the rotation from world to camera, as 3 x 3 or 9 numbers; `position` is the camera's centre
    in the coordinates of the map's file; `fx`, `fy`, `cx`, `cy` are in pixels, and the centre of the first pixel is at (0.5, 0.5). `near` is in
    units of the map. `size`, if it is known, is the (width, height) for which the lens is; a renderer of another size refuses the camera.
    `lens` says how the lens bends the picture, as the setting `lens` does ("pinhole", "opencv,0.26,-0.95", "fisheye"); None: as the setting."""

    rotation: tuple[float, ...]  # 9 numbers, row by row
    position: tuple[float, ...]  # 3 numbers
    fx: float
    fy: float
    cx: float
    cy: float
    near: float = 0.2
    size: tuple[int, ...] | None = None  # width and height
    lens: str | None = None

    @_door
    def __post_init__(self) -> None:
        """All members become plain numbers, so that cameras can be compared and hashed."""
        for name, count in [("rotation", 9), ("position", 3), ("fx", 1), ("fy", 1), ("cx", 1), ("cy", 1), ("near", 1), ("size", 2)]:
            value = getattr(self, name)
            if value is None and name == "size":
                continue
            numbers = tuple(_flat(value))
            if len(numbers) != count:
                raise Error(f"a camera with {len(numbers)} numbers for {name} (it has {count}); give {'3 x 3 or 9' if count == 9 else count}")
            object.__setattr__(self, name, tuple(map(int, numbers)) if name == "size" else numbers if count > 1 else numbers[0])

    @classmethod
    @_door
    def of(cls, numbers: Numbers) -> Camera:
        """From the 17 numbers of the C interface: 0 to 8 the rotation, row by row, 9 to 11 the position, 12 to 15 fx, fy, cx, cy, 16 near."""
        n = tuple(_flat(numbers))
        if len(n) != 17:
            raise Error(f"a camera of {len(n)} numbers (it has 17: rotation, position, fx, fy, cx, cy, near); give all of them, or use "
                        "Camera.from_matrix")
        return cls(n[:9], n[9:12], *n[12:])

    @classmethod
    @_door
    def from_matrix(cls, matrix: Numbers, fx: float, fy: float, cx: float, cy: float, near: float = 0.2, *, camera_to_world: bool = False,
                    size: Sequence[int] | None = None) -> Camera:
        """From a pose of 4 x 4 or 3 x 4 numbers, row by row: world to camera, as OpenCV and COLMAP write it, or camera to world. The camera
        looks along its z axis, y is down."""
        m = tuple(_flat(matrix))
        if len(m) not in (12, 16) or len(m) == 16 and sum(abs(a - b) for a, b in zip(m[12:], (0, 0, 0, 1))) > 1e-6:
            raise Error(f"a matrix of {len(m)} numbers (a pose has 3 x 4, or 4 x 4 of which the last row is 0 0 0 1); give one of these")
        rows, t = (m[0:3], m[4:7], m[8:11]), (m[3], m[7], m[11])
        columns = tuple(zip(*rows))
        if camera_to_world:
            return cls(columns, t, fx, fy, cx, cy, near, size)
        return cls(rows, [-sum(a * b for a, b in zip(column, t)) for column in columns], fx, fy, cx, cy, near, size)

    @classmethod
    def from_file(cls, file: Text, name: str | None = None) -> Camera:
        """A camera of a file or COLMAP folder that `read_cameras` reads. `name` may be left out if there is one camera."""
        cameras = read_cameras(file)
        if name is None and len(cameras) == 1:
            return next(iter(cameras.values()))
        if name not in cameras:
            shown = ", ".join(list(cameras)[:20]) + (" ..." if len(cameras) > 20 else "")
            raise Error(f"{'no name of a camera' if name is None else f'no camera {name!r}'} ({os.fspath(file)} has {shown or 'none'}); name one")
        return cameras[name]

    @property
    def numbers(self) -> list[float]:
        return [*self.rotation, *self.position, self.fx, self.fy, self.cx, self.cy, self.near]

    @_door
    def resized(self, width: int, height: int) -> Camera:
        """The same view in another size, as render_map's --size: the horizontal field of view stays. Needs `size`."""
        if self.size is None:
            raise Error("a camera whose size is not known (its lens is in pixels of it); give size = (width, height)")
        by = width / self.size[0]
        return replace(self, fx=self.fx * by, fy=self.fy * by, cx=self.cx * by, cy=self.cy * height / self.size[1], size=(width, height))

    @_door
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


_VERSION = 5
_library: ctypes.CDLL | None = None
_library_lock = threading.RLock()
_renderers: weakref.WeakSet[Renderer] = weakref.WeakSet()  # under that lock
_held: list[Any] = []


def _hold() -> None:
    """Waits until no call runs, and lets none begin. So a child of fork has no frame halfway, and no thread is in the library while the
    process ends: a thread that comes later waits for good."""
    _library_lock.acquire()
    _held.append(_library_lock)
    for renderer in list(_renderers):
        renderer._lock.acquire()
        _held.append(renderer._lock)


def _release() -> None:
    while _held:
        _held.pop().release()


atexit.register(_hold)
os.register_at_fork(before=_hold, after_in_parent=_release, after_in_child=_release)


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
            ("load_file", number, [handle, text]), ("cameras", text, [handle, text]),
            ("load", number, [handle, text, text, ctypes.c_size_t]), ("set", number, [handle, text]),
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
        self._lock = threading.RLock()
        with _library_lock:
            self._c = _load_library()
            self._handle: int | None = self._c.tilemesh_create()
            if not self._handle:
                raise Error("no renderer (memory is short); free some", 2)
            self._free = weakref.finalize(self, self._c.tilemesh_destroy, self._handle)
            self._free.atexit = False  # the process frees all of it
            _renderers.add(self)
        self._track_size: tuple[int, int] | None = None
        self._track_lens: str | None = None
        self._lens: str = "pinhole"  # of cameras that name none
        try:
            self.set(**{"program": "auto", "threads": min(os.cpu_count() or 1, 256), **settings})
            if map is not None:
                self.load(map)
        except BaseException:
            self.close()
            raise

    # --- what a renderer is

    @_door
    def load(self, map: Text | None) -> None:
        """Another map: PLY, compressed PLY, .splat, SPZ or SOG; None: the built-in one. An error leaves the old map."""
        with self._lock:
            if map is None:
                self._call("load", None, None, 0)
            else:
                self._call("load_file", _path(map))
            self._track_size = None

    def set(self, **settings: Any) -> None:
        """Changes settings: width, height, quality, program, depth, alpha, threads, preset, machine, slots ... (tilemesh.h lists all). An
        error changes none. The next frame uses them."""
        try:
            text = _json_text(settings)
        except (TypeError, ValueError) as error:
            raise Error(f"settings that are no JSON ({error}); give numbers, texts, true or false") from None
        with self._lock:
            self._call("set", text.encode())
            self._lens = settings.get("lens", self._lens)

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

    @_door
    def render(self, camera: Camera | Numbers | None = None) -> Frame:
        """Renders a frame; None: from `start`. Records begin on the tiles where the last frame left them."""
        with self._lock:
            self._call("render", self._numbers(self.start if camera is None else camera))
            summary, settings = self._json("frame"), self._json("settings")
            size = summary["height"], summary["width"]
            planes = {what: self._copy(what, size) if settings[what] else None for what in ("depth", "alpha")}
            return Frame(self._copy("rgb_float", (*size, 3)), planes["depth"], planes["alpha"], summary, self._json("run"))

    @_door
    def track_begin(self, camera: Camera | Numbers, depth: bool = False) -> None:
        """Begins to track with the settings' width and height: `camera` is the guess for the first picture. `depth`: pictures have one."""
        with self._lock:
            self._call("track_begin", self._numbers(camera), 1 if depth else 0)
            settings = self._json("settings")
            self._track_lens = settings["lens"]
            self._track_size = settings["height"], settings["width"]

    @_door
    def track(self, colour: Picture, depth: Picture | None = None, seconds: float = 0.0, *, depth_scale: float | None = None) -> TrackedFrame:
        """Finds the camera of the next picture: `colour` of the shape (height, width, 3), linear, floats of 0 to 1 or uint8 of 0 to 255; `depth`
        of (height, width) in units of the map, times `depth_scale` if it is given: 1000 for millimetres in a map of metres. Whole numbers
        need one."""
        with self._lock:
            size = self._track_size or (0, 0)
            if depth_scale is not None and not 0 < depth_scale < float("inf"):
                raise Error(f"a depth_scale of {depth_scale} (it is the number of one unit in the picture); give one above 0")
            rgb, rgb_at = _floats(colour, (*size, 3), "picture", self._track_size is not None, None)
            deep, deep_at = (None, None) if depth is None else _floats(depth, size, "depth", self._track_size is not None, depth_scale)
            self._call("track", rgb_at, deep_at, size[0] * size[1], float(seconds), None)
            del rgb, deep  # not before: they own what the call read
            facts = self._json("track")
        return TrackedFrame(replace(Camera.of(facts["camera"]), lens=self._track_lens), facts["verdict"], facts["why"], facts)

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
        return _called(self._c, self._handle, name, *arguments)

    def _json(self, what: str) -> dict[str, Any]:
        return json.loads(self._call("report", what.encode()))

    def _numbers(self, camera: Camera | Numbers) -> Any:
        camera = camera if isinstance(camera, Camera) else Camera.of(camera)
        lens = self._lens if camera.lens is None else camera.lens
        if lens != self._json("settings")["lens"]:
            self._call("set", json.dumps({"lens": lens}).encode())
        if camera.size is not None:
            settings = self._json("settings")
            if camera.size != (size := (settings["width"], settings["height"])):
                raise Error(f"a camera of {camera.size[0]} x {camera.size[1]} pixels (the settings have {size[0]} x {size[1]}); set them, or use "
                            f"camera.resized{size}")
        return (ctypes.c_double * 17)(*camera.numbers)

    def _copy(self, what: str, shape: Sequence[int]) -> Picture:
        """Floats of the last frame, copied: the handle owns its own until the next call."""
        at = self._call("pixels", what.encode())
        count = math.prod(shape)
        if numpy is not None:
            picture = numpy.empty(shape, numpy.float32)
            ctypes.memmove(picture.ctypes.data, at, 4 * count)
            return picture
        return memoryview(bytearray(ctypes.string_at(at, 4 * count))).cast("f", list(shape))

    def _report(self, what: str) -> dict[str, Any]:
        with self._lock:
            return self._json(what)


def _called(library: ctypes.CDLL, handle: int, name: str, *arguments: Any) -> Any:
    result = getattr(library, "tilemesh_" + name)(handle, *arguments)
    if not result:
        text = library.tilemesh_error(handle).decode(errors="replace")
        text = re.sub(r"tilemesh_(\w+)( in tilemesh\.h)?", lambda name: "Renderer." + name[1].replace("load_file", "load"), text)
        raise Error(text, library.tilemesh_error_code(handle))
    return result


def _path(file: Text) -> bytes:
    path = os.fsencode(file)
    if b"\0" in path:
        raise Error("a file whose name has a zero byte (no file has such a name); name a file")
    return path


def _floats(picture: Picture, shape: Sequence[int], what: str, known: bool, scale: float | None) -> tuple[Any, int]:
    """A picture as floats in memory, row by row, and their address. The first result owns them."""
    array = memoryview(picture) if numpy is None else numpy.asarray(picture)
    kind = array.format if numpy is None else array.dtype.char
    if numpy is None and kind[:1] == ("<" if sys.byteorder == "little" else ">") and struct.calcsize(kind[1:]) == array.itemsize:
        kind = kind[1:]  # ctypes says the order of bytes
    if kind not in ("efd" if numpy is not None else "fd") and (what == "picture" or scale is None or kind not in "bBhHiIlLqQ"):
        if what != "picture" or kind != "B":
            raise Error(f"a {what} of the type {kind if numpy is None else array.dtype} (it has floats, " +
                        ("0 to 1, or uint8, 0 to 255" if what == "picture" else "or whole numbers with a depth_scale") + "); convert it")
        scale = 255.0
    if known and tuple(array.shape) != tuple(shape):
        raise Error(f"a {what} of the shape {tuple(array.shape)} (the tracker began with {tuple(shape)}); give that, or begin again")
    if numpy is not None:
        array = numpy.ascontiguousarray(array if scale is None else array / scale, numpy.float32)
        return array, array.ctypes.data
    flat = memoryview(array.tobytes()).cast(kind)
    floats = (ctypes.c_float * len(flat))(*flat) if scale is None else (ctypes.c_float * len(flat))(*(v / scale for v in flat))
    return floats, ctypes.addressof(floats)


@_door
def read_cameras(file: Text) -> dict[str, Camera]:
    """The cameras of a file, by name ("SCENE/NAME" if it has scenes): JSON of this library, of 3DGS training or nerfstudio (transforms.json),
    or a COLMAP model. A camera whose file names no near plane has 0.2; render_map chooses one for its map."""
    with _library_lock:
        library = _load_library()
        handle = library.tilemesh_create()
        try:
            found = json.loads(_called(library, handle, "cameras", _path(file)))["cameras"]
        finally:
            library.tilemesh_destroy(handle)
    return {each["name"]: replace(Camera.of(each["camera"]), size=(each["width"], each["height"]), lens=each["lens"]) for each in found}


# --- studies


@_door
def explore(study: Text | Mapping[str, Any], out: Text, *, program: Text | None = None, arguments: Sequence[str] = ()) -> list[dict[str, Any]]:
    """Runs a study (a dict, or a file of JSON) with the program `explore`, which writes its page and pictures into the folder `out`. Returns
    the points of `out`/points.csv. The program is `program`, the one beside the package, the one that the build has in its folder examples,
    or the one in PATH. Relative paths in a dict begin at the current folder."""
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
            text = _json_text({**study, "folder": os.path.abspath(study.get("folder", ""))})
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


@_door
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
        with open(os.fspath(csv), newline="", encoding="utf-8") as file:
            rows = list(_csv.reader(line for line in file if not line.startswith("#")))
    except (OSError, ValueError, _csv.Error) as error:
        raise Error(f"cannot read the points of {os.fspath(csv)} ({error}); name the CSV file of a study") from None
    if not rows or any(len(row) != len(rows[0]) for row in rows):
        raise Error(f"{os.fspath(csv)} is no table of points (lines have different numbers of columns, or there is none); write it again")
    return [dict(zip(rows[0], map(value, row))) for row in rows[1:]]


@_door
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
