"""The package tilemesh, in PYTHONPATH: see package.sh. WITHOUT=numpy: as if numpy were not installed."""
import array
import json
import math
import os
import stat
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
from pathlib import Path

if os.environ.get("WITHOUT") == "numpy":
    sys.modules["numpy"] = None  # an import of it fails
import tilemesh

WORK = Path(os.environ["WORK"])
SMALL = {"width": 160, "height": 96}


def floats(picture):
    return memoryview(picture).cast("B").tobytes()


def pfm(path):
    """The floats of a PFM, first row at the top, as bytes."""
    with open(path, "rb") as file:
        kind, size, scale = (file.readline().strip() for _ in range(3))
        width, height = map(int, size.split())
        row = 4 * width * (3 if kind == b"PF" else 1)
        assert float(scale) < 0, "little endian"
        data = file.read()
    return b"".join(data[y * row:(y + 1) * row] for y in reversed(range(height)))


class Package(unittest.TestCase):
    def refused(self, act, code=1):
        """One line of an Error, with this code."""
        with self.assertRaises(tilemesh.Error) as caught:
            act()
        text = str(caught.exception)
        self.assertRegex(text, r"^[^\n]+ \(.+\); [^\n]+$")
        self.assertEqual(caught.exception.code, code, text)
        return text

    def test_bits_of_render_map(self):
        if not (WORK / "four.ply").exists():
            self.skipTest("render_map was not built")
        for name, file in [("built_in", None), ("four", WORK / "four.ply")]:
            for quality in ["default", "viewing"]:
                with tilemesh.Renderer(file, width=320, height=180, depth=True, alpha=True, quality=quality) as renderer:
                    frame = renderer.render()
                folder = WORK / f"{name}.{quality}"
                self.assertEqual(floats(frame.colour), pfm(folder / "frame_0000.pfm"), (name, quality))
                self.assertEqual(floats(frame.depth), pfm(folder / "frame_0000.depth.pfm"), (name, quality))
                self.assertEqual(floats(frame.alpha), pfm(folder / "frame_0000.alpha.pfm"), (name, quality))
                theirs = json.loads((folder / "report.json").read_text())
                for member in ["preset", "quality", "program", "cut_offs"]:
                    self.assertEqual(frame.report[member], theirs[member])
                self.assertEqual(frame.report["frames"][0]["pairs"], theirs["frames"][0]["pairs"])

    def test_lenses(self):
        (WORK / "lens.json").write_text(json.dumps({"cameras": [{
            "name": name, "width": 160, "height": 96, "fx": 120, "fy": 120, "cx": 80, "cy": 48, "near": 0.2, **more,
            "world_to_camera": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]} for name, more in
            [("straight", {}), ("bent", {"k1": -0.125, "p1": 0.015625}), ("round", {"camera_model": "OPENCV_FISHEYE"})]]}))
        cameras = tilemesh.read_cameras(WORK / "lens.json")
        self.assertEqual([each.lens for each in cameras.values()], ["pinhole", "opencv,-0.125,0,0.015625", "fisheye"])
        with tilemesh.Renderer(**SMALL) as renderer:
            pictures = {name: floats(renderer.render(each).colour) for name, each in cameras.items()}
            self.assertEqual(len(set(pictures.values())), 3)
            renderer.set(lens="opencv,-0.125,0,0.015625")  # of numbers, and of cameras that name none
            self.assertEqual(floats(renderer.render(cameras["straight"].numbers).colour), pictures["bent"])
            self.assertEqual(floats(renderer.render(cameras["straight"]).colour), pictures["straight"])
            self.assertIn("there is no such lens", self.refused(lambda: renderer.set(lens="fish")))
            self.assertIn("folds within the picture", self.refused(lambda: renderer.render(
                tilemesh.Camera(cameras["straight"].rotation, (0, 0, 0), 120, 120, 80, 48, lens="opencv,-3"))))
            self.assertIn("a panorama", self.refused(lambda: renderer.render(
                tilemesh.Camera(cameras["straight"].rotation, (0, 0, 0), 25, 25, 80, 48, lens="equirectangular"))))
            self.assertIn("a panorama", self.refused(lambda: renderer.track_begin(
                tilemesh.Camera(cameras["straight"].rotation, (0, 0, 0), 25, 25, 80, 48, lens="equirectangular"))))

    def test_pictures_own_their_memory(self):
        renderer = tilemesh.Renderer(**SMALL, depth=True)
        first = renderer.render()
        before = floats(first.colour), floats(first.depth)
        self.assertIsNone(first.alpha)
        self.assertEqual(tuple(first.colour.shape), (96, 160, 3))
        self.assertEqual(tuple(first.depth.shape), (96, 160))
        second = renderer.render(renderer.start.moved(right=0.2))
        self.assertNotEqual(floats(second.colour), before[0])
        self.assertEqual((floats(first.colour), floats(first.depth)), before)
        first.colour[0, 0, 0] = 7.0  # it is the caller's, and no other picture's
        renderer.set(width=64, height=48)
        renderer.render()
        renderer.close()
        renderer.close()
        del renderer
        self.assertEqual(floats(first.depth), before[1])
        self.assertEqual(floats(first.colour)[4:], before[0][4:])

    def test_a_closed_renderer_is_refused(self):
        renderer = tilemesh.Renderer(**SMALL)
        start = renderer.start
        picture = renderer.render(start).colour
        renderer.close()
        for act in [renderer.render, lambda: renderer.render(start), lambda: renderer.settings, lambda: renderer.set(width=64), lambda: renderer.load(None),
                    lambda: renderer.track_begin(start), lambda: renderer.track(picture)]:
            self.assertIn("close()", self.refused(act, None))

    def test_cameras(self):
        c, s = math.cos(0.3), math.sin(0.3)
        rotation, position = [[c, 0, s], [0, 1, 0], [-s, 0, c]], [1.0, 2.0, 3.0]
        camera = tilemesh.Camera(rotation, position, 100, 101, 80, 48)
        self.assertEqual(camera.numbers, [c, 0, s, 0, 1, 0, -s, 0, c, 1, 2, 3, 100, 101, 80, 48, 0.2])
        same = [tilemesh.Camera.of(camera.numbers), tilemesh.Camera(tuple(sum(rotation, [])), tuple(position), 100.0, 101, 80, 48)]
        to_world = [[rotation[j][i] for j in range(3)] + [position[i]] for i in range(3)]
        same.append(tilemesh.Camera.from_matrix(to_world, 100, 101, 80, 48, camera_to_world=True))
        same.append(tilemesh.Camera.from_matrix(to_world + [[0, 0, 0, 1]], 100, 101, 80, 48, camera_to_world=True))
        if tilemesh.numpy is not None:
            array, number = tilemesh.numpy.array, tilemesh.numpy.float64
            same.append(tilemesh.Camera(array(rotation), array(position), number(100), tilemesh.numpy.int32(101), 80, 48))
            same.append(tilemesh.Camera.of(array(camera.numbers)))
        for other in same:
            self.assertEqual(other, camera)
            self.assertEqual(hash(other), hash(camera))
        world_to_camera = [row + [-sum(a * b for a, b in zip(row, position))] for row in rotation]
        back = tilemesh.Camera.from_matrix(world_to_camera, 100, 101, 80, 48)
        self.assertEqual(back.rotation, camera.rotation)
        self.assertLess(math.dist(back.position, position), 1e-12)
        self.assertIn("rotation", self.refused(lambda: tilemesh.Camera([1.0] * 8, position, 1, 1, 1, 1), None))
        for act in [lambda: tilemesh.Camera(rotation, "abc", 1, 1, 1, 1), lambda: tilemesh.Camera(rotation, position, "f", 1, 1, 1),
                    lambda: tilemesh.Camera.of(None), lambda: tilemesh.Camera.of(object()), lambda: tilemesh.Camera.from_matrix(rotation, 1, 1, 1, 1),
                    lambda: tilemesh.Camera.from_matrix([1.0] * 16, 1, 1, 1, 1), lambda: camera.resized(1, 1)]:
            self.refused(act, None)
        self.assertIn("Camera.moved", self.refused(lambda: camera.moved(object()), None))
        self.assertIn("Camera.moved", self.refused(lambda: camera.moved(right="x"), None))

        file = WORK / "cameras.json"
        pose = {"width": 160, "height": 96, "fx": 100, "fy": 101, "cx": 80, "cy": 48, "world_to_camera": world_to_camera + [[0, 0, 0, 1]]}
        file.write_text(json.dumps({"cameras": [{"name": "a", **pose}, {"name": "b", "scene": "s", **pose}]}))
        self.assertEqual(list(tilemesh.read_cameras(file)), ["a", "s/b"])
        read = tilemesh.Camera.from_file(file, "s/b")
        self.assertEqual((read.size, read.fx, read.fy), ((160, 96), 100, 101))
        self.assertLess(max(abs(a - b) for a, b in zip(read.numbers, camera.numbers)), 1e-6)
        for act in [lambda: tilemesh.Camera.from_file(str(file)), lambda: tilemesh.Camera.from_file(file, "c")]:
            self.assertIn("a, s/b", self.refused(act, None))
        self.refused(lambda: tilemesh.Camera.from_file(WORK / "absent.json"))
        self.refused(lambda: tilemesh.Camera.from_file(5), None)
        with tilemesh.Renderer(width=320, height=192) as renderer:
            self.assertIn("160 x 96", self.refused(lambda: renderer.render(read), None))
            self.assertIn("160 x 96", self.refused(lambda: renderer.track_begin(read), None))
            larger = read.resized(320, 192)
            self.assertEqual((larger.fx, larger.fy, larger.cx, larger.cy), (200, 202, 160, 96))
            renderer.render(larger)
            r = camera.rotation
            for name, wrong in [("mirrored", [-v for v in r[:3]] + list(r[3:])), ("orthonormal", [0.0] * 9), ("orthonormal", [r[0], r[1] + 0.1, *r[2:]])]:
                for act in [lambda: renderer.render(tilemesh.Camera(wrong, position, 100, 100, 80, 48)),
                            lambda: renderer.track_begin(tilemesh.Camera(wrong, position, 100, 100, 80, 48))]:
                    self.assertIn(name, self.refused(act))

    def test_settings_of_other_types(self):
        with tilemesh.Renderer(**SMALL) as renderer:
            if tilemesh.numpy is not None:
                renderer.set(width=tilemesh.numpy.int64(64), background=tilemesh.numpy.array([0.25, 0.5, 1.0], "f"), depth=tilemesh.numpy.bool_(True))
                self.assertEqual([renderer.settings[s] for s in ["width", "background", "depth"]], [64, [0.25, 0.5, 1.0], True])
            renderer.set(background=(0, 0.5, 1))
            for act in [lambda: renderer.load(5), lambda: tilemesh.read_points(5), lambda: tilemesh.front(5, "a"), lambda: tilemesh.front([{"a": 1}], 5),
                        lambda: tilemesh.explore(5, WORK), lambda: tilemesh.explore({}, 5), lambda: renderer.render(5), lambda: renderer.track_begin(5)]:
                self.refused(act, None)
            self.assertIn("Renderer.set", self.refused(lambda: renderer.set(width=1)))

    def test_programs_and_facts(self):
        with tilemesh.Renderer(**SMALL) as plain, tilemesh.Renderer(**SMALL, storage_slots=40) as crowded, tilemesh.Renderer(**SMALL, program="anchored") as traced:
            pictures = [r.render() for r in (plain, crowded, traced)]
            self.assertEqual([f.summary["program"] for f in pictures], ["anchored", "homes", "anchored"])
            self.assertEqual(len({floats(f.colour) for f in pictures}), 1)
            self.assertIsNone(pictures[0].summary["modelled_ms"])
            self.assertGreater(pictures[2].summary["modelled_ms"], 0)
            self.assertEqual(plain.map["name"], "built_in")
            self.assertEqual(plain.settings["width"], 160)
            self.assertIn("ply", plain.build["formats"])
            self.assertEqual(pictures[0].report["map"]["gaussians"], plain.map["gaussians"])
            self.assertEqual(tilemesh.Camera.of(plain.start.numbers), plain.start)

    def test_errors(self):
        with tilemesh.Renderer(**SMALL) as renderer:
            start = renderer.start
            before = floats(renderer.render(start).colour)
            for settings in [{"width": 1}, {"colour": 3}, {"quality": "best"}, {"depth": 1}, {"width": "640"}, {"hops": 2, "program": "homes"}]:
                self.refused(lambda: renderer.set(**settings))
            for settings in [{"width": float("nan")}, {"width": object()}, {"background": {1}}]:
                self.refused(lambda: renderer.set(**settings), None)
            self.assertIn("not finite", self.refused(lambda: renderer.render(start.moved(right=float("nan")))))
            self.refused(lambda: renderer.render([1.0] * 16), None)
            self.refused(lambda: renderer.render("a camera"), None)
            self.refused(lambda: renderer.render([1.0] * 16 + [None]), None)
            self.refused(lambda: renderer.load(WORK / "absent.ply"))
            self.refused(lambda: renderer.load(__file__))
            self.refused(lambda: renderer.load("zero\0byte.ply"), None)
            self.refused(lambda: tilemesh.Renderer("absent.ply"))
            self.refused(lambda: tilemesh.Renderer(tiles=3))
            self.assertEqual(floats(renderer.render(start).colour), before)

    def test_tracking(self):
        with tilemesh.Renderer(width=320, height=180, depth=True) as renderer:
            start = renderer.start
            frame = renderer.render(start)
            self.assertIn("Renderer.track_begin", self.refused(lambda: renderer.track(frame.colour), 3))
            self.refused(lambda: renderer.track("x"), None)
            for depth in [None, frame.depth]:
                renderer.track_begin(start.moved(right=0.01), depth=depth is not None)
                found = renderer.track(frame.colour, depth)
                self.assertEqual(found.verdict, "converged")
                self.assertLess(math.dist(found.camera.position, start.position), 1e-4)
            self.refused(lambda: renderer.track(frame.depth, frame.depth), None)  # shapes
            self.refused(lambda: renderer.track(frame.colour, frame.colour), None)
            self.refused(lambda: renderer.track("picture", frame.depth), None)
            self.refused(lambda: renderer.track(frame.colour))  # it began with depth
            self.refused(lambda: renderer.track(frame.colour, frame.depth, float("inf")))
            if tilemesh.numpy is None:
                black = memoryview(bytearray(4 * 3 * 320 * 180)).cast("f", [180, 320, 3])
                self.refused(lambda: renderer.track(array.array("d", [0.0]), frame.depth), None)
            else:
                black = tilemesh.numpy.zeros((180, 320, 3))  # doubles are converted
                turned = tilemesh.numpy.ascontiguousarray(frame.colour.transpose(2, 0, 1)).transpose(1, 2, 0)  # not contiguous
                self.assertLess(math.dist(renderer.track(turned, frame.depth).camera.position, start.position), 1e-4)
            self.refused(lambda: renderer.track(frame.colour, frame.depth, "now"), None)
            # Types and ranges say what the numbers are, or they are refused.
            levels = [min(max(round(255 * v), 0), 255) for v in memoryview(frame.colour).cast("B").cast("f")]
            bytes_of = memoryview(bytes(levels)).cast("B", [180, 320, 3])
            scaled = memoryview(array.array("f", levels)).cast("B").cast("f", [180, 320, 3])
            millimetres = memoryview(array.array("H", [round(1000 * z) for z in memoryview(frame.depth).cast("B").cast("f")])).cast("B").cast("H", [180, 320])
            self.assertLess(math.dist(renderer.track(bytes_of, frame.depth).camera.position, start.position), 1e-2)
            self.assertIn("255", self.refused(lambda: renderer.track(scaled, frame.depth)))
            self.assertIn("depth_scale", self.refused(lambda: renderer.track(frame.colour, millimetres), None))
            self.assertLess(math.dist(renderer.track(frame.colour, millimetres, depth_scale=1000).camera.position, start.position), 1e-2)
            for scale in [0, -1, float("nan"), float("inf"), "x"]:
                self.refused(lambda: renderer.track(frame.colour, millimetres, depth_scale=scale), None)
            self.refused(lambda: renderer.track(millimetres, frame.depth), None)
            if tilemesh.numpy is not None:
                for wrong in ["i8", "u2", "?"]:
                    self.assertIn("uint8", self.refused(lambda: renderer.track((255 * frame.colour).astype(wrong), frame.depth), None))
            lost = renderer.track(black, frame.depth)
            self.assertEqual(lost.verdict, "lost")
            self.assertTrue(lost.why)
            renderer.load(None)
            self.refused(lambda: renderer.track(frame.colour, frame.depth), 3)

    def test_threads(self):
        with tilemesh.Renderer(**SMALL, threads=1) as one:
            cameras = [one.start.moved(right=0.05 * i) for i in range(4)]
            expected = [floats(one.render(c).colour) for c in cameras]
            seen, faults = {}, []

            def work(i, renderer):
                try:
                    for k in range(3):
                        seen[i, k] = floats(renderer.render(cameras[i]).colour)
                except BaseException as error:  # told to the main thread
                    faults.append(error)

            for shared in [True, False]:
                renderers = [one if shared else tilemesh.Renderer(**SMALL, threads=2) for _ in cameras]
                threads = [threading.Thread(target=work, args=(i, r)) for i, r in enumerate(renderers)]
                for thread in threads:
                    thread.start()
                for thread in threads:
                    thread.join()
                self.assertEqual(faults, [])
                self.assertEqual([seen[i, k] for i in range(4) for k in range(3)], [expected[i] for i in range(4) for _ in range(3)])
                if not shared:
                    for renderer in renderers:
                        renderer.close()

    def test_a_forked_child_renders(self):
        with tilemesh.Renderer(**SMALL, threads=3) as renderer:
            start = renderer.start
            before = floats(renderer.render(start).colour)
            busy = threading.Thread(target=lambda: [renderer.render(start.moved(right=0.01 * i)) for i in range(8)])
            busy.start()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12 warns of any thread
                child = os.fork()
            if child == 0:
                status = 1
                try:
                    same = floats(renderer.render(start).colour) == before
                    renderer.close()  # its threads are the parent's
                    with tilemesh.Renderer(**SMALL, threads=2) as another:
                        status = 0 if same and floats(another.render(start).colour) == before else 2
                finally:
                    os._exit(status)
            timer = threading.Timer(120, os.kill, (child, 9))
            timer.start()
            self.assertEqual(os.waitpid(child, 0)[1], 0)
            timer.cancel()
            busy.join()
            self.assertEqual(floats(renderer.render(start).colour), before)

    def test_the_interpreter_ends_in_silence(self):
        program = """
import os, sys, threading, time
if os.environ["WITHOUT"]:
    sys.modules["numpy"] = None
import tilemesh
renderer = tilemesh.Renderer(width=160, height=96, threads=2, depth=True)
frame = renderer.render()
renderer.track_begin(renderer.start, depth=True)
def work():
    while True:
        renderer.track(frame.colour, frame.depth) if sys.argv[1] == "track" else renderer.render(renderer.start.moved(right=0.01))
        if sys.argv[1] == "make":
            tilemesh.Renderer(width=64, height=48, threads=2).render()
for _ in range(3):
    threading.Thread(target=work, daemon=True).start()
time.sleep(0.3 + 0.02 * int(sys.argv[2]))
"""
        for what in ["render", "track", "make"]:
            for i in range(2):
                ended = subprocess.run([sys.executable, "-c", program, what, str(i)], capture_output=True, timeout=120)
                self.assertEqual((ended.returncode, ended.stdout, ended.stderr), (0, b"", b""), (what, i))

    def test_memory_is_freed(self):
        def resident():
            return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        def use():
            with tilemesh.Renderer(**SMALL, depth=True) as renderer:
                renderer.render()
            tilemesh.Renderer(**SMALL).render()  # freed without close

        for _ in range(3):
            use()
        before = resident()
        for _ in range(12):
            use()
        self.assertLess(resident() - before, 60e6)  # a renderer takes more than 20 MB

    def test_studies(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            program = folder / "explore"
            program.write_text("#!/bin/sh\nset -e\ntest \"$2\" = --csv && test \"$4\" = --out && test -d \"$5\"\n"
                               "case $(cat \"$1\") in *half*) ;; *) echo 'note' >&2; echo 'no study (it names no machine); name one' >&2; exit 2 ;; esac\n"
                               "printf 'name,error,ms,front\\nhalf,0.5,2,yes\\nwhole,0.25,4,yes\\nworse,0.5,4,\\nequal,0.5,2,yes\\nnone,,1,\\n' >\"$3\"\n")
            program.chmod(program.stat().st_mode | stat.S_IXUSR)
            out = folder / "new" / "out"
            points = tilemesh.explore({"machines": ["half", "whole"]}, out, program=program)
            self.assertEqual(points[0], {"name": "half", "error": 0.5, "ms": 2, "front": "yes"})
            self.assertEqual(points[4], {"name": "none", "error": None, "ms": 1, "front": None})
            self.assertEqual([p["name"] for p in tilemesh.front(points, "error", "ms")], ["whole", "half", "equal"])
            self.assertEqual([p["name"] for p in tilemesh.front(points, "ms")], ["none"])
            self.assertEqual([p["name"] for p in tilemesh.front(points, "-ms", "error")], ["whole"])
            self.assertEqual([p["name"] for p in tilemesh.front(points, "-error", "ms")], ["half", "equal"])
            self.assertEqual(tilemesh.front([], "ms"), [])
            self.assertEqual(tilemesh.read_points(out / "points.csv"), points)
            self.assertEqual(json.loads((out / "study.json").read_text()), {"machines": ["half", "whole"], "folder": os.getcwd()})
            study = {"machines": ["half"], "maps": [Path("a.ply")], "folder": Path("sub"), "size": (64, 48)}
            plain = {"machines": ["half"], "maps": ["a.ply"], "folder": os.path.join(os.getcwd(), "sub"), "size": [64, 48]}
            if tilemesh.numpy is not None:
                study["size"] = tilemesh.numpy.array([64, 48])
                study["costs"], plain["costs"] = [{"clock": tilemesh.numpy.float32(0.5)}], [{"clock": 0.5}]
            tilemesh.explore(study, out, program=program)
            self.assertEqual(json.loads((out / "study.json").read_text()), plain)
            self.assertEqual(self.refused(lambda: tilemesh.explore({}, out, program=program), None), "no study (it names no machine); name one")
            self.assertIn("--target explore", self.refused(lambda: tilemesh.explore({}, out, program=folder / "absent"), None))
            self.refused(lambda: tilemesh.explore({"a": float("nan")}, out, program=program), None)
            self.refused(lambda: tilemesh.explore({}, program / "below_a_file", program=program), None)
            self.refused(lambda: tilemesh.front(points, "pairs"), None)
            self.refused(lambda: tilemesh.front(points), None)
            self.refused(lambda: tilemesh.read_points(folder / "absent.csv"), None)
            (folder / "torn.csv").write_text("a,b\n1,2\n3\n")
            self.refused(lambda: tilemesh.read_points(folder / "torn.csv"), None)


unittest.main()
