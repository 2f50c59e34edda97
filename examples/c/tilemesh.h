#ifndef TILEMESH_C_H
#define TILEMESH_C_H
/* The chip as C functions, for C99 and later, C++, Python's ctypes, or any language that can call C.
 *
 * A handle holds a map, the settings of a machine, a renderer, the last frame with its trace, and a tracker.
 *
 * Threads: handles share nothing, so threads with a handle each need no lock. At most one thread at a time may be in a call with the same
 * handle, `tilemesh_destroy` and `tilemesh_error` included; it may be another thread for each call. A frame itself runs on as many threads
 * as the setting `threads` says. A child of `fork` may use its copies of handles if no call was under way: they start new threads there.
 *
 * Stability: a function, a setting, a member of a JSON answer and a number below never changes its meaning and never goes. New ones may
 * come, and then TILEMESH_C_VERSION grows by 1. A program that was compiled with a header may use each library whose
 * `tilemesh_version()` is at least the header's TILEMESH_C_VERSION. Ignore members of JSON that you do not know. The numbers of a picture
 * are those of render_map of the same build; they may change from one release of tilemesh to the next.
 *
 * Errors: a function that fails returns 0 or NULL. `tilemesh_error_code` then returns a number of `tilemesh_status`, and
 * `tilemesh_error` one line, "<problem> (<why>); <what to do>". The handle stays as it was before the call and can be used; only a frame
 * that fails while it runs (memory is short) forgets the last frame. No input ends the process, and no C++ exception leaves a function.
 *
 * Memory: every pointer that a function returns belongs to the handle. It is valid until the next call with the same handle, except
 * that `tilemesh_error` and `tilemesh_error_code` leave it valid. In WebAssembly the memory may move when it grows: make a new view of it
 * after every call.
 * What the caller passes in is copied; the caller keeps it and frees it. All texts are UTF-8 and end with a zero byte.
 *
 * Axes: x right, y down, z forward, as in OpenCV. Pictures have their first row at the top. Tiles are numbered row by row from the
 * top left: tile t is in column t % columns and row t / columns. Lengths are in units of the map.
 */
#include <stddef.h>
#include <stdint.h>

/* The version of this interface. */
#define TILEMESH_C_VERSION 5

#if defined(TILEMESH_C_EXPORT)
#define TILEMESH_C __attribute__((visibility("default"), used))
#else
#define TILEMESH_C
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tilemesh_handle tilemesh_handle;

/* Why the last call with a handle failed. */
typedef enum tilemesh_status {
    TILEMESH_OK = 0,        /* it did not fail */
    TILEMESH_BAD_INPUT = 1, /* an argument, a file or a setting; also a map that does not fit the machine */
    TILEMESH_NO_MEMORY = 2,
    TILEMESH_NO_FRAME = 3,  /* what was asked for was not rendered or tracked before */
    TILEMESH_NOT_BUILT = 4, /* this build of the library leaves it out */
    TILEMESH_FAULT = 5      /* a fault of the library: report it */
} tilemesh_status;

/* The TILEMESH_C_VERSION of the library that runs. */
TILEMESH_C int tilemesh_version(void);

/* Returns a new handle with the built-in map and the default settings, or NULL if memory is short. Nothing is rendered yet. */
TILEMESH_C tilemesh_handle* tilemesh_create(void);

/* Frees a handle and everything that it owns. NULL is allowed. */
TILEMESH_C void tilemesh_destroy(tilemesh_handle* handle);

/* The error of the last call with this handle, one line; an empty text if the call succeeded. Never NULL. */
TILEMESH_C char const* tilemesh_error(tilemesh_handle const* handle);

/* The number of that error in tilemesh_status; TILEMESH_BAD_INPUT for NULL. */
TILEMESH_C int tilemesh_error_code(tilemesh_handle const* handle);

/* Replaces the map by the content of a file: `length` bytes at `bytes`. `bytes` NULL: the built-in map. The first bytes choose the
 * reader: PLY (also compressed), SPZ, SOG in a ZIP archive, or SPLAT if `name` ends in ".splat". `name` appears in messages; NULL is
 * "a file". SPZ and SOG need a library with their decoders ("formats" of `tilemesh_report(handle, "build")`); the page has none. The last
 * frame and the tracker are forgotten; the settings stay. Returns 1, or 0 with an error; then the old map stays. Cost: about 62 bytes for
 * each Gaussian. */
TILEMESH_C int tilemesh_load(tilemesh_handle* handle, char const* name, void const* bytes, size_t length);

