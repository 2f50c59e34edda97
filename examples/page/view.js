// The camera of the page: a place, three angles, and the distance to the point that it turns about.
// The axes are OpenCV's: x right, y down, z forward. Angles are in degrees, lengths in units of the map.

const radians = Math.PI / 180;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const along = (a, b, k) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];

// The unit vectors of a view in the world: right, down, forward.
function axes({yaw, pitch, roll}) {
  const cy = Math.cos(yaw * radians), sy = Math.sin(yaw * radians);
  const cp = Math.cos(pitch * radians), sp = Math.sin(pitch * radians);
  const forward = [sy * cp, sp, cy * cp], level = [cy, 0, -sy], below = cross(forward, level);
  const cr = Math.cos(roll * radians), sr = Math.sin(roll * radians);
  const right = along([cr * level[0], cr * level[1], cr * level[2]], below, sr);
  return {right, down: cross(forward, right), forward};
}

// The 17 numbers of `tilemesh_render` for a picture of this size.
function cameraOf(view, [width, height]) {
  const {right, down, forward} = axes(view), focal = width / 2 / Math.tan(view.fov / 2 * radians);
  return [...right, ...down, ...forward, ...view.position, focal, focal, width / 2, height / 2, view.near];
}

// The view of such numbers: rows of the rotation, place, and what `rest` says of distance, fov and near.
function viewOf(camera, rest) {
  const right = camera.slice(0, 3), forward = camera.slice(6, 9);
  const pitch = Math.asin(Math.max(-1, Math.min(1, forward[1])));
  const yaw = Math.atan2(forward[0], forward[2]);
  const level = [Math.cos(yaw), 0, -Math.sin(yaw)], below = cross(forward, level);
  const roll = Math.atan2(dot(right, below), dot(right, level));
  return rounded({...rest, position: camera.slice(9, 12), yaw: yaw / radians, pitch: pitch / radians, roll: roll / radians});
}

// The view with which a map begins: its start camera, which turns about the map's middle.
function startView(map) {
  const forward = map.start.slice(6, 9), to = along(map.target, map.start.slice(9, 12), -1);
  const ahead = dot(to, forward), away = Math.hypot(...to);
  return viewOf(map.start, {distance: ahead > 0.1 * away ? ahead : away || 1, near: map.start[16],
                            fov: 2 * Math.atan(map.width / 2 / map.start[12]) / radians});
}

// A view is kept with as many digits as a link has, so that a link shows exactly the same picture.
function rounded(view) {
  const digits = x => Number(x.toPrecision(7)), angle = x => Number(x.toFixed(3)) + 0;
  const turn = x => angle(((x + 180) % 360 + 360) % 360 - 180);
  return {position: view.position.map(digits), yaw: turn(view.yaw), pitch: angle(view.pitch), roll: turn(view.roll),
          distance: digits(view.distance), fov: digits(view.fov), near: digits(view.near)};
}

// Turns the camera about the point in front of it.
function turned(view, yaw, pitch) {
  const target = along(view.position, axes(view).forward, view.distance);
  const upright = Math.cos(view.roll * radians) < 0 ? -1 : 1; // an upside-down camera turns the other way
  const next = {...view, yaw: view.yaw + upright * yaw, pitch: Math.max(-89, Math.min(89, view.pitch + upright * pitch))};
  next.position = along(target, axes(next).forward, -view.distance);
  return rounded(next);
}

// Moves the camera along its own axes.
function moved(view, right, down, forward) {
  const a = axes(view);
  return rounded({...view, position: along(along(along(view.position, a.right, right), a.down, down), a.forward, forward)});
}

// Comes closer to the point that the camera turns about: 0.5 halves the distance.
function closer(view, factor) {
  const distance = Math.min(1e6, Math.max(1e-4, view.distance * factor));
  return rounded({...view, distance, position: along(view.position, axes(view).forward, view.distance - distance)});
}

function upsideDown(view) {
  return rounded({...view, roll: view.roll + 180});
}

// A view as the text of a link, and back; null for a text that is none.
function viewText(view) {
  return [...view.position, view.yaw, view.pitch, view.roll, view.distance, view.fov, view.near].join(",");
}
function viewFromText(text) {
  const n = (text ?? "").split(",").map(word => word.trim() === "" ? NaN : Number(word));
  if (n.length !== 9 || !n.every(x => Math.abs(x) < 1e9) || n[6] < 1e-9 || n[7] < 1 || n[7] > 170 || n[8] < 1e-9) return null;
  return rounded({position: n.slice(0, 3), yaw: n[3], pitch: n[4], roll: n[5], distance: n[6], fov: n[7], near: n[8]});
}
