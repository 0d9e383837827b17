// What the scales mean, and where on the path the cart is.

// Ground for a legend, which lets what lies under it shine through a little.
function backdrop(context, x, y, width, height) {
  context.globalAlpha = 0.85;
  context.fillStyle = ink.panel;
  context.strokeStyle = ink.line;
  context.lineWidth = 1;
  context.beginPath();
  context.roundRect(x, y, width, height, 9);
  context.fill();
  context.globalAlpha = 1;
  context.stroke();
}

// Bottom left: what a metre, a newton and a newton metre look like.
function drawScales(context) {
  let y = camera.height - 22;
  backdrop(context, 12, camera.height - 84, 150, 72);
  context.font = "12px " + FONT;
  context.textAlign = "left";
  context.textBaseline = "middle";
  const label = (text, x) => {
    context.fillStyle = ink.muted;
    context.fillText(text, x, y);
  };
  const metre = roundDown(90 / camera.scale);
  context.strokeStyle = ink.muted;
  context.lineWidth = 1.5;
  context.beginPath();
  const end = 20 + metre * camera.scale;
  for (const [x, dy] of [[20, 4], [end, 4]]) {
    context.moveTo(x, y - dy);
    context.lineTo(x, y + dy);
  }
  context.moveTo(20, y);
  context.lineTo(end, y);
  context.stroke();
  label(metre + " m", end + 8);
  y -= 21;
  const force = roundDown(90 / forceScale());
  drawArrow(context, 20, y, force * forceScale(), 0, ink.muted);
  label(force + " N", 28 + force * forceScale());
  y -= 23;
  const moment = roundDown(typicalMoment);
  drawArc(context, 30, y + 2, 9, 0, moment * momentScale(), ink.muted);
  label(moment + " N·m", 48);
}

// Top right, while the camera is near: the whole path, and where on it the cart is.
function drawOverview(context, pose, sample) {
  const [wide, high] = [extent.x1 - extent.x0, extent.y1 - extent.y0];
  if (camera.mode === "path" || Math.max(wide, high) < 3 * reach || camera.width < 420) return;
  const scale = Math.min(150 / wide, 120 / high);
  const [w, h] = [wide * scale, high * scale];
  const [left, top] = [camera.width - w - 26, 24];
  const place = (x, y) => [left + (x - extent.x0) * scale, top + h - (y - extent.y0) * scale];
  backdrop(context, left - 12, top - 12, w + 24, h + 24);
  const [wholeX, wholeY] = run.reference || run.pose;
  context.lineWidth = 1;
  context.strokeStyle = ink.reference;
  context.globalAlpha = 0.6;
  trace(context, 0, frameCount - 1, (i) => place(wholeX[i], wholeY[i]));
  context.stroke();
  context.globalAlpha = 1;
  context.strokeStyle = ink.driven;
  context.lineWidth = 2;
  trace(context, 0, sample.i, (i) => place(run.pose[0][i], run.pose[1][i]));
  context.stroke();
  if (!Number.isFinite(pose.x + pose.y)) return;
  context.fillStyle = ink.ink;
  context.beginPath();
  context.arc(...place(pose.x, pose.y), 4, 0, 2 * Math.PI);
  context.fill();
}
