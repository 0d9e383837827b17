"use strict";

// The run as typed columns, sampling between frames, and small helpers that the other files share.

const element = (id) => document.getElementById(id);

function report(message) {
  element("problem").textContent = "This page met a problem: " + message;
  element("problem").hidden = false;
}
addEventListener("error", (event) => report(event.message));
addEventListener("securitypolicyviolation", (event) => report("blocked " + event.violatedDirective));

const raw = JSON.parse(element("run").textContent);
const frameCount = raw.frames;

// A column is one number that holds throughout, or [decimals, first, difference, …]; null is a missing sample.
function column(packed) {
  if (!Array.isArray(packed)) return new Float64Array(frameCount).fill(packed === null ? NaN : packed);
  let whole = 0;
  return Float64Array.from(packed.slice(1), (step) => (step === null ? NaN : (whole += step) / 10 ** packed[0]));
}

const run = {
  time: column(raw.time),
  pose: raw.pose.map(column),
  velocity: raw.velocity.map(column),
  reference: raw.reference && raw.reference.map(column),
  error: raw.error === null ? null : column(raw.error),
  casters: raw.casters && raw.casters.map(column),
  arms: raw.arms.map((arm, i) => ({
    name: arm.name,
    colour: "arm" + (i % 6),
    mark: i % 4,
    contact: arm.contact.map(column),
    force: arm.force.map(column),
    moment: arm.moment.map(column),
  })),
  parameters: raw.parameters.map((p) => ({
    name: p.name,
    label: p.label,
    unit: p.unit,
    value: column(p.value),
    std: column(p.std),
    truth: p.truth === null ? null : column(p.truth),
  })),
  correlation: column(raw.correlation === null ? 0 : raw.correlation),
  cart: raw.cart,
  status: raw.status,
  health: raw.health,
};
run.start = run.time[0];
run.stop = run.time[frameCount - 1];

// Steps of time that are longer are gaps, which no line crosses.
run.gap = (() => {
  const steps = run.time.slice(1).map((t, i) => t - run.time[i]).sort();
  return 4 * (steps[steps.length >> 1] || 1);
})();

const parameterOf = (name) => run.parameters.find((p) => p.name === name);
const gradeOf = (told, i) => (told ? told.grades[told.index[i]] : 0);
const wordOf = (told, i) => told.words[told.index[i]].replaceAll("_", " ");
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

// Where a time lies: after frame `i`, by the fraction `f` of the way to the next; in a gap nothing is known.
function sampleAt(time) {
  let low = 0;
  let high = frameCount - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (run.time[middle] <= time) low = middle;
    else high = middle;
  }
  if (frameCount === 1) return { i: 0, f: 0 };
  if (time >= run.time[high]) return { i: high, f: 0 };
  const step = run.time[high] - run.time[low];
  const f = clamp((time - run.time[low]) / step, 0, 1);
  return { i: low, f, gap: f > 0 && step > run.gap };
}

function mix(values, sample) {
  const from = sample.gap ? NaN : values[sample.i];
  return sample.f === 0 ? from : from + sample.f * (values[sample.i + 1] - from);
}

function mixAngle(values, sample) {
  const from = sample.gap ? NaN : values[sample.i];
  if (sample.f === 0) return from;
  const turn = values[sample.i + 1] - from;
  return from + sample.f * Math.atan2(Math.sin(turn), Math.cos(turn));
}

const poseAt = (columns, sample) => ({
  x: mix(columns[0], sample),
  y: mix(columns[1], sample),
  theta: mixAngle(columns[2], sample),
});

function fixed(value, digits) {
  if (!Number.isFinite(value)) return "\u2013";
  return value.toFixed(digits).replace(/^-(?=[0.]*$)/, "").replace("-", "\u2212");
}

// Digits after the point that suit numbers of this size.
function digitsFor(size) {
  return size > 0 && Number.isFinite(size) ? clamp(2 - Math.floor(Math.log10(size)), 0, 6) : 0;
}

function finite(columns) {
  return columns.flatMap((values) => Array.from(values).filter(Number.isFinite));
}

const span = (values) => values.reduce((r, v) => [Math.min(r[0], v), Math.max(r[1], v)], [Infinity, -Infinity]);

function quantile(values, fraction) {
  const sorted = Float64Array.from(values).sort();
  return sorted.length ? sorted[Math.round(fraction * (sorted.length - 1))] : NaN;
}

// The largest of 1, 2, 5 times a power of ten that is not above `value`.
function roundDown(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [5, 2, 1].find((k) => k * power <= value * 1.0001) * power;
}

function shorten(text, most) {
  const letters = Array.from(text);
  return letters.length > most ? letters.slice(0, most - 1).join("") + "\u2026" : text;
}

// Colours come from the style sheet, so that light and dark are said once.
const ink = {};
function readColours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["panel", "ink", "muted", "line", "grid", "body", "body-edge", "wheel", "driven", "reference"];
  names.push("estimate", "truth", "accent", "good", "fair", "poor", "arm0", "arm1", "arm2", "arm3", "arm4", "arm5");
  for (const name of names) ink[name] = style.getPropertyValue("--" + name).trim();
}

// Fits a canvas to the pixels it covers; units of drawing stay CSS pixels.
function fitCanvas(canvas) {
  const ratio = devicePixelRatio || 1;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  const context = canvas.getContext("2d");
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height, ratio };
}

const FONT = '"Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif';
