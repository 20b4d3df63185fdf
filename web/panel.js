// panel.js - the controls, made from the schema alone.  Shows values and says
// what the hand wants; what is legal is the server's to decide.

// An element with properties, and what is in it.
export function h(tag, props, ...children) {
  const node = Object.assign(document.createElement(tag), props);
  node.append(...children);
  return node;
}

export const short = (x, digits = 5) => +x.toPrecision(digits);
const clamp = (x, lo, hi) => Math.min(hi, Math.max(lo, x));
const near = (a, b) => a === b || Math.abs(a - b) <= 1e-6 * Math.abs(a);
export const same = (a, b) => a && b && a.map && b.map
  ? a.every((x, i) => near(x, b[i])) : near(a, b);

// Slider position 0..1 <-> value.  Where the range is far wider than the
// default, equal ways of the hand are equal ratios above a knee: a slider of
// sigma_a, 0 to 1000, spends half its way on 0 to 5.
function scale({ min, max, type, default: def }) {
  const usual = Math.max(...[def].flat().map((x) => Math.abs(x) || 0));
  const span = max - min;
  const knee = min > 0 && max / min >= 1000 ? min
    : min === 0 && span > 30 * usual ? usual / 5 || span * 1e-4 : 0;
  const k = Math.log1p(span / knee);
  const places = clamp(3 - Math.floor(Math.log10(span)), 0, 6);
  const round = (v) => type === "int" ? Math.round(v)
    : knee ? short(v, 3) : +v.toFixed(places);
  return {
    at: (v) => clamp(knee ? Math.log1p((v - min) / knee) / k : (v - min) / span, 0, 1),
    value: (t) => clamp(round(min + (knee ? knee * Math.expm1(t * k) : t * span)), min, max),
  };
}

// Colours of swatches.  An absorption's is that of white light that crossed a
// fibre, which is two radii thick: e^(-2 sigma).
const encode = (x) => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
const decode = (x) => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
const hex = (rgb) => "#" + rgb.map((x) => Math.round(255 * encode(clamp(x, 0, 1)))
  .toString(16).padStart(2, "0")).join("");
const unhex = (s) => [1, 3, 5].map((i) => decode(parseInt(s.slice(i, i + 2), 16) / 255));
const absorb = { hex: (v) => hex(v.map((x) => Math.exp(-2 * x))),
  unhex: (s) => unhex(s).map((x) => Math.abs(Math.log(Math.max(x, 1e-4)) / 2)) };

// A field for exact numbers.  What is being typed is not overwritten.
function exact(label, change, placeholder) {
  let typing = false;
  const field = h("input", { type: "number", step: "any", className: "field",
    placeholder, ariaLabel: label,
    oninput: () => { typing = true; }, onblur: () => { typing = false; },
    onchange() {
      typing = false;
      change(field.value === "" ? null : +field.value);
    } });
  return { field, show: (v) => {
    if (!typing)
      field.value = v === null ? "" : short(v);
  } };
}

// Slider and field.  ratio(k), if any, is called instead of change(value) when
// the slider is dragged with Shift.
function number(row, label, change, ratio) {
  const map = scale(row);
  const slider = h("input", { type: "range", min: 0, max: 1, step: "any", ariaLabel: label });
  let value = null, shift = false;
  const { field, show } = exact(label + ", exact", (v) =>
    v !== null || row.auto ? change(v) : show(value), "auto");

  function key(e) {
    const way = { ArrowUp: 1, ArrowDown: -1, ArrowRight: 1, ArrowLeft: -1 }[e.key];
    if (!way || (e.target === field && /t$/.test(e.key)))
      return; // left and right move the text's cursor
    e.preventDefault();
    field.onblur();
    const t = map.at(value ?? (row.min + row.max) / 2);
    const v = map.value(clamp(t + way * (e.shiftKey ? 0.001 : 0.01), 0, 1));
    change(v === value ? clamp(v + way, row.min, row.max) : v);
  }
  slider.onkeydown = field.onkeydown = key;
  slider.onpointerdown = (e) => { shift = ratio && e.shiftKey; };
  slider.oninput = () => {
    const v = map.value(+slider.value);
    shift && value > 0 ? ratio(v / value) : change(v);
  };
  return { slider, nodes: [slider, field], show(v) {
    value = v;
    slider.value = v === null ? 0.5 : map.at(v);
    slider.style.setProperty("--t", slider.value);
    slider.ariaValueText = v === null ? "auto" : `${short(v)} ${row.unit}`;
    show(v);
  } };
}