/* As tilemesh_load, for a file, or a folder of SOG, on disk. The page has no files (TILEMESH_NOT_BUILT). */
TILEMESH_C int tilemesh_load_file(tilemesh_handle* handle, char const* path);

/* Reads a file of poses: TUM, EuRoC, KITTI or Replica. The handle does not change. Returns JSON, or NULL with an error:
 *   {"format": "tum", "stamps": true, "notes": [text...], "poses": [{"seconds": 1.5, "rotation": [9 numbers], "position": [3 numbers]}, ...]}
 * `rotation` and `position` are numbers 0 to 11 of a camera for `tilemesh_render`. Without stamps `seconds` is the pose's number. */
TILEMESH_C char const* tilemesh_trajectory(tilemesh_handle* handle, char const* name, void const* bytes, size_t length);

/* Reads the cameras of a file on disk: JSON of this library, of 3DGS training or of nerfstudio (transforms.json), or a COLMAP model, of which
 * `path` may be the folder. The handle does not change. Returns JSON, or NULL with an error:
 *   {"notes": [text...], "cameras": [{"name": "SCENE/NAME" or "NAME", "width", "height", "camera": [17 numbers], "lens": text}, ...]}
 * `camera` is for a picture of `width` x `height` pixels; its near plane is 0.2 where the file names none. `lens`, since version 5, is a
 * text for the setting of that name, "pinhole" if nothing bends. Since version 4. The page has no files (TILEMESH_NOT_BUILT). */
TILEMESH_C char const* tilemesh_cameras(tilemesh_handle* handle, char const* path);

/* Changes settings: a JSON object with some of the names below, such as {"width": 320, "channel_slots": 8}. Settings that it does not
 * name stay. NULL or "{}" changes nothing. Returns 1, or 0 with an error; then no setting changes. The next frame uses the settings. A
 * change of anything but `difference`, `background`, `lens`, `follow` and `exposure` begins a new mesh in the next frame, which loads the map.
 *
 *   width, height      pixels of the picture, 16 to 4096; default 640, 360
 *   program            "anchored" (default): the frame program with a trace. "homes": the program for maps of any density, "auto":
 *                      anchored until a frame would lack something, then homes; both as in render_map, and without a trace: "supersteps",
 *                      heat maps, tiles, Gaussians, `difference` and `follow` need "anchored". The page has only "anchored"
 *   quality            "default" (of the preset), "evaluation", "viewing", "on_sensor" or "training": cut-offs and rules of the picture
 *   antialias          true: each splat is dimmed as much as the dilation by 0.3 pixels enlarges it, for maps that were trained so; default
 *                      false. Since version 3. Trackers do without
 *   depth, alpha       true: frames have these planes, see `tilemesh_pixels`; default false. They take SRAM from the storage
 *   threads            threads of the host, 1 to 256; default 1. No number of a picture or a report depends on it but times
 *   preset             "lossless" (default), "paper" or "prototype": machine, sizes and rules of a published setup
 *   machine            "mk2" (default) or "test": 8,000 slots of storage and tiles of any size, on a machine with more SRAM
 *   tile_width, tile_height  pixels of a tile; 0 (default): the picture is spread over the grid of 40 x 36 tiles
 *   channel_slots      slots of a channel; 0 (default): the preset's number, which is also the most
 *   storage_slots      slots of a tile's storage; 0 (default): the preset's number, which is also the most
 *   waiting_slots      slots of each FIFO of routing; 0 (default): the preset's number, which is also the most
 *   hops               most exchanges of routing, and of bloom, in a frame; 0 or "quiet" (default): until all tiles are quiet
 *   most_passes        a frame that needs more passes of routing, or of bloom, is an error; 0 or "none" (default): no such limit. This
 *                      and the next three since version 4
 *   rounds, held       homes: most rounds of a frame, most splats that a tile holds; 0, or "all" and "fits" (default): what the map needs
 *   fold               homes: "on" (default): each part of the picture is spread over the grid; "off"
 *   saturation         "hold", "drop" or "preset" (default): what a record does that meets a full channel
 *   priority           "first", "largest" or "preset" (default): what a full tile keeps and a full channel takes
 *   copies             "world", "screen" or "preset" (default): the records that bloom sends
 *   pixels             "float", "rgbx8" or "preset" (default): the framebuffers of the tiles
 *   lens               "pinhole" (default), or how the lens of the cameras bends the picture: "opencv,k1,k2,p1,p2,k3,k4,k5,k6",
 *                      "fisheye,k1,k2,k3,k4" or "fov,omega"; numbers at the end may be left out. Since version 5
 *   background         [red, green, blue], each 0 to 1; default black
 *   difference         true: each frame is compared with the complete picture, see `tilemesh_pixels`; default false. The complete
 *                      picture has the same view, rules and tiles, and every tile has each Gaussian that touches it
 *   mesh               a number, 0 by default. Another number begins a new mesh, as if this frame were the first
 *   follow             id of a Gaussian whose path the next frames record, or -1 (default): none
 *   digest             true: the report has a digest of all words of the machine for each compute phase; default false
 *   exposure           true: a tracker that begins now also finds the gain and offset of each picture; default false */
