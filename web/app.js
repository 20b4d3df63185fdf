// app.js - joins the wire, the panel and the picture.  The server's state is
// the truth; `values` is its mirror with the edits that are on their way.
import { aside, assignments, connect, word } from "./link.js";
import { build, h, same, short } from "./panel.js";
import { hand, orbit, pan, screen, zoom } from "./view.js";

const $ = (id) => document.getElementById(id);
const put = (id, text) => { $(id).textContent = text; };
const pick = (from, test) =>
  Object.fromEntries(Object.entries(from).filter(([k, v]) => test(k, v)));
const SHARED = /^(camera|image|quality|output)\./; // by the looks A and B
const OPEN = ["fibre", "light", "tint", "view"]; // groups, at first

let panel, schema;  // the schema as text, to see whether it changed
let defaults = {};
let values = {};    // null is auto
let revision = 0;   // the newest known of
let used = {};      // what the renderer takes for `auto` values
let frame = null;   // header of the one shown
let stats = null;   // the last reply of that name

let hush = 0;
function say(text, wrong = false, stay = wrong) {
  clearTimeout(hush);
  put("say", text);
  $("say").classList.toggle("wrong", wrong);
  hush = stay ? 0 : setTimeout(() => say(""), 5000);
}
const report = (error) => error.code === "offline" || say(error.message, true);

// Is a group of the panel unfolded?  All that the page remembers of itself.
function open(group, on) {
  try {
    if (on !== undefined)
      localStorage[group] = +on;
    return +(localStorage[group] ?? OPEN.includes(group)) === 1;
  } catch { // storage is forbidden
    return on ?? OPEN.includes(group);
  }
}

// --- edits: all of one animation frame are one request ---
let pending = {};   // not sent yet
let asked = false;  // for an animation frame
let flying = 0;     // sent and not answered
let seq = 0;
const past = [], future = []; // steps { names, before, after, time }

function note(edit) {
  const names = Object.keys(edit).join(), time = performance.now();
  let step = past.at(-1);
  if (step?.names !== names || time - step.time > 700)
    past.push(step = { names, before: pick(values, (k) => k in edit), after: {} });
  Object.assign(step, { time, after: { ...edit } });
  future.length = 0;
}

function set(edit, noted) {
  if (!panel || !link.isUp())
    return say("not connected", true);
  if (!noted)
    note(edit);
  Object.assign(pending, edit);
  show(edit);
  if (!asked)
    requestAnimationFrame(flush);
  asked = true;
}

async function flush() {
  const line = assignments(pending);
  asked = false;
  pending = {};
  flying++;
  try {
    const now = Math.round(performance.now());
    const reply = await link.ask(`set ${line} seq=${++seq} echo=${now}`);
    revision = Math.max(revision, reply.revision);
    panel.wrong();
    if ($("say").className)
      say("");
  } catch (error) {
    report(error);
    panel.wrong(error.name);
    past.pop();
    refresh(true).catch(report);
  }
  flying--;
}

function step(from, to, side) {
  const edit = from.pop();
  to.push({ ...edit, time: 0 });
  set(edit[side], true);
}
const undo = () => past.length && step(past, future, "before");
const redo = () => future.length && step(future, past, "after");

function show(some) {
  Object.assign(values, some);
  panel.show(some);
  streaming();
  $("undo").disabled = !past.length;
  $("redo").disabled = !future.length;
}

// --- the server's state ---
async function refresh(refused) {
  const [is, hello] = await Promise.all([link.ask("get"), link.ask("hello")]);
  if (asked || (flying && !refused))
    return; // the hand was faster
  revision = is.revision;
  show(Object.fromEntries(Object.entries(is.values)
    .map(([k, v]) => [k, v === "auto" && defaults[k] === null ? null : v])));
  for (const verb of ["hair", "env"])
    choosers[verb](hello[verb].name);
}

async function measure() {
  stats = await link.ask("stats").catch(() => stats);
  used = { "camera.up": [0, 0, 1], "camera.eye": stats?.eye, "camera.target": stats?.target };
  times();
}

// Of the output that the state asks for, what can be shown; a quality only when
// it was set: the server's own choice is fast while editing, then fine.
let streamed = "";
function streaming() {
  const [format, quality, chroma] = ["format", "quality", "chroma"]
    .map((x) => values["output." + x]);
  const png = format === "png" || values["view.background"] === "transparent";
  const own = quality !== defaults["output.quality"] || chroma !== defaults["output.chroma"];
  const line = document.hidden ? "stream off" : "stream on window=2 format="
    + (png ? "png" : "jpeg") + (own && !png ? ` quality=${quality} chroma=${chroma}` : "");
  if (line !== streamed)
    link.ask(line).catch(report);
  streamed = line;
}
document.addEventListener("visibilitychange", streaming);

