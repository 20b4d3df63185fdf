// link.js - the wire: one WebSocket, requests with their replies, frames, and
// coming back after a loss.  Knows no parameter and no element of the page.
const DELAYS = [250, 500, 1000, 2000, 4000]; // ms before the next try
const SILENT = 20000; // ms without a message: the connection is taken for dead

const token = new URLSearchParams(location.hash.slice(1)).get("token");
const greeting = "hello" + (token ? " token=" + word(token) : "");
const offline = Object.assign(new Error("not connected"), { code: "offline" });

// A value as the line protocol writes it; null is auto.
export function word(value) {
  if (Array.isArray(value))
    return value.map(word).join();
  if (typeof value === "number")
    return String(+value.toPrecision(7));
  value = String(value ?? "auto");
  return /^[^\s"\\=]+$/.test(value) ? value
    : '"' + value.replace(/["\\]/g, "\\$&") + '"';
}
export const assignments = (values) =>
  Object.entries(values).map(([k, v]) => k + "=" + word(v)).join(" ");

function dial() {
  const url = new URL("ws", location.origin + location.pathname);
  const socket = new WebSocket(url.href.replace(/^http/, "ws"));
  socket.binaryType = "arraybuffer";
  return socket;
}

// A text message is JSON; a binary one a line of JSON and what it announces.
function read(data) {
  if (typeof data === "string")
    return JSON.parse(data);
  const bytes = new Uint8Array(data), end = bytes.indexOf(10);
  return { ...JSON.parse(new TextDecoder().decode(bytes.subarray(0, end))),
    body: bytes.subarray(end + 1) };
}
const failure = ({ error }) => Object.assign(new Error(error.text), error);

// on: { up(), down(ms until the next try), refused(error),
//       frame(its header with body) }
export function connect(on) {
  const waiting = new Map();
  let socket, tag = 0, tries = 0, timer = 0, heard = 0;
  const isUp = () => socket.readyState === WebSocket.OPEN;

  // A promise of the reply, rejected with the error when it is a refusal.
  const ask = (line) => new Promise((yes, no) => {
    if (!isUp())
      return no(offline);
    waiting.set(String(++tag), (reply) =>
      reply.ok ? yes(reply) : no(reply.error ? failure(reply) : offline));
    socket.send(`#${tag} ${line}`);
  });

  function open() {
    clearTimeout(timer);
    timer = 0;
    const mine = socket = dial();
    mine.onopen = () => ask(greeting).then(() => {
      tries = 0;
      on.up();
    }, on.refused);
    mine.onmessage = ({ data }) => {
      heard = performance.now();
      const { frame, body, ...reply } = read(data);
      if (frame)
        return on.frame({ ...frame, body });
      if (reply.event)
        on.refused(failure(reply)); // of the renderer, not of a request
      waiting.get(reply.tag)?.(reply);
      waiting.delete(reply.tag);
    };
    mine.onclose = () => {
      for (const answer of waiting.values())
        answer({});
      waiting.clear();
      const wait = DELAYS[Math.min(tries++, DELAYS.length - 1)];
      timer = setTimeout(open, wait);
      on.down(wait);
    };
  }
  document.addEventListener("visibilitychange", () => timer && open());

  // A laptop that slept has sockets that never close: ask now and then.
  setInterval(() => {
    const quiet = performance.now() - heard;
    if (isUp() && quiet > SILENT)
      socket.close();
    else if (isUp() && quiet > SILENT / 3)
      ask("ping").catch(() => {});
  }, 3000);

  open();
  return { ask, isUp };
}

// One request on a connection of its own, for what takes long: replies come in
// order, and the page's edits must not wait behind a capture or a file.
export const aside = (line) => new Promise((yes, no) => {
  const socket = dial();
  let greeted = false;
  socket.onopen = () => [greeting, line].forEach((l) => socket.send(l));
  socket.onclose = () => no(offline);
  socket.onmessage = ({ data }) => {
    const reply = read(data);
    if (reply.ok && !greeted) {
      greeted = true;
      return;
    }
    reply.ok ? yes(reply) : no(failure(reply));
    socket.close();
  };
});
