// The clock and the controls.

const player = { time: run.start, playing: false, rate: 1, last: 0 };
const rates = Array.from(element("rate").options, (option) => Number(option.value));

const seek = (time) => {
  player.time = clamp(time, run.start, run.stop);
  wake();
};
const charts = {
  error: new Chart(element("chart-error"), false, seek),
  parameter: new Chart(element("chart-parameter"), false, seek),
  force: new Chart(element("chart-force"), true, seek),
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
  for (const chart of Object.values(charts)) chart.draw(player.time, sample);
  element("scrubber").value = player.time;
  element("scrubber").setAttribute("aria-valuetext", fixed(player.time, 1) + " s");
  element("time").value = fixed(player.time, 2);
  element("speed").value = fixed(mix(run.speed, sample), 2);
  element("error").value = fixed(mix(run.error, sample), 2);
  drawStatus(sample.i);
  drawParameterValue(sample);
}

function drawStatus(i) {
  if (!run.status) return;
  const word = run.status.index[i];
  element("status").value = element("status").title = run.status.words[word].replaceAll("_", " ");
  element("status").className = "grade" + run.status.grades[word];
}

const chosen = () => run.parameters[element("parameter").selectedIndex];

function drawParameterValue(sample) {
  const parameter = chosen();
  if (!parameter) return;
  const [value, band] = [mix(parameter.value, sample), 2 * mix(parameter.std, sample)];
  const digits = digitsFor(Math.abs(value));
  const truth = parameter.truth ? ", true " + fixed(mix(parameter.truth, sample), digits) : "";
  const text = fixed(value, digits) + " ± " + fixed(band, digits) + truth + " " + parameter.unit;
  element("chart-parameter").querySelector("output").value = text;
}

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

// The strip behind the scrubber: where plans were not as wished, and where an arm took another contact.
function drawStrip() {
  const { context, width, height } = fitCanvas(element("strip"));
  const x = (i) => ((run.time[i] - run.start) / (run.stop - run.start || 1)) * width;
  const middle = height / 2;
  context.fillStyle = ink.line;
  context.beginPath();
  context.roundRect(0, middle - 2, width, 4, 2);
  context.fill();
  for (let i = 0; run.status && i < frameCount; i++) {
    const grade = run.status.grades[run.status.index[i]];
    if (!grade) continue;
    context.fillStyle = grade === 1 ? ink.fair : ink.poor;
    context.fillRect(x(Math.max(i - 1, 0)), middle - 3, Math.max(x(i) - x(Math.max(i - 1, 0)), 2), 6);
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
  const parameter = chosen();
  const lines = parameter.truth ? [{ values: parameter.truth, colour: "truth", dash: [5, 4], thin: true }] : [];
  lines.push({ values: parameter.value, colour: "estimate" });
  const bands = [{ value: parameter.value, std: parameter.std, colour: "estimate" }];
  charts.parameter.show({ lines, bands });
  wake();
}

function describe() {
  const length = run.stop - run.start;
  const arms = run.arms.length === 1 ? "1 arm" : run.arms.length + " arms";
  element("about").textContent = [raw.cart.name, raw.run, fixed(length, 1) + " s", arms].filter(Boolean).join(" · ");
  element("status-box").hidden = !run.status;
  element("chart-parameter").hidden = !run.parameters.length;
  const known = ["com_x", "com_y"].map(parameterOf);
  const truth = known.every((p) => p && p.truth);
  element("legend-truth").querySelector("span").textContent = truth ? "CoM, true" : "CoM of the model";
  element("legend-estimate").hidden = !known.every(Boolean);
  element("scrubber").min = run.start;
  element("scrubber").max = run.stop;
}

function fillCharts() {
  charts.error.show({ lines: [{ values: run.error, colour: "driven" }], zero: true });
  const dashes = [[], [4, 3]];
  const linesOf = ({ force, colour }) => force.map((values, i) => ({ values, colour, dash: dashes[i], thin: i > 0 }));
  charts.force.show({ lines: run.arms.flatMap(linesOf), zero: true });
  const add = (text, name) => {
    const item = document.createElement("span");
    item.textContent = text;
    item.className = name ? "" : "component";
    if (name) item.style.color = "var(--" + name + ")";
    element("force-legend").append(item);
  };
  for (const arm of run.arms) add(arm.name, arm.colour);
  add("fx solid, fy dashed", "");
  for (const parameter of run.parameters) element("parameter").add(new Option(parameter.label));
  const mass = run.parameters.findIndex((p) => p.name === "mass");
  if (run.parameters.length) {
    element("parameter").selectedIndex = Math.max(mass, 0);
    showParameter();
  }
}

// At once, not with the next frame: a canvas must never be seen stretched.
function restyle() {
  readColours();
  for (const chart of Object.values(charts)) chart.stale = true;
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

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("select")) return;
  if (event.key === " " && event.target.closest("button")) return;
  const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act) return;
  event.preventDefault();
  act(event.shiftKey);
}

// `#t=12.3&play=1&rate=2&camera=path` opens the page at an instant.
function readFragment() {
  const wish = new URLSearchParams(location.hash.slice(1));
  if (wish.has("camera")) setCamera(wish.get("camera"));
  if (wish.has("rate")) setRate(Number(wish.get("rate")));
  if (wish.has("t") && Number.isFinite(Number(wish.get("t")))) seek(Number(wish.get("t")));
  if (wish.has("play")) setPlaying(wish.get("play") === "1");
}

describe();
readColours();
fillCharts();
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
addEventListener("keydown", onKey);
addEventListener("hashchange", readFragment);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", restyle);
const watcher = new ResizeObserver(restyle);
for (const part of [document.body, element("scene"), ...document.querySelectorAll("figure")]) watcher.observe(part);
setCamera("follow");
readFragment();
restyle();