async function begin() {
  const { params } = await link.ask("schema");
  const text = JSON.stringify(params);
  if (text !== schema) {
    defaults = Object.fromEntries(params.map((p) => [p.name, p.auto ? null : p.default]));
    panel = build($("groups"), params, { set, open, inUse: (name) => used[name],
      holds: ([name, word]) => word ? values[name] === word : values[name],
      doc: (doc) => put("doc", doc) });
    schema = text;
  }
  past.length = future.length = 0;
  streamed = "";
  await refresh();
  measure();
}

function lost(is, text) {
  document.body.classList.toggle("lost", is);
  $("banner").hidden = !is;
  $("link").className = is ? "down" : "";
  put("link", text);
}

const link = connect({
  refused: report,
  up() {
    lost(false, "connected");
    say("");
    begin().catch(report);
  },
  down: (wait) => lost(true, `retry in ${wait / 1000} s`),
  frame: screen($("picture"), { shown, failed: (text) => say(text, true),
    done: ({ id }) => link.ask("ack id=" + id).catch(() => {}) }),
});

// --- the status line ---
const ms = (x) => x.toFixed(x < 10 ? 1 : 0);
const size = (x) => x < 1e6 ? ms(x / 1e3) + " kB" : ms(x / 1e6) + " MB";
let later = 0;

function shown({ body, ...head }) {
  const { error, samples, level, governor = "" } = head, before = frame ?? {};
  const wanted = values["quality.samples"] || 1;
  frame = head;
  put("level", `${level} ${samples}/${wanted}`);
  $("progress").value = head.final ? 1 : samples / wanted;
  if (head.render_ms) // not the same picture in better quality
    put("ms", `${ms(head.render_ms)} + ${ms(head.encode_ms)} ms`);
  if (head.echo && head.echo !== before.echo)
    put("trip", `trip ${ms(performance.now() - head.echo)} ms`);
  put("rev", "r" + head.revision);
  put("size", `${head.width} × ${head.height}, ${size(head.bytes)}`);
  put("wrong", error
    ? `error ${ms(100 * error.value)} % ± ${ms(100 * error.ci95)} % of reference` : "");
  put("governor", governor);
  layout();
  times();
  if (head.final || (before.revision !== head.revision && !values["camera.eye"]))
    measure();
  // Somebody else's edit: show it, once this hand rests.
  clearTimeout(later);
  if (head.revision > revision)
    later = setTimeout(() => flying || asked || refresh().catch(report), 150);
}

function times() {
  if ($("times").hidden || !frame || !stats)
    return;
  const { memory, left_out: left, fit: sky, device } = stats;
  const part = (from, f) => [...Object.entries(from)
    .map(([k, v]) => k.padEnd(12) + f(v).padStart(9)), ""];
  put("times", [...part(frame.stages, (x) => ms(x) + " ms"), ...part(memory, size),
    `${sky.lights} lights, error to expect ${short(sky.predicted_error, 2)}`,
    ...left.map((x) => `without ${x.what}: ${x.why}`
      + (x.bound ? ", error up to " + short(x.bound, 2) : "")),
    device].join("\n"));
}
function unfold(on) {
  $("frame").ariaExpanded = on;
  $("times").hidden = !on;
  times();
  $("times").scrollIntoView({ block: "nearest" });
}
$("frame").onclick = () => unfold(open("frame", $("times").hidden));
unfold(open("frame"));

// --- camera and sky ---
function move(how, ...args) {
  const [eye, target, up, fov] = ["eye", "target", "up", "fov"]
    .map((x) => values["camera." + x] ?? used["camera." + x]);
  if (!eye || !target)
    return;
  const to = how({ eye, target, up, fov }, ...args);
  set({ "camera.eye": to.eye, "camera.target": to.target });
}
function sky(degrees) {
  const yaw = values["light.yaw"] + degrees;
  set({ "light.yaw": +(yaw - 360 * Math.round(yaw / 360)).toFixed(2) });
}
const whole = () => set({ "camera.eye": null, "camera.target": null });
hand($("picture"), { sky, frame: whole,
  orbit: (yaw, pitch) => move(orbit, yaw, pitch),
  pan: (dx, dy) => move(pan, dx, dy, $("picture").clientHeight),
  zoom: (factor) => move(zoom, factor) });

