// The cart seen from above: body, wheels, centre of mass.

function drawBody(context, pose, ghost) {
  inCart(context, pose, () => {
    const round = 0.14 * Math.min(body.length, body.width);
    context.beginPath();
    context.roundRect(body.x0, body.y0, body.length, body.width, round);
    if (ghost) {
      context.setLineDash([5 / camera.scale, 4 / camera.scale]);
      context.strokeStyle = ink.reference;
      context.stroke();
      return;
    }
    context.fillStyle = ink.body;
    context.strokeStyle = ink["body-edge"];
    context.lineWidth = 1.5 / camera.scale;
    if (run.cart.com) context.fill();
    else context.setLineDash([2 / camera.scale, 4 / camera.scale]); // an outline that is only guessed
    context.stroke();
    context.setLineDash([]);
    const size = 0.09 * Math.min(body.length, body.width);
    context.beginPath();
    context.moveTo(body.x1 - 1.9 * size, body.y + size);
    context.lineTo(body.x1 - 0.9 * size, body.y);
    context.lineTo(body.x1 - 1.9 * size, body.y - size);
    context.lineWidth = 2 / camera.scale;
    context.lineJoin = context.lineCap = "round";
    context.stroke();
  });
}

// Fixed wheels point along x; a caster's wheel trails its pivot against its heading.
function drawWheels(context, pose, sample) {
  const size = clamp(0.2 * Math.min(body.length, body.width), 0.05, 0.3);
  let caster = 0;
  for (const wheel of run.cart.wheels) {
    const heading = wheel.caster ? (run.casters ? mixAngle(run.casters[caster], sample) : NaN) : 0;
    caster += wheel.caster ? 1 : 0;
    inCart(context, pose, () => {
      context.translate(wheel.x, wheel.y);
      context.fillStyle = context.strokeStyle = ink.wheel;
      context.lineWidth = 2 / camera.scale;
      if (Number.isFinite(heading)) {
        context.rotate(heading);
        const trail = wheel.caster ? Math.max(wheel.trail, 0.3 * size) : 0;
        context.beginPath();
        context.moveTo(0, 0);
        context.lineTo(-trail, 0);
        context.stroke();
        context.beginPath();
        context.roundRect(-trail - size / 2, -0.19 * size, size, 0.38 * size, 0.1 * size);
        context.fill();
      }
      if (wheel.caster) {
        context.beginPath();
        context.arc(0, 0, 0.15 * size, 0, 2 * Math.PI);
        context.fillStyle = ink.panel;
        context.fill();
        context.stroke();
      }
    });
  }
}

function drawTrueCom(context, pose, x, y) {
  const [sx, sy] = fromCart(pose, x, y);
  const radius = clamp(0.045 * body.length * camera.scale, 3.5, 8);
  context.lineWidth = 1.5;
  context.strokeStyle = ink.truth;
  for (let quarter = 0; quarter < 4; quarter++) {
    context.beginPath();
    context.moveTo(sx, sy);
    context.arc(sx, sy, radius, (quarter * Math.PI) / 2, ((quarter + 1) * Math.PI) / 2);
    context.fillStyle = quarter % 2 ? ink.truth : ink.panel;
    context.fill();
  }
  context.beginPath();
  context.arc(sx, sy, radius, 0, 2 * Math.PI);
  context.stroke();
}

// The ellipse of one standard deviation: the covariance's axes, from the deviations and the correlation.
function drawEstimatedCom(context, pose, sample) {
  const [px, py] = [parameterOf("com_x"), parameterOf("com_y")];
  if (!px || !py) return;
  const [x, y] = [mix(px.value, sample), mix(py.value, sample)];
  const [sx, sy] = [mix(px.std, sample), mix(py.std, sample)];
  if (!Number.isFinite(x) || !Number.isFinite(y)) return;
  inCart(context, pose, () => {
    context.strokeStyle = context.fillStyle = ink.estimate;
    if (Number.isFinite(sx) && Number.isFinite(sy)) {
      const [rx, ry, turn] = ellipseOf(sx, sy, mix(run.correlation, sample) || 0);
      context.beginPath();
      context.ellipse(x, y, rx, ry, turn, 0, 2 * Math.PI);
      context.globalAlpha = 0.16;
      context.fill();
      context.globalAlpha = 1;
      context.lineWidth = 1.5 / camera.scale;
      context.stroke();
    }
    context.beginPath();
    context.arc(x, y, clamp(0.02 * body.length, 1.5 / camera.scale, 4 / camera.scale), 0, 2 * Math.PI);
    context.fill();
  });
}

// Radii and turn of the ellipse at one deviation.
function ellipseOf(sx, sy, correlation) {
  const [mean, half, both] = [(sx * sx + sy * sy) / 2, (sx * sx - sy * sy) / 2, correlation * sx * sy];
  const far = Math.hypot(half, both);
  return [Math.sqrt(mean + far), Math.sqrt(Math.max(mean - far, 0)), Math.atan2(both, half) / 2];
}
