// The camera over the plane, and how long forces and moments are drawn.

const body = (() => {
  const [x0, x1, y0, y1] = run.cart.body;
  return { x0, x1, y0, y1, x: (x0 + x1) / 2, y: (y0 + y1) / 2, length: x1 - x0, width: y1 - y0 };
})();

// Everything the cart reaches: body and contacts; the camera keeps it in view.
const reach = (() => {
  const held = quantile(finite(run.arms.flatMap((arm) => arm.contact)).map(Math.abs), 0.99);
  return Math.max(0.3, held || 0, ...[body.x0, body.x1, body.y0, body.y1].map(Math.abs));
})();

// What large forces and moments are in this run; below 1 N and 0.1 N·m it would only blow up noise.
const typicalForce = (() => {
  const sizes = run.arms.map((arm) => arm.force[0].map((fx, i) => Math.hypot(fx, arm.force[1][i])));
  return Math.max(1, quantile(finite(sizes), 0.95) || 0);
})();
const typicalMoment = Math.max(0.1, quantile(finite(run.arms.map((arm) => arm.moment[2].map(Math.abs))), 0.95) || 0);

const extent = (() => {
  const along = (i) => span(finite(run.reference ? [run.pose[i], run.reference[i]] : [run.pose[i]]));
  const [[x0, x1], [y0, y1]] = [along(0), along(1)];
  return x0 <= x1 && y0 <= y1 ? { x0, x1, y0, y1 } : { x0: -1, x1: 1, y0: -1, y1: 1 };
})();

const CAMERAS = ["follow", "heading", "path"];
const camera = { mode: "follow", zoom: 1, x: 0, y: 0, angle: 0, scale: 100, width: 1, height: 1 };

// Points the camera for the cart's pose; where the pose is missing it stays.
function aim(pose, width, height) {
  Object.assign(camera, { width, height });
  if (camera.mode === "path") {
    const [wide, high] = [extent.x1 - extent.x0 + 2.4 * reach, extent.y1 - extent.y0 + 2.4 * reach];
    camera.scale = Math.min((width - 40) / wide, (height - 100) / high) * camera.zoom;
    Object.assign(camera, { x: (extent.x0 + extent.x1) / 2, y: (extent.y0 + extent.y1) / 2, angle: 0 });
    if (camera.zoom > 1) centreOn(pose);
    return;
  }
  camera.scale = (Math.min(width, height) / (3.1 * reach)) * camera.zoom;
  camera.angle = camera.mode === "heading" && Number.isFinite(pose.theta) ? pose.theta - Math.PI / 2 : 0;
  centreOn(pose);
}

function centreOn(pose) {
  const [cosine, sine] = [Math.cos(pose.theta), Math.sin(pose.theta)];
  const x = pose.x + cosine * body.x - sine * body.y;
  const y = pose.y + sine * body.x + cosine * body.y;
  if (Number.isFinite(x) && Number.isFinite(y)) Object.assign(camera, { x, y });
}

function toScreen(x, y) {
  const [cosine, sine] = [Math.cos(camera.angle), Math.sin(camera.angle)];
  const [dx, dy] = [x - camera.x, y - camera.y];
  return [
    camera.width / 2 + camera.scale * (cosine * dx + sine * dy),
    camera.height / 2 - camera.scale * (cosine * dy - sine * dx),
  ];
}

// A point of {b} on the screen.
function fromCart(pose, x, y) {
  const [cosine, sine] = [Math.cos(pose.theta), Math.sin(pose.theta)];
  return toScreen(pose.x + cosine * x - sine * y, pose.y + sine * x + cosine * y);
}

// Draws with the units, origin and axes of {b}: metres, y to the left.
function inCart(context, pose, draw) {
  const turn = pose.theta - camera.angle;
  const [x, y] = toScreen(pose.x, pose.y);
  context.save();
  context.translate(x, y);
  context.rotate(-turn);
  context.scale(camera.scale, -camera.scale);
  context.lineWidth = 1 / camera.scale;
  draw();
  context.restore();
}

// Pixels of a newton: a large force is as long as half the cart, and never too small to read.
const forceScale = () => Math.max(0.5 * body.length * camera.scale, 44) / typicalForce;
// Angle of a newton metre: a large moment goes two thirds round.
const momentScale = () => (4 * Math.PI) / 3 / typicalMoment;

function drawGrid(context) {
  const spacing = roundDown(110 / camera.scale);
  const far = Math.hypot(camera.width, camera.height) / 2 / camera.scale + spacing;
  context.strokeStyle = ink.grid;
  context.lineWidth = 1;
  context.beginPath();
  const line = (x0, y0, x1, y1) => {
    context.moveTo(...toScreen(x0, y0));
    context.lineTo(...toScreen(x1, y1));
  };
  for (let x = Math.ceil((camera.x - far) / spacing) * spacing; x <= camera.x + far; x += spacing) {
    line(x, camera.y - far, x, camera.y + far);
  }
  for (let y = Math.ceil((camera.y - far) / spacing) * spacing; y <= camera.y + far; y += spacing) {
    line(camera.x - far, y, camera.x + far, y);
  }
  context.stroke();
}

// A polyline through points of the screen, broken where samples are missing.
function trace(context, first, last, point) {
  context.beginPath();
  let open = false;
  for (let i = first; i <= last; i++) {
    const [x, y] = point(i);
    const gap = i > first && i < frameCount && run.time[i] - run.time[i - 1] > run.gap;
    if (!Number.isFinite(x) || !Number.isFinite(y)) open = false;
    else if (open && !gap) context.lineTo(x, y);
    else {
      context.moveTo(x, y);
      open = true;
    }
  }
}

function drawPaths(context, sample, pose) {
  context.lineJoin = context.lineCap = "round";
  if (run.reference) {
    context.strokeStyle = ink.reference;
    context.lineWidth = 1.5;
    context.setLineDash([6, 5]);
    trace(context, 0, frameCount - 1, (i) => toScreen(run.reference[0][i], run.reference[1][i]));
    context.stroke();
    context.setLineDash([]);
  }
  const here = toScreen(pose.x, pose.y);
  context.strokeStyle = ink.driven;
  context.lineWidth = 3;
  trace(context, 0, sample.i + 1, (i) => (i > sample.i ? here : toScreen(run.pose[0][i], run.pose[1][i])));
  context.stroke();
}

function drawScene(canvas, time) {
  const { context, width, height } = fitCanvas(canvas);
  if (!width || !height) return;
  const sample = sampleAt(time);
  const pose = poseAt(run.pose, sample);
  const reference = run.reference && poseAt(run.reference, sample);
  aim(pose, width, height);
  drawGrid(context);
  drawPaths(context, sample, pose);
  if (reference && Number.isFinite(reference.x + reference.y + reference.theta)) drawBody(context, reference, true);
  if (Number.isFinite(pose.x + pose.y + pose.theta)) {
    drawBody(context, pose, false);
    drawWheels(context, pose, sample);
    const [tx, ty] = [parameterOf("com_x"), parameterOf("com_y")];
    const known = tx && ty && tx.truth && ty.truth;
    const com = known ? [mix(tx.truth, sample), mix(ty.truth, sample)] : run.cart.com;
    if (com && com.every(Number.isFinite)) drawTrueCom(context, pose, ...com);
    drawEstimatedCom(context, pose, sample);
    for (const arm of run.arms) drawArm(context, pose, sample, arm);
  }
  drawOverview(context, pose, sample);
  drawScales(context);
}
