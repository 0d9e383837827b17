// The clock and the controls.

const player = { time: run.start, playing: false, rate: 1, last: 0 };
const rates = Array.from(element("rate").options, (option) => Number(option.value));

const seek = (time) => {
  player.time = clamp(time, run.start, run.stop);
  wake();
};
let awake = false;
function wake() {
  if (awake) return;
  awake = true;
  requestAnimationFrame(tick);
}

function tick(now) {
  awake = false;
  if (player.playing) {
    const passed = clamp((now - player.last) / 1000, 0, 0.25);
    player.last = now;
    player.time = Math.min(run.stop, player.time + passed * player.rate);
    if (player.time >= run.stop) setPlaying(false);
  }
  draw();
  if (player.playing) wake();
}

function draw() {
  const sample = sampleAt(player.time);
  drawScene(element("scene"), player.time);
  for (const chart of charts) chart.draw(player.time, sample);
  element("scrubber").value = player.time;
  element("scrubber").setAttribute("aria-valuetext", fixed(player.time, 1) + " s");
  element("time").value = fixed(player.time, 2);
  const [vx, vy] = [mix(run.velocity[0], sample), mix(run.velocity[1], sample)];
  element("speed").value = fixed((vx < 0 ? -1 : 1) * Math.hypot(vx, vy), 2);
  if (run.error) element("error").value = fixed(mix(run.error, sample), 2);
  else element("heading").value = fixed((180 / Math.PI) * mixAngle(run.pose[2], sample), 1);
  drawWord("status", sample.i);
  drawWord("health", sample.i);
  if (chosen()) element("chart-parameter").querySelector("output").value = parameterText(chosen(), sample);
}

function drawWord(name, i) {
  if (!run[name]) return;
  element(name).value = element(name).title = wordOf(run[name], i);
  element(name).className = "word grade" + gradeOf(run[name], i);
}

const chosen = () => run.parameters[element("parameter").selectedIndex];

function setPlaying(playing) {
  if (playing && player.time >= run.stop) player.time = run.start;
  player.playing = playing;
  player.last = performance.now();
  element("play").classList.toggle("playing", playing);
  element("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  wake();
}

function setRate(rate) {
  if (!rates.includes(rate)) return;
  player.rate = rate;
  element("rate").value = String(rate);
}

function setCamera(mode) {
  if (!CAMERAS.includes(mode)) return;
  camera.mode = mode;
  camera.zoom = 1;
  for (const button of document.querySelectorAll("[data-camera]")) {
    button.setAttribute("aria-pressed", String(button.dataset.camera === mode));
  }
  wake();
}

function zoomBy(factor) {
  camera.zoom = clamp(camera.zoom * factor, 0.2, 20);
  wake();
}

// The strip behind the scrubber: where plans were not as wished, where an arm took another contact, and below all along
// how the estimate did.
function drawStrip() {
  const { context, width, height } = fitCanvas(element("strip"));
  const x = (i) => ((run.time[i] - run.start) / (run.stop - run.start || 1)) * width;
  const middle = height / 2;
  context.fillStyle = ink.line;
  context.beginPath();
  context.roundRect(0, middle - 2, width, 4, 2);
  context.fill();
  const mark = (told, grade, i, y, high) => {
    context.fillStyle = ink[["good", "fair", "poor"][grade]];
    context.fillRect(x(Math.max(i - 1, 0)), y, Math.max(x(i) - x(Math.max(i - 1, 0)), 2), high);
  };
  for (let grade = 0; grade < 3; grade++) {
    for (let i = 0; i < frameCount; i++) {
      if (grade && gradeOf(run.status, i) === grade) mark(run.status, grade, i, middle - 3, 6);
      if (run.health && gradeOf(run.health, i) === grade) mark(run.health, grade, i, height - 4, 4);
    }
  }
  for (const arm of run.arms) {
    context.fillStyle = ink[arm.colour];
    for (let i = 1; i < frameCount; i++) {
      const moved = Math.hypot(...arm.contact.map((values) => values[i] - values[i - 1]));
      if (moved > 0.01) context.fillRect(x(i) - 1, 0, 2, height);
    }
  }
}

function showParameter() {
  parameterChart.show(parameterSpec(chosen()));
  wake();
}

function describe() {
  const length = run.stop - run.start;
  const arms = ["no arm", "1 arm"][run.arms.length] || run.arms.length + " arms";
  const cart = raw.cart.com ? raw.cart.name : "cart unknown, outline drawn round the contacts";
  const parts = [cart, raw.run === raw.title ? "" : raw.run, fixed(length, 1) + " s", arms];
  element("about").textContent = parts.filter(Boolean).join(" · ");
  element("status-box").hidden = !run.status;
  element("health-box").hidden = !run.health;
  element("error-box").hidden = element("legend-reference").hidden = !run.error;
  element("heading-box").hidden = Boolean(run.error);
  element("chart-parameter").hidden = !run.parameters.length;
  const known = ["com_x", "com_y"].map(parameterOf);
  const truth = known.every((p) => p && p.truth);
  element("legend-truth").hidden = !truth && !raw.cart.com;
  element("legend-truth").querySelector("span").textContent = truth ? "CoM, true" : "CoM of the model";
  element("legend-estimate").hidden = !known.every(Boolean);
  element("scrubber").min = run.start;
  element("scrubber").max = run.stop;
}

function chooseFirstParameter() {
  for (const parameter of run.parameters) element("parameter").add(new Option(parameter.label));
  const mass = run.parameters.findIndex((p) => p.name === "mass");
  if (!run.parameters.length) return;
  element("parameter").selectedIndex = Math.max(mass, 0);
  showParameter();
}

// At once, not with the next frame: a canvas must never be seen stretched.
function restyle() {
  readColours();
  for (const chart of charts) chart.stale = true;
  drawStrip();
  draw();
}

const KEYS = {
  " ": () => setPlaying(!player.playing),
  ArrowLeft: (shift) => seek(player.time - (shift ? 5 : 0.5)),
  ArrowRight: (shift) => seek(player.time + (shift ? 5 : 0.5)),
  ",": () => seek(run.time[Math.max(sampleAt(player.time - 1e-6).i, 0)]),
  ".": () => seek(run.time[Math.min(sampleAt(player.time + 1e-6).i + 1, frameCount - 1)]),
  Home: () => seek(run.start),
  End: () => seek(run.stop),
  c: () => setCamera(CAMERAS[(CAMERAS.indexOf(camera.mode) + 1) % CAMERAS.length]),
  "+": () => zoomBy(1.25),
  "=": () => zoomBy(1.25),
  "-": () => zoomBy(0.8),
};
Object.keys(PANELS).forEach((name, i) => (KEYS[i + 1] = () => choosePanel(name)));

function choosePanel(name) {
  showPanel(name);
  restyle();
}

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select")) return;
  if (event.key === " " && event.target.closest("button:focus-visible")) return;
  const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act) return;
  event.preventDefault();
  act(event.shiftKey);
}

