// drive.mjs - uses the page as a person would and looks at what comes of it.
// Environment: GLINTD, CHROMIUM, ROOT (of the tree); see test_browser.py.
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const { GLINTD, CHROMIUM, ROOT } = process.env;
const SLOW = process.env.GLINT_SAN ? 6 : 1; // sanitized code is that much slower
const WAIT = 10000 * SLOW; // ms; the longest that one thing may take
const WEIGHT = 40000;      // bytes that the whole page may have
const profile = mkdtempSync(join(tmpdir(), "glint-browser-"));
const sleep = (ms) => new Promise((f) => setTimeout(f, ms));

const shots = join(ROOT, "build");
mkdirSync(shots, { recursive: true });

let failed = 0;
async function test(name, body) {
  try {
    await body();
    console.log("ok browser_" + name);
  } catch (error) {
    failed++;
    console.log("not ok browser_" + name + "\n" + error.stack);
  }
}
function check(good, ...said) {
  if (!good)
    throw new Error(said.join(" "));
}
async function until(what, ask) {
  const end = Date.now() + WAIT;
  for (let last; ; await sleep(50)) {
    const is = await ask();
    if (is && is.ok !== false)
      return is;
    last = is;
    check(Date.now() < end, "waited", WAIT, "ms in vain:", what, JSON.stringify(last));
  }
}

// --- the daemon ----------------------------------------------------------------
let daemon = null;
// Resolves with the address that it prints.
function serve(port) {
  return new Promise((yes, no) => {
    daemon = spawn(GLINTD, ["serve", "--listen", "127.0.0.1:" + port,
      "--hair", "builtin:ponytail", "--size", "240x160",
      "--set", "shadow.rays=0", "--set", "render.multiple=off",
      "--set", "quality.samples=4"], { stdio: ["ignore", "pipe", "pipe"] });
    let out = "", errors = "";
    daemon.stdout.on("data", (d) => {
      out += d;
      const at = /listening (http:\S+)/.exec(out);
      if (at)
        yes(at[1]);
    });
    daemon.stderr.on("data", (d) => { errors += d; });
    daemon.on("exit", (code) => no(new Error(`glintd ended (${code}): ${errors}`)));
    daemon.on("error", no);
    setTimeout(() => no(new Error("glintd does not listen: " + errors)), WAIT).unref();
  });
}
async function kill(signal) { // resolves with the exit status
  const gone = new Promise((f) => daemon.on("exit", f));
  daemon.kill(signal);
  return gone;
}