// --- the picture's place: filling the stage, or pixel for pixel ---
let fit = false, one = false, resized = 0;

function layout() {
  const { width, height, style } = $("picture"), stage = $("stage");
  const k = fit || one ? 1 / devicePixelRatio
    : Math.min((stage.clientWidth - 24) / width, (stage.clientHeight - 24) / height);
  style.width = width * k + "px";
  style.height = height * k + "px";
  $("fit").ariaPressed = fit;
  $("one").ariaPressed = one;
}
function follow() {
  const pixels = (x) => Math.max(16, Math.round(x * devicePixelRatio));
  const edit = { "image.width": pixels($("stage").clientWidth),
    "image.height": pixels($("stage").clientHeight) };
  if (Object.keys(edit).some((k) => edit[k] !== values[k]))
    set(edit);
}
new ResizeObserver(() => {
  layout();
  clearTimeout(resized);
  if (fit)
    resized = setTimeout(follow, 200);
}).observe($("stage"));
$("fit").onclick = () => {
  fit = !fit;
  document.body.classList.toggle("fit", fit);
  if (fit)
    follow();
  layout();
};
$("one").onclick = () => {
  one = !one;
  layout();
};

// --- groom and sky ---
function chooser(verb) {
  const select = $(verb), path = $(verb + "-path");
  let now;
  function take(source) {
    now = source;
    select.value = source.replace("builtin:", "");
    path.hidden = select.selectedIndex >= 0;
    if (!path.hidden) {
      select.value = "";
      path.value ||= source;
    }
  }
  async function load(source) {
    say("loading " + source, false, true);
    try {
      await aside(`${verb} name=${word(source)}`);
      take(source);
      say("");
    } catch (error) {
      say(error.message, true);
      take(now);
    }
    measure();
  }
  select.onchange = () => {
    path.hidden = !!select.value;
    path.hidden ? load("builtin:" + select.value) : path.focus();
  };
  path.onchange = () => path.value && load(path.value);
  return take;
}
const choosers = { hair: chooser("hair"), env: chooser("env") };

// --- tools ---
const looks = [];
let side = 0;
function compare() {
  const now = looks[side] = pick(values, (k) => !SHARED.test(k));
  side = 1 - side;
  const other = looks[side] ??= now;
  put("ab", "AB"[side]);
  $("ab").ariaPressed = !!side;
  say(other === now ? "B begins as a copy of A" : "look " + "AB"[side]);
  const edit = pick(other, (k, v) => !same(v, now[k]));
  if (Object.keys(edit).length)
    set(edit);
}

async function copy() {
  const edit = pick(values, (k, v) => !same(v, defaults[k]));
  await navigator.clipboard.writeText("set " + assignments(edit));
  say("state copied");
}
document.addEventListener("paste", (e) => {
  const line = e.clipboardData.getData("text").trim().split("\n")[0];
  if (!e.target.matches("input") && line.startsWith("set "))
    link.ask(line).then(() => refresh()).catch(report);
});

async function save(e) {
  const button = e.target, format = button.id;
  button.disabled = true;
  say("finishing the picture", false, true);
  try {
    const { frame: head, body } = await aside("capture format=" + format);
    const href = URL.createObjectURL(new Blob([body]));
    h("a", { href, download: `glint-r${head.revision}.${format}` }).click();
    setTimeout(() => URL.revokeObjectURL(href), 10000);
    say(`saved r${head.revision}, ${size(body.length)}`);
  } catch (error) {
    say(error.message, true);
  }
  button.disabled = false;
}

const help = () => $("help").showModal();
for (const [id, f] of Object.entries({ undo, redo, ab: compare, keys: help,
  copy: () => copy().catch(report), png: save, exr: save }))
  $(id).onclick = f;

const KEYS = { f: whole, b: compare, c: $("copy").onclick, 1: $("one").onclick,
  "?": help, "[": () => sky(-5), "]": () => sky(5),
  h: () => document.body.classList.toggle("bare") };
document.addEventListener("keydown", (e) => {
  const control = e.ctrlKey || e.metaKey;
  const f = control ? e.key.toLowerCase() === "z" && (e.shiftKey ? redo : undo) : KEYS[e.key];
  if (!f || e.altKey || !panel || $("help").open
      || e.target.matches("select, input:not([type=range], [type=checkbox], [type=radio])"))
    return;
  e.preventDefault();
  f();
});