// `#t=12.3&play=1&rate=2&camera=path&charts=motion` opens the page at an instant.
function readFragment() {
  const wish = new URLSearchParams(location.hash.slice(1));
  if (wish.has("camera")) setCamera(wish.get("camera"));
  if (wish.has("charts")) choosePanel(wish.get("charts"));
  if (wish.has("rate")) setRate(Number(wish.get("rate")));
  if (wish.has("t") && Number.isFinite(Number(wish.get("t")))) seek(Number(wish.get("t")));
  if (wish.has("play")) setPlaying(wish.get("play") === "1");
}

describe();
readColours();
fillPanels(seek);
const parameterChart = addChart(element("chart-parameter"), { lines: [] }, seek);
chooseFirstParameter();
showPanel("overview");
element("play").addEventListener("click", () => setPlaying(!player.playing));
element("scrubber").addEventListener("input", (event) => seek(Number(event.target.value)));
element("rate").addEventListener("change", (event) => setRate(Number(event.target.value)));
element("parameter").addEventListener("change", showParameter);
for (const button of document.querySelectorAll("[data-camera]")) {
  button.addEventListener("click", () => setCamera(button.dataset.camera));
}
element("scene").addEventListener("wheel", (event) => {
  const scrolls = document.documentElement.scrollHeight > innerHeight + 1;
  if (scrolls && !event.ctrlKey) return; // where the page scrolls, only a pinch zooms
  event.preventDefault();
  zoomBy(Math.exp(-0.0015 * event.deltaY));
}, { passive: false });
for (const button of document.querySelectorAll("[data-panel]")) {
  button.addEventListener("click", () => choosePanel(button.dataset.panel));
}
addEventListener("keydown", onKey);
addEventListener("hashchange", readFragment);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", restyle);
const watcher = new ResizeObserver(restyle);
for (const part of [document.body, element("scene"), ...document.querySelectorAll("figure")]) watcher.observe(part);
setCamera("follow");
readFragment();
restyle();
