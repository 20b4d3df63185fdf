// view.js - the picture: frames onto the canvas in order, and the hand on it.
// Cameras are { eye, target, up, fov } in the world's units.

const add = (a, b, k = 1) => a.map((x, i) => x + k * b[i]);
const mul = (a, k) => a.map((x) => x * k);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => mul(a, 1 / (Math.hypot(...a) || 1));
// Turns v about the unit axis k by t radians.
const turn = (v, k, t) => add(add(mul(v, Math.cos(t)), cross(k, v), Math.sin(t)),
  k, dot(k, v) * (1 - Math.cos(t)));

export function orbit({ eye, target, up }, yaw, pitch) {
  up = unit(up);
  const from = turn(add(eye, target, -1), up, yaw);
  const now = Math.acos(dot(unit(from), up));
  // Short of the poles, where left and right would change places.
  const then = Math.min(Math.PI - 0.02, Math.max(0.02, now + pitch));
  return { eye: add(target, turn(from, unit(cross(up, from)), then - now)), target };
}

// By dx, dy of a picture of that height, at the target's distance.
export function pan({ eye, target, up, fov }, dx, dy, height) {
  const back = add(eye, target, -1);
  const right = unit(cross(up, back)), rise = unit(cross(back, right));
  const k = 2 * Math.hypot(...back) * Math.tan(fov * Math.PI / 360) / height;
  const shift = add(mul(right, -k * dx), rise, k * dy);
  return { eye: add(eye, shift), target: add(target, shift) };
}

export const zoom = ({ eye, target }, factor) =>
  ({ eye: add(target, add(eye, target, -1), factor), target });

// Returns what takes a frame.  One is decoded at a time; of those that come
// meanwhile the last is kept.
// on: { shown(frame), done(frame) shown or dropped, failed(text) }
export function screen(canvas, on) {
  const paper = canvas.getContext("2d");
  let next = null, busy = false;

  async function draw(frame) {
    try {
      const bitmap = await createImageBitmap(
        new Blob([frame.body], { type: "image/" + frame.format }));
      const { width, height } = bitmap;
      if (canvas.width !== width || canvas.height !== height)
        Object.assign(canvas, { width, height });
      paper.globalCompositeOperation = "copy";
      paper.drawImage(bitmap, 0, 0);
      bitmap.close();
      on.shown(frame);
    } catch {
      on.failed(`a frame in ${frame.format} could not be shown`);
    }
    on.done(frame);
  }

  return async (frame) => {
    if (next)
      on.done(next);
    next = frame;
    if (busy)
      return;
    busy = true;
    while (next) {
      const now = next;
      next = null;
      await draw(now);
    }
    busy = false;
  };
}

const TURN = 0.008; // radians per CSS pixel
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// act: { orbit(yaw, pitch), pan(dx, dy), zoom(factor), sky(degrees), frame() }
export function hand(canvas, act) {
  const fingers = new Map();
  let button = 0;
  const on = (type, f) => canvas.addEventListener(type, f, { passive: false });

  function drag(e, dx, dy) {
    if (e.shiftKey && !button)
      act.sky(dx * 0.4);
    else if (button || e.ctrlKey || e.metaKey)
      act.pan(dx, dy);
    else
      act.orbit(-dx * TURN, -dy * TURN);
  }

  on("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    canvas.focus();
    button = e.button;
    fingers.set(e.pointerId, e);
    e.preventDefault();
  });
  on("pointermove", (e) => {
    const was = fingers.get(e.pointerId);
    if (!was)
      return;
    const dx = e.clientX - was.clientX, dy = e.clientY - was.clientY;
    if (fingers.size === 1)
      drag(e, dx, dy);
    else if (fingers.size === 2) {
      const other = [...fingers.values()].find((f) => f !== was);
      const apart = (f) => Math.hypot(f.clientX - other.clientX, f.clientY - other.clientY) + 1;
      act.pan(dx / 2, dy / 2);
      act.zoom(apart(was) / apart(e));
    }
    fingers.set(e.pointerId, e);
  });
  for (const end of ["pointerup", "pointercancel"])
    on(end, (e) => fingers.delete(e.pointerId));
  on("contextmenu", (e) => e.preventDefault());
  on("dblclick", act.frame);
  on("wheel", (e) => {
    e.preventDefault();
    const way = e.deltaY * (e.deltaMode ? 30 : 1); // lines or pixels
    act.zoom(Math.exp(Math.max(-200, Math.min(200, way)) * 0.0015));
  });
  on("keydown", (e) => {
    const [x, y] = ARROWS[e.key] ?? [];
    if (x !== undefined && e.shiftKey)
      act.pan(-x * 24, -y * 24);
    else if (x !== undefined)
      act.orbit(x * 0.1, y * 0.1);
    else if (e.key === "+" || e.key === "=")
      act.zoom(0.9);
    else if (e.key === "-")
      act.zoom(1 / 0.9);
    else
      return;
    e.preventDefault();
  });
}