TILEMESH_C int tilemesh_set(tilemesh_handle* handle, char const* json);

/* Renders a frame. `camera`: 17 finite numbers, an orthonormal rotation that is not mirrored, as in a camera file,
 *   0 to 8    rows of the rotation from world to camera (x axis, y axis, z axis of the camera in world space),
 *   9 to 11   the centre of the camera in world space, in the coordinates of the map's file,
 *   12 to 15  fx, fy, cx, cy in pixels of the settings' width and height; the centre of the first pixel is at (0.5, 0.5),
 *   16        the near plane, above 0.
 * They are rounded to float. Records start on the tiles where the last frame left them. A record or copy that finds no room is no
 * error: the report counts it. Returns 1, or 0 with an error. */
TILEMESH_C int tilemesh_render(tilemesh_handle* handle, double const* camera);

/* The picture of the last frame, width x height of `tilemesh_report(handle, "frame")`, or NULL with an error. `what`:
 *   "rgba"        4 bytes a pixel, red, green, blue and 255: levels as in a PNG of render_map
 *   "rgb_float"   3 floats a pixel, red, green and blue as they were composited: the numbers of a PFM
 *   "depth"       1 float a pixel: z of the view in world units, 0 where no Gaussian is. Only if the setting `depth` was true
 *   "alpha"       1 float a pixel: the share of the pixel that is covered, 0 to 1. Only if the setting `alpha` was true
 *   "difference"  4 bytes a pixel, painted: the grey picture, and in it what differs from the complete picture, from yellow (a little) to
 *                 red. Only if the setting `difference` was true when the frame was rendered
 *   "complete"    4 bytes a pixel, the complete picture itself; under the same condition */
TILEMESH_C void const* tilemesh_pixels(tilemesh_handle* handle, char const* what);

/* JSON about the handle, or NULL with an error. `what`:
 *   "map"         {"name", "gaussians", "rejected", "sh_degree", "notes": [text...], "start": [17 numbers: a camera that shows the map, for
 *                 the settings' width and height], "target": [x, y, z] (its robust centre), "up": [x, y, z]}
 *   "settings"    {"NAME": value, ..., "limits": {"NAME": {"least", "most", "unit", "words"}, ...}, "choices": {"NAME": [text...]}}: every
 *                 setting of `tilemesh_set`. For a setting of 0 `limits` also has "used", the number that 0 stands for
 *   "build"       {"interface": tilemesh_version(), "library": 200 for version 0.2.0, "formats": [text...] (maps that it reads), "fused": are
 *                 products and sums fused, which changes the last bits of a picture, "tracker", "files": true or false}
 *   "track"       the last tracked frame, see `tilemesh_track`
 *   "frame"       numbers of the last frame: {"width", "height", "columns", "rows" (tiles), "tile_width", "tile_height", "program", "host_ms",
 *                 "modelled_ms", "modelled_cycles", "cost_model", "supersteps", "visible", "moved", "held", "copies", "lost_records",
 *                 "lost_copies", "late_copies", "refused", "messages", "pairs", "records_bytes", "missing": one sentence about what the
 *                 picture lacks or "", "advice": what would help or "",
 *                 "difference": {"psnr_db" (null: equal), "largest", "pixels"} or null, "memory_bytes" (of the process; 0: not known)}
 *   "digest"      {"picture", "counters": 16 hexadecimal digits} of the last frame. Equal digests mean equal bits of the picture, and equal
 *                 exact numbers and losses of the report. A build without fused operations has the digests of the page, on any processor
 *   "run"         report.json of render_map for the last frame
 *   "supersteps"  [{"index", "kernel", "tiles" (that ran), "messages_bytes", "sent", "cycles", "compute", "exchange", "sync", "vote",
 *                 "slowest" (tile)}...] of the last frame, in order; cycles are modelled
 * "frame", "digest", "run" and "supersteps" need a frame. "modelled_ms", "modelled_cycles", "cost_model" and "supersteps" of "frame" are
 * null for a frame without a trace. */