// By type: { nodes in the row's line, lines below it, show(value) }.
const makers = {
  float: number,
  int: number,

  bool(row, label, change) {
    const box = h("input", { type: "checkbox", ariaLabel: label,
      onchange: () => change(box.checked) });
    return { nodes: [box], show: (v) => { box.checked = v; } };
  },

  choice(row, label, change) {
    const buttons = row.choices.map((w) => h("button", { ariaLabel: `${label} ${w}`,
      onclick: () => change(w) }, w));
    return { nodes: [h("div", { className: "segments" }, ...buttons)], show: (v) =>
      buttons.forEach((b) => { b.ariaPressed = b.textContent === v; }) };
  },

  rgb(row, label, change) {
    const paint = row.unit === "1/radius" ? absorb : { hex, unhex };
    const rounded = (rgb) => change(rgb.map((x) => short(clamp(x, row.min, row.max), 4)));
    let value;
    const parts = ["red", "green", "blue"].map((colour, i) => {
      const n = number(row, label + " " + colour,
        (v) => change(value.map((x, j) => j === i ? v ?? x : x)),
        (k) => rounded(value.map((x) => x * k)));
      n.slider.classList.add(colour);
      return n;
    });
    const swatch = h("input", { type: "color", ariaLabel: label + " colour",
      title: paint === absorb ? "Colour of white light that crossed the fibre" : "Colour",
      oninput: () => rounded(paint.unhex(swatch.value)) });
    return { nodes: [swatch], lines: parts.map((n) => n.nodes), show(v) {
      value = v;
      parts.forEach((n, i) => n.show(v[i]));
      swatch.value = paint.hex(v);
    } };
  },

  vec3(row, label, change, ratio, inUse) {
    let value;
    const parts = ["x", "y", "z"].map((axis, i) => exact(label + " " + axis,
      (v) => change((value ?? inUse()).map((x, j) => j === i ? v ?? x : x)), axis));
    return { nodes: [], lines: [parts.map((p) => p.field)], show(v) {
      value = v;
      parts.forEach((p, i) => p.show(v && v[i]));
    } };
  },
};

const undo = (name, onclick) => h("button", { className: "reset", onclick,
  title: "Default", ariaLabel: "Reset " + name }, "↺");
const UNITS = { deg: "°", "1/radius": "1/r", "file units": "units" };

// act: { set(values), inUse(name) a value for an `auto` one, doc(text), holds([name, word]),
// open(group, true or false or undefined) remembers and tells }
export function build(root, schema, act) {
  const rows = new Map(), groups = new Map();

  function add(row, list) {
    const { name, auto } = row;
    const initial = auto ? null : row.default;
    const change = (v) => act.set({ [name]: v }), back = () => change(initial);
    const inUse = () => act.inUse(name) ?? short((row.min + row.max) / 2);
    const { nodes, lines = [], show } = makers[row.type](row, name, change, null, inUse);
    const range = row.min === null ? "" : `, ${row.min} to ${row.max}${row.unit && " " + row.unit}`;
    const text = `${name}${range}, default ${[row.default].flat().join(", ")}.\n${row.doc}.`;
    let value;
    const reset = undo(name, back);
    const unit = auto ? h("button", { className: "auto", title: "Let the renderer choose",
      onclick: () => change(value === null ? inUse() : null), ariaLabel: name + " auto" }, "auto")
      : h("span", { className: "unit", title: row.unit }, UNITS[row.unit] ?? row.unit);
    const node = h("div", { className: "row " + row.type },
      h("span", { className: "name", title: text, ondblclick: back }, name.slice(row.group.length + 1)),
      ...nodes, unit, reset, ...lines.map((l) => h("div", { className: "line" }, ...l)));
    node.onpointerenter = () => act.doc(text);
    node.addEventListener("focusin", node.onpointerenter);
    list.append(node);
    rows.set(name, { node, initial, needs: row.needs, show(v) {
      value = v;
      show(v);
      node.classList.toggle("linked", v === null);
      if (auto)
        unit.ariaPressed = v === null;
      reset.disabled = same(v, initial);
    } });
  }

  function group({ group: name, title }) {
    const list = h("div", { className: "rows", id: "group-" + name });
    const head = h("button", { onclick: () => unfold(act.open(name, list.hidden)) }, title);
    head.setAttribute("aria-controls", list.id);
    const unfold = (on) => {
      head.ariaExpanded = on;
      list.hidden = !on;
    };
    const reset = undo(title, () => act.set(Object.fromEntries([...rows]
      .filter(([n]) => n.startsWith(name + ".")).map(([n, r]) => [n, r.initial]))));
    root.append(h("section", { className: "group" }, h("h2", {}, head, reset), list));
    unfold(act.open(name));
    groups.set(name, { list, reset });
  }

  root.replaceChildren();
  for (const row of schema) {
    if (!groups.has(row.group))
      group(row);
    add(row, groups.get(row.group).list);
  }

  return {
    show(values) {
      for (const [name, value] of Object.entries(values))
        rows.get(name)?.show(value);
      for (const { node, needs } of rows.values())
        node.classList.toggle("idle", !!needs[0] && !needs.some(act.holds));
      for (const { list, reset } of groups.values())
        reset.disabled = !list.querySelector(".reset:enabled");
    },
    wrong(name) { // marks the row that was refused; none: clears
      for (const [n, { node }] of rows)
        node.classList.toggle("wrong", n === name);
    },
  };
}