// --- the page ------------------------------------------------------------------
const url = await serve(0);
const browser = await chromium.launchPersistentContext(profile, {
  executablePath: CHROMIUM, timeout: 30000, acceptDownloads: true,
  viewport: { width: 1280, height: 800 }, hasTouch: true,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
await browser.grantPermissions(["clipboard-read", "clipboard-write"]);
const page = browser.pages()[0] ?? await browser.newPage();
page.setDefaultTimeout(WAIT);
const complaints = [];
let down = false; // while the daemon is, a browser complains and may
page.on("console", (m) => {
  if (m.type() === "error" && !down)
    complaints.push(m.text());
});
page.on("pageerror", (e) => complaints.push(e.stack));
const weights = new Map();
page.on("response", async (r) => weights.set(new URL(r.url()).pathname,
  (await r.body().catch(() => "")).length));
await page.addInitScript(() => {
  window.violations = [];
  addEventListener("securitypolicyviolation",
    (e) => window.violations.push(e.violatedDirective + " " + e.blockedURI));
  window.snaps = {};
});

const text = (id) => page.textContent("#" + id);
const revision = async () => +(await text("rev")).slice(1);
// Waits for the final picture of a revision after `old`, then for quiet: the
// last frame of a state may come again in better quality, 0.3 s after the edit.
async function settled(old, quiet = 400) {
  let before = "", since = 0;
  await until("a final picture after revision " + old, async () => {
    const now = [await text("rev"), await text("level"), await text("size")].join();
    if (now !== before)
      since = Date.now();
    before = now;
    const [, is] = /^r(\d+),final/.exec(now) ?? [];
    return { ok: is > old && Date.now() - since > quiet, now };
  });
}
const snap = (name) => page.evaluate((n) => {
  const c = document.getElementById("picture");
  window.snaps[n] = c.getContext("2d").getImageData(0, 0, c.width, c.height);
}, name);
// Mean difference in levels (0 to 255) over the pixels that differ from the
// corner in either: the hair.  Another size counts as wholly different.
const differ = (a, b) => page.evaluate(([x, y]) => {
  const p = window.snaps[x], q = window.snaps[y];
  if (p.width !== q.width || p.height !== q.height)
    return 255;
  let sum = 0, hair = 0;
  for (let i = 0; i < p.data.length; i += 4) {
    let off = 0, d = 0;
    for (let c = 0; c < 3; c++) {
      off = Math.max(off, Math.abs(p.data[i + c] - p.data[c]), Math.abs(q.data[i + c] - q.data[c]));
      d += Math.abs(p.data[i + c] - q.data[i + c]) / 3;
    }
    if (off > 12) {
      hair++;
      sum += d;
    }
  }
  return hair ? sum / hair : 0;
}, [a, b]);
const covered = (name) => page.evaluate((n) => {
  const { data } = window.snaps[n];
  let hair = 0;
  for (let i = 0; i < data.length; i += 4)
    hair += Math.max(...[0, 1, 2].map((c) => Math.abs(data[i + c] - data[c]))) > 12;
  return 4 * hair / data.length;
}, name);
const control = (label) => page.getByLabel(label, { exact: true });

// Does something, and reports by how much the settled picture changed.
async function change(act) {
  const old = await revision();
  await snap("before");
  await act();
  await settled(old);
  await snap("after");
  return differ("before", "after");
}
async function drag(dx, dy, options = {}) {
  const box = await page.locator("#picture").boundingBox();
  const x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.mouse.move(x, y);
  await page.mouse.down(options);
  for (let i = 1; i <= 8; i++) {
    await page.mouse.move(x + dx * i / 8, y + dy * i / 8);
    await sleep(16);
  }
  await page.mouse.up(options);
}
// More than compression and samples can do: an unchanged state gives 0.
const CLEAR = 3; // levels

const response = await page.goto(url);

await test("security_policy", async () => {
  const csp = response.headers()["content-security-policy"] ?? "";
  for (const part of ["default-src 'self'", "img-src 'self' blob:", "connect-src 'self'"])
    check(csp.includes(part), part, "is not in", csp);
});

await test("picture_appears", async () => {
  await settled(0, 1500); // with the frame of better quality: undo_and_reset
  await snap("first");
  const share = await covered("first");
  check(share > 0.02 && share < 0.9, "share of pixels with hair:", share);
  check(await page.evaluate(() => document.getElementById("picture").width) === 240);
});

await test("page_weight", async () => {
  const got = [...weights.values()].reduce((a, b) => a + b, 0);
  const dir = join(ROOT, "web");
  const here = readdirSync(dir).reduce((a, f) => a + statSync(join(dir, f)).size, 0);
  check(got > 0 && got < WEIGHT, "served", got, "bytes");
  check(here < WEIGHT, "web/ has", here, "bytes");
});

await test("controls_of_every_parameter", async () => {
  const table = readFileSync(join(ROOT, "protocol/params.def"), "utf8");
  const want = table.match(/^ +(FLOAT|AUTO|INT|BOOL|CHOICE|RGB|VEC3)\b/gm).length;
  const got = await page.locator("#groups .row").count();
  check(got === want, "rows:", got, "parameters:", want);
});

await test("status_line", async () => {
  check(/^r\d+$/.test(await text("rev")), await text("rev"));
  check(/^[\d.]+ \+ [\d.]+ ms$/.test(await text("ms")), await text("ms"));
  check(/^240 × 160, [\d.]+ [kM]B$/.test(await text("size")), await text("size"));
  check(/^final \d+\/4$/.test(await text("level")), await text("level"));
});

await test("says_how_wrong_it_is", async () => {
  await until("the error against path tracing", async () => {
    const now = await text("wrong");
    return { ok: /^error [\d.]+ % ± [\d.]+ % of reference$/.test(now), now };
  });
});

await test("slider_drag_changes_picture", async () => {
  const slider = control("fibre.sigma_a red");
  const box = await slider.boundingBox();
  const d = await change(async () => {
    await page.mouse.move(box.x + box.width * 0.15, box.y + box.height / 2);
    await page.mouse.down();
    for (let i = 0; i <= 10; i++)
      await page.mouse.move(box.x + box.width * (0.15 + 0.03 * i), box.y + box.height / 2);
    await page.mouse.up();
  });
  const is = +await control("fibre.sigma_a red, exact").inputValue();
  check(is > 0.5 && is < 20, "sigma_a red is", is);
  check(d > CLEAR, "the picture changed by", d);
  check(/trip \d/.test(await text("trip")), "no round trip:", await text("trip"));
});

await test("slider_keys_change_picture", async () => {
  const slider = control("fibre.beta_r");
  await slider.focus();
  const d = await change(async () => {
    for (let i = 0; i < 20; i++)
      await slider.press("ArrowRight");
  });
  const is = +await control("fibre.beta_r, exact").inputValue();
  check(Math.abs(is - 7.5 - 20 * 0.599) < 0.5, "beta_r is", is);
  check(d > CLEAR, "the picture changed by", d);
});

await test("undo_and_reset", async () => {
  let d = await change(() => page.click("#undo"));
  check(d > CLEAR, "undo changed the picture by", d);
  check(await control("fibre.beta_r, exact").inputValue() === "7.5");
  d = await change(() => control("Reset fibre.sigma_a").click());
  check(d > CLEAR, "reset changed the picture by", d);
  // Byte for byte, as soon as the frame of better quality is there as well.
  await until("the first state's picture again", async () => {
    await snap("after");
    d = await differ("first", "after");
    return { ok: d === 0, now: "it differs by " + d };
  });
});

await test("auto_swatch_and_ratio", async () => {
  const value = async (name) => control(name + ", exact").inputValue();
  const known = async (name, is) => until(name + " " + is, async () => await value(name) === is);
  await control("fibre.alpha_tt auto").click();
  await known("fibre.alpha_tt", "0");
  await control("fibre.alpha_tt auto").click();
  await known("fibre.alpha_tt", "");
  check(await control("fibre.alpha_tt auto").getAttribute("aria-pressed") === "true");
  // The swatch of absorption is e^(-2 sigma) as sRGB: #bc is 0.5029 linear.
  await control("fibre.sigma_a colour").fill("#bcbcbc");
  for (const c of ["red", "green", "blue"])
    await known("fibre.sigma_a " + c, "0.3437");
  await control("fibre.sigma_a red, exact").fill("0.6874");
  await control("fibre.sigma_a red, exact").press("Enter");
  const box = await control("fibre.sigma_a blue").boundingBox();
  await page.keyboard.down("Shift");
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const [red, blue] = [await value("fibre.sigma_a red"), await value("fibre.sigma_a blue")];
  check(blue > 2 && Math.abs(red / blue - 2) < 0.01, "red", red, "blue", blue);
  const old = await revision();
  await control("Reset Fibre").click();
  await settled(old);
});

await test("refused_value_leaves_picture", async () => {
  await snap("before");
  const old = await revision();
  const field = control("fibre.eta, exact");
  await field.fill("9");
  await field.press("Enter");
  await until("an error", async () => (await text("say")).includes("fibre.eta"));
  const said = await text("say");
  check(/9 .*1\.05.*3/.test(said), said);
  await until("the true value", async () => await field.inputValue() === "1.55");
  await sleep(300);
  await snap("after");
  check(await differ("before", "after") === 0, "the picture changed");
  check(await revision() === old, "the revision changed");
});

await test("orbit_pan_zoom_sky", async () => {
  for (const [name, act] of Object.entries({
    orbit: () => drag(90, 20), pan: () => drag(60, 30, { button: "middle" }),
    zoom: () => page.mouse.wheel(0, -400),
    async sky() {
      await page.keyboard.down("Shift");
      await drag(200, 0);
      await page.keyboard.up("Shift");
    },
  })) {
    const d = await change(act);
    check(d > CLEAR, name, "changed the picture by", d);
  }
  check(+await control("light.yaw, exact").inputValue() === 80, "yaw after 200 pixels",
    await control("light.yaw, exact").inputValue());
  const d = await change(async () => {
    await control("Reset light.yaw").click();
    await page.locator("#picture").dblclick();
  });
  check(d > CLEAR, "framing changed the picture by", d);
  check(await differ("first", "after") === 0, "the first view again, and yet it differs");
});

await test("touch", async () => {
  const cdp = await browser.newCDPSession(page);
  const box = await page.locator("#picture").boundingBox();
  const x = box.x + box.width / 2, y = box.y + box.height / 2;
  const send = (type, ...points) => cdp.send("Input.dispatchTouchEvent",
    { type, touchPoints: points.map(([px, py], id) => ({ x: px, y: py, id })) });
  let d = await change(async () => {
    await send("touchStart", [x, y]);
    for (let i = 1; i < 9; i++)
      await send("touchMove", [x + i * 10, y]);
    await send("touchEnd");
  });
  check(d > CLEAR, "one finger changed the picture by", d);
  d = await change(async () => {
    await send("touchStart", [x - 40, y], [x + 40, y]);
    for (let i = 1; i < 9; i++)
      await send("touchMove", [x - 40 - i * 8, y], [x + 40 + i * 8, y]);
    await send("touchEnd");
  });
  check(d > CLEAR, "a pinch changed the picture by", d);
  await change(() => page.keyboard.press("f"));
  check(await differ("first", "after") === 0, "key f did not frame the groom");
});

const elsewhere = (line) => page.evaluate(([at, said]) => { // by another client
  const s = new WebSocket(at.replace("http", "ws") + "ws");
  s.onopen = () => s.send(said);
}, [url, line]);
await test("edit_of_another_client_shows", async () => {
  await change(() => elsewhere("set fibre.w_c=21.5"));
  await until("21.5", async () => await control("fibre.w_c, exact").inputValue() === "21.5");
});

await test("says_what_the_governor_chose", async () => {
  const told = async (want) => until("a line like " + want, async () => {
    const now = await text("governor");
    return { ok: want.test(now), now };
  });
  check(await text("governor") === "", "off, and yet:", await text("governor"));
  await snap("plain");
  // of a front that ships with the program: fewer lights, and why
  await change(() => elsewhere("set quality.budget_ms=1"));
  await told(/^quality\.budget_ms=1: .*sky\.lights=\d+.* \([a-z :]+\)$/);
  check(await page.locator("#governor").isVisible(), "not to be seen");
  await page.screenshot({ path: join(shots, "browser_governor.png") });
  await change(() => elsewhere("set quality.budget_ms=0"));
  check(await differ("plain", "after") === 0, "off again, and yet it differs");
  await told(/^$/);
});

await test("what_moves_nothing_is_dim", async () => {
  const dim = async (name) => +await control(name).evaluate((e) =>
    getComputedStyle(e.closest(".row")).opacity) < 1;
  check(await dim("fibre.k_g"), "k_g is of a reference alone");
  check(await dim("fibre.d_f"), "d_f, without multiple scattering");
  check(!await dim("fibre.eta"), "eta");
  await change(() => elsewhere("set render.multiple=best shadow.method=crossings"));
  check(!await dim("fibre.d_f"), "d_f, with multiple scattering");
  check(await dim("fibre.k_g"), "k_g still is");
  await change(() => elsewhere("set render.multiple=off"));
  check(await dim("fibre.d_f"), "d_f, without it again");
});

await test("looks_a_and_b_and_copy", async () => {
  const eta = control("fibre.eta, exact");
  await page.click("#ab");
  await change(() => control("fibre.eta").focus().then(() => page.keyboard.press("End")));
  check(await eta.inputValue() === "3", "End sets", await eta.inputValue());
  await page.click("#copy");
  const line = await page.evaluate(() => navigator.clipboard.readText());
  check(/^set .*\bfibre\.eta=3\b/.test(line) && !line.includes("sigma_a"), line);
  await change(() => page.click("#ab"));
  check(await eta.inputValue() === "1.55", "A has", await eta.inputValue());
  await snap("a");
  const d = await change(() => page.click("#ab"));
  check(await eta.inputValue() === "3" && d > CLEAR, "B has", await eta.inputValue(), "changed by", d);
  await change(() => page.click("#ab"));
  check(await differ("a", "after") === 0, "A is not what it was");
});

await test("capture_png_and_exr", async () => {
  for (const [id, magic] of [["png", "89504e470d0a1a0a"], ["exr", "762f3101"]]) {
    const [file] = await Promise.all([page.waitForEvent("download"), page.click("#" + id)]);
    const bytes = readFileSync(await file.path());
    check(bytes.toString("hex").startsWith(magic), id, "begins with",
      bytes.subarray(0, 8).toString("hex"));
    check(file.suggestedFilename().endsWith("." + id), file.suggestedFilename());
    if (id === "png")
      check(bytes.readUInt32BE(16) === 240 && bytes.readUInt32BE(20) === 160, "size of the PNG");
  }
});

await test("groom_is_changed", async () => {
  const d = await change(() => page.selectOption("#hair", { index: 2 }));
  check(d > CLEAR, "another groom changed the picture by", d);
});

await test("layouts", async () => {
  for (const [width, height] of [[1280, 800], [768, 1024], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await sleep(200);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    check(wide <= width, "a page", width, "wide scrolls sideways to", wide);
    for (const id of ["#picture", "#panel", "#status"]) {
      const box = await page.locator(id).boundingBox();
      check(box && box.x >= 0 && box.x + box.width <= width + 1 && box.height > 20,
        id, "at", width, JSON.stringify(box));
    }
  }
  await change(() => page.click("#fit"));
  const [a, b] = await page.evaluate(() => ["picture", "stage"].map((id) =>
    document.getElementById(id)).map((e) => [e.clientWidth, e.clientHeight].join()));
  check(a === b, "fit: the picture has", a, "the stage", b);
  await page.click("#fit");
  await change(() => page.click("#undo"));
  await page.setViewportSize({ width: 1280, height: 800 });
});

await test("no_complaints", async () => {
  check(complaints.length === 0, complaints.join("\n"));
  const violations = await page.evaluate(() => window.violations);
  check(violations.length === 0, violations.join("\n"));
});

await test("reconnects_by_itself", async () => {
  down = true;
  await kill("SIGKILL");
  await until("the loss to show", async () => (await page.getAttribute("#link", "class")) === "down");
  check(await page.isVisible("#banner"), "no banner");
  await snap("before");
  check(await covered("before") > 0.02, "the last picture went away");
  await serve(new URL(url).port);
  await until("connected", async () => await text("link") === "connected");
  down = false;
  await until("the server's state", async () =>
    await control("fibre.w_c, exact").inputValue() === "10");
  await until("its first picture", async () => await revision() === 1);
  await settled(0);
  await snap("after");
  check(await differ("first", "after") === 0, "the first state again, and yet it differs");
  const d = await change(() => control("fibre.sigma_a blue, exact").fill("9")
    .then(() => page.keyboard.press("Enter")));
  check(d > CLEAR, "after reconnecting, an edit changed the picture by", d);
  check(complaints.length === 0, complaints.join("\n"));
});

await page.screenshot({ path: join(shots, "browser.png") });

await test("daemon_ends_in_order", async () => { // with a viewer connected
  down = true;
  const late = sleep(WAIT).then(() => "no end within " + WAIT + " ms");
  const status = await Promise.race([kill("SIGTERM"), late]);
  check(status === 0, "exit status after SIGTERM:", status);
});
daemon.kill("SIGKILL");
await browser.close();
rmSync(profile, { recursive: true, force: true });
process.exit(failed ? 1 : 0);