TILEMESH_C char const* tilemesh_report(tilemesh_handle* handle, char const* what);

/* One number for each tile, columns x rows floats, row by row, or NULL with an error. `superstep`: index in the last frame, or -1: the
 * whole frame. `what`:
 *   "load"      records and copies in the tile's storage after the superstep (or the frame)
 *   "copies"    copies among them
 *   "channel"   bytes that the fullest of its four outgoing channels carried, as a share of the channel's slots, 0 to 1 (of the frame: the most)
 *   "refused"   records and copies that a full channel or storage refused in the superstep (or the frame)
 *   "lost"      whole frame: records and copies that the picture lacks on this tile. Superstep: those that met a full storage in it
 *   "pairs"     pairs of a Gaussian and a pixel that the tile evaluated
 *   "busy"      modelled cycles in which the tile computes */
TILEMESH_C float const* tilemesh_heat(tilemesh_handle* handle, char const* what, int superstep);

/* JSON about a tile in the last frame, or NULL with an error:
 *   {"tile", "column", "row", "rect": [x0, y0, x1, y1] (pixels), "records": number, "anchored", "copies", "leaving", "slots",
 *    "ledger": [{"name", "what", "bytes", "budgeted"}...] (of any tile), "ledger_bytes", "sram_bytes",
 *    "counts": {each member of "refused" of a frame of report.json, "pairs", "busy_cycles"},
 *    "channels": [{"side": "north" | "east" | "west" | "south", "sent_bytes", "most_messages", "slots", "received_bytes"}... 4],
 *    "list": [{"id", "kind": "anchored" | "copy" | "leaving", "x", "y" (centre, pixels), "radius", "depth", "opacity", "colour": [r, g, b]}
 *             ...] (at most 500 visible ones, nearest first)} */
TILEMESH_C char const* tilemesh_tile(tilemesh_handle* handle, uint32_t tile);

/* JSON about a Gaussian in the last frame, or NULL with an error:
 *   {"id", "state": "on a tile" | "under way" | "with the host" | "lost" | "not in the map", "anchor": tile or null, "copies": [tile...],
 *    "mean": [x, y, z], "opacity" (both null if it is not in the map), "missing": [tile...] (tiles that lack it),
 *    "path": null, or if the setting `follow` was `id` when the frame was rendered:
 *            [{"superstep", "kernel", "tile", "what", "side": text or null, "refusal"}...]}
 * `what` is one of anchored, copy, leaving, waiting, road, beam, owed, refused, dropped, left. A path lists changes and refusals. */
TILEMESH_C char const* tilemesh_gaussian(tilemesh_handle* handle, uint32_t id);

/* Begins to track: `camera` (17 numbers as in `tilemesh_render`) is the guess for the first picture, and its lens that of all pictures.
 * Their size is the settings' width and height. `with_depth` not 0: each picture comes with a depth. The tracker has a mesh of its own, so
 * `tilemesh_render` goes on as before. It renders the first view once, for its median depth. It keeps the map, the size, `threads` and
 * `exposure` of this call; a new map forgets it. Returns 1, or 0 with an error; an error in the camera leaves the old tracker. */
TILEMESH_C int tilemesh_track_begin(tilemesh_handle* handle, double const* camera, int with_depth);

/* Tracks the next picture: `rgb` has 3 floats a pixel, linear, 0 to 1 (below -0.5 and above 2 are refused); `depth` 1 float a pixel in world
 * units, 0 or NaN where it is not known, or NULL for a tracker without depth. A pixel with a NaN in its colour does not count. `pixels` is
 * the number of pixels, which must be that of the tracker. `seconds` is the time of the picture. `camera` receives the 17 numbers of the
 * camera that was found; NULL: none.
 * Returns 1, or 0 with an error. A frame that is lost is no error: the camera is then a prediction. `tilemesh_report(handle, "track")` says:
 *   {"verdict": "converged" | "weak" | "lost", "why": text, "seconds", "camera": [17 numbers], "mean_cost", "evaluations",
 *    "exposure": {"log_gain", "offset"}, "median_depth"}
 * The page has no tracker (TILEMESH_NOT_BUILT). */
TILEMESH_C int tilemesh_track(tilemesh_handle* handle, float const* rgb, float const* depth, size_t pixels, double seconds, double* camera);

#ifdef __cplusplus
}
#endif
#endif
