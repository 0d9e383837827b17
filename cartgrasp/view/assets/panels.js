// Which charts there are, and the tabs that choose among them.

const DASHES = [[], [6, 4], [2, 3]];
const MARKS = ["\u25cf", "\u25a0", "\u25b2", "\u25c6"];
const charts = [];

const make = (tag, text, parts = []) => {
  const made = document.createElement(tag);
  made.textContent = text;
  made.append(...parts);
  return made;
};

// A legend's entry: the line's dashes, its name, and its value at the cursor.
function legendOf(line) {
  const key = make("i", "");
  key.className = "dash" + (line.dash ? DASHES.indexOf(line.dash) : 0);
  line.output = make("output", "");
  const entry = make("span", "", [key, line.label, line.output]);
  entry.style.color = "var(--" + line.colour + ")";
  return entry;
}

function addChart(figure, spec, seek) {
  const chart = new Chart(figure, seek);
  chart.show(spec);
  charts.push(chart);
  return chart;
}

function addFigure(panel, [title, unit], spec, seek, legend = spec.lines.filter((line) => line.label).map(legendOf)) {
  const entries = make("span", "", legend);
  entries.className = "entries";
  const canvas = make("canvas", "");
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", title + " over time");
  const figure = make("figure", "", [make("figcaption", "", [make("b", title), make("small", unit), entries]), canvas]);
  panel.append(figure);
  return addChart(figure, spec, seek);
}

// Components as lines, of one colour or of one each, a line style for each.
const linesOf = (columns, labels, colours) =>
  columns.map((values, i) => ({ values, label: labels[i], dash: DASHES[i], colour: colours[i % colours.length] }));

const referenceLines = (columns) =>
  columns.map((values) => ({ values, colour: "reference", dash: DASHES[2], thin: true }));

function parameterSpec(parameter) {
  const truth = { values: parameter.truth, colour: "truth", dash: DASHES[1], thin: true };
  const lines = [...(parameter.truth ? [truth] : []), { values: parameter.value, colour: "estimate" }];
  return { lines, bands: [{ value: parameter.value, std: parameter.std, colour: "estimate" }], told: run.health };
}

function parameterText(parameter, sample) {
  const [value, band] = [mix(parameter.value, sample), mix(parameter.std, sample)];
  const digits = digitsFor(Math.abs(value));
  const truth = parameter.truth ? ", true " + fixed(mix(parameter.truth, sample), digits) : "";
  const health = gradeOf(run.health, sample.i) ? " \u00b7 " + wordOf(run.health, sample.i) : "";
  return fixed(value, digits) + " \u00b1 " + fixed(band, digits) + truth + " " + parameter.unit + health;
}

const unwrapped = (values) => {
  let [last, turns] = [NaN, 0];
  return values.map((value) => {
    if (Number.isFinite(value - last)) turns -= Math.round((value - last) / (2 * Math.PI));
    if (Number.isFinite(value)) last = value;
    return value + 2 * Math.PI * turns;
  });
};

function fillOverview(panel, seek) {
  const error = () => ({ lines: [{ values: run.error, colour: "driven", label: "" }], zero: true });
  const velocity = () => ({ lines: linesOf(run.velocity.slice(0, 2), ["vx", "vy"], ["driven", "arm4"]), zero: true });
  if (run.error) addFigure(panel, ["Tracking error", "cm"], error(), seek);
  else addFigure(panel, ["Velocity", "m/s, in the cart's frame"], velocity(), seek);
  panel.append(element("chart-parameter"));
  if (!run.arms.length) return;
  const lines = run.arms.flatMap(({ force, colour, mark }) =>
    force.slice(0, 2).map((values, i) => ({ values, colour, mark, dash: DASHES[i], thin: i > 0 })),
  );
  const names = run.arms.map((arm) => {
    const entry = make("span", MARKS[arm.mark] + " " + arm.name);
    entry.style.color = "var(--" + arm.colour + ")";
    return entry;
  });
  const spec = { lines, zero: true, marks: run.arms.length > 1 };
  addFigure(panel, ["Force", "N; fx solid, fy dashed"], spec, seek, names);
}

function fillMotion(panel, seek) {
  const [x, y, theta] = run.pose;
  const reference = run.reference || [];
  const position = [...referenceLines(reference.slice(0, 2)), ...linesOf([x, y], ["x", "y"], ["driven", "arm4"])];
  const heading = [...referenceLines(reference.slice(2)), { values: theta, label: "\u03b8", colour: "driven" }];
  for (const line of heading) line.values = unwrapped(line.values);
  const velocity = linesOf(run.velocity.slice(0, 2), ["vx", "vy"], ["driven", "arm4"]);
  addFigure(panel, ["Position", "m" + (run.reference ? "; reference dotted" : "")], { lines: position }, seek);
  addFigure(panel, ["Heading", "rad"], { lines: heading }, seek);
  addFigure(panel, ["Velocity", "m/s, in the cart's frame"], { lines: velocity, zero: true }, seek);
  const rate = [{ values: run.velocity[2], label: "\u03c9", colour: "driven" }];
  addFigure(panel, ["Yaw rate", "rad/s"], { lines: rate, zero: true }, seek);
}

function fillWrenches(panel, seek) {
  for (const arm of run.arms) {
    const title = MARKS[arm.mark] + " " + shorten(arm.name, 18);
    const force = linesOf(arm.force, ["fx", "fy", "fz"], [arm.colour]);
    const moment = linesOf([2, 0, 1].map((i) => arm.moment[i]), ["tz", "tx", "ty"], [arm.colour]);
    addFigure(panel, [title, "force, N"], { lines: force, zero: true }, seek);
    addFigure(panel, [title, "moment, N\u00b7m"], { lines: moment, zero: true }, seek);
  }
}

function fillParameters(panel, seek) {
  for (const parameter of run.parameters) {
    const value = make("output", "");
    const title = [shorten(parameter.label, 30), "\u00b1 one standard deviation"];
    const chart = addFigure(panel, title, parameterSpec(parameter), seek, [value]);
    chart.onDraw = (sample) => (value.value = parameterText(parameter, sample));
  }
}

const PANELS = { overview: fillOverview, motion: fillMotion, wrenches: fillWrenches, parameters: fillParameters };

function fillPanels(seek) {
  for (const [name, fill] of Object.entries(PANELS)) {
    const before = charts.length;
    fill(element("panel-" + name), seek);
    if (charts.length > before) charts[charts.length - 1].labelsTime = true;
  }
  element("tab-wrenches").hidden = !run.arms.length;
  element("tab-parameters").hidden = !run.parameters.length;
}

function showPanel(name) {
  if (!(name in PANELS) || element("tab-" + name).hidden) return;
  for (const other of Object.keys(PANELS)) {
    element("panel-" + other).hidden = other !== name;
    element("tab-" + other).setAttribute("aria-selected", String(other === name));
  }
}
