// What the arms do to the cart: contacts, force arrows, moment arcs.

// Strokes what `path` draws, with a rim of the ground's colour so that it reads on anything.
function rimmed(context, colour, width, path) {
  for (const [stroke, lineWidth] of [[ink.panel, width + 3], [colour, width]]) {
    context.strokeStyle = stroke;
    context.lineWidth = lineWidth;
    context.beginPath();
    path();
    context.stroke();
  }
}

function drawArrow(context, x, y, dx, dy, colour) {
  const length = Math.hypot(dx, dy);
  if (!(length > 3)) return;
  const head = Math.min(9, 0.6 * length);
  const angle = Math.atan2(dy, dx);
  context.lineJoin = context.lineCap = "round";
  rimmed(context, colour, 2.5, () => {
    context.moveTo(x, y);
    context.lineTo(x + dx, y + dy);
    for (const side of [2.6, -2.6]) {
      context.moveTo(x + dx, y + dy);
      context.lineTo(x + dx + head * Math.cos(angle + side), y + dy + head * Math.sin(angle + side));
    }
  });
}

// An arc of `sweep` rad, positive counter-clockwise as seen from above, that begins at the screen's angle `from`.
function drawArc(context, x, y, radius, from, sweep, colour) {
  const turned = clamp(sweep, -5.6, 5.6);
  if (!(Math.abs(turned) * radius > 5)) return;
  const tip = from - turned;
  const [tx, ty] = [x + radius * Math.cos(tip), y + radius * Math.sin(tip)];
  const ahead = tip - (Math.PI / 2) * Math.sign(turned) + 0.25 * Math.sign(turned);
  rimmed(context, colour, 2, () => {
    context.arc(x, y, radius, from, tip, turned > 0);
    for (const side of [2.6, -2.6]) {
      context.moveTo(tx, ty);
      context.lineTo(tx + 6 * Math.cos(ahead + side), ty + 6 * Math.sin(ahead + side));
    }
  });
}

// A disc, square, triangle or diamond: arms can be told apart without their colours.
function drawMark(context, mark, x, y, radius, colour) {
  context.beginPath();
  if (mark === 0) context.arc(x, y, radius, 0, 2 * Math.PI);
  else {
    const corners = mark === 2 ? 3 : 4;
    const [size, from] = [mark === 2 ? 1.3 * radius : 1.25 * radius, mark === 1 ? Math.PI / 4 : -Math.PI / 2];
    for (let k = 0; k < corners; k++) {
      const angle = from + (2 * Math.PI * k) / corners;
      context.lineTo(x + size * Math.cos(angle), y + size * Math.sin(angle));
    }
    context.closePath();
  }
  context.fillStyle = colour;
  context.strokeStyle = ink.panel;
  context.lineJoin = "round";
  context.lineWidth = radius > 4 ? 2 : 1.5;
  context.fill();
  context.stroke();
}

function drawArm(context, pose, sample, arm) {
  const [px, py] = [arm.contact[0][sample.i], arm.contact[1][sample.i]];
  if (!Number.isFinite(px) || !Number.isFinite(py)) return;
  const colour = ink[arm.colour];
  const turn = pose.theta - camera.angle;
  const [x, y] = fromCart(pose, px, py);
  const [cx, cy] = fromCart(pose, clamp(px, body.x0, body.x1), clamp(py, body.y0, body.y1));
  context.strokeStyle = ink["body-edge"];
  context.lineWidth = 3;
  context.beginPath();
  context.moveTo(cx, cy);
  context.lineTo(x, y);
  context.stroke();
  const [fx, fy] = [mix(arm.force[0], sample), mix(arm.force[1], sample)];
  const size = forceScale();
  const [cosine, sine] = [Math.cos(turn), Math.sin(turn)];
  drawArrow(context, x, y, size * (cosine * fx - sine * fy), -size * (sine * fx + cosine * fy), colour);
  const near = clamp((body.length * camera.scale) / 150, 0.5, 1);
  if (near > 0.6) drawArc(context, x, y, 17, -turn + Math.PI, momentScale() * mix(arm.moment[2], sample), colour);
  drawMark(context, arm.mark, x, y, 6 * near, colour);
  drawName(context, pose, arm, px, py);
}

// The arm's name, beside its contact on the cart's outer side: forces mostly point along the cart.
function drawName(context, pose, arm, px, py) {
  const [x, y] = fromCart(pose, px, py);
  const aside = py - body.y;
  const [ox, oy] = Math.abs(aside) > 0.02 ? fromCart(pose, px, py + aside) : fromCart(pose, 2 * px - body.x, py);
  const far = Math.hypot(ox - x, oy - y) || 1;
  const [nx, ny] = [(ox - x) / far, (oy - y) / far];
  context.font = "600 12px " + FONT;
  context.textBaseline = "middle";
  context.textAlign = Math.abs(nx) < 0.35 ? "center" : nx > 0 ? "left" : "right";
  context.lineJoin = "round";
  context.lineWidth = 4;
  context.strokeStyle = ink.panel;
  context.fillStyle = ink[arm.colour];
  context.strokeText(shorten(arm.name, 18), x + 25 * nx, y + 25 * ny);
  context.fillText(shorten(arm.name, 18), x + 25 * nx, y + 25 * ny);
}
