// Small charts over time whose cursor follows the player; pressing or dragging on one moves it.

const GUTTER = 44;

function ticksBetween(low, high, most) {
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const step = [1, 2, 5, 10].map((k) => k * power).find((size) => (high - low) / size <= most * 1.0001);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

function tickText(value, ticks) {
  const step = ticks.length > 1 ? ticks[1] - ticks[0] : Math.abs(value) || 1;
  return fixed(Math.abs(value) < 1e-9 * step ? 0 : value, clamp(-Math.floor(Math.log10(step) + 1e-9), 0, 6));
}

// Range over which a chart spans: all of its lines, and of a band what is not only its wide beginning.
function rangeOf(spec) {
  const lines = finite(spec.lines.map((line) => line.values));
  const edges = (spec.bands || []).flatMap((band) => [-1, 1].map((k) => band.value.map((v, i) => v + k * band.std[i])));
  const spread = edges.flatMap((edge) => [0.05, 0.95].map((fraction) => quantile(finite([edge]), fraction)));
  const all = lines.concat(spread.filter(Number.isFinite), spec.zero ? [0] : []);
  if (!all.length) return [0, 1];
  const [low, high] = span(all);
  const room = 0.08 * (high - low) || 0.05 * Math.abs(high) || 1;
  return [spec.zero && low === 0 ? 0 : low - room, high + room];
}

class Chart {
  constructor(figure, onSeek) {
    this.canvas = figure.querySelector("canvas");
    this.labelsTime = false;
    this.still = document.createElement("canvas");
    this.show({ lines: [] });
    const seek = (event) => onSeek(this.timeAt(event.clientX - this.canvas.getBoundingClientRect().left));
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      seek(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && seek(event));
  }

  show(spec) {
    this.spec = spec;
    this.range = rangeOf(spec);
    this.digits = digitsFor(this.range[1] - this.range[0]);
    this.stale = true;
  }

  get plot() {
    const bottom = this.labelsTime ? 20 : 8;
    return { left: GUTTER, right: this.canvas.clientWidth - 8, top: 6, bottom: this.canvas.clientHeight - bottom };
  }

  x(time) {
    const { left, right } = this.plot;
    return left + ((time - run.start) / (run.stop - run.start || 1)) * (right - left);
  }

  y(value) {
    const { top, bottom } = this.plot;
    return bottom - ((value - this.range[0]) / (this.range[1] - this.range[0])) * (bottom - top);
  }

  timeAt(x) {
    const { left, right } = this.plot;
    return run.start + clamp((x - left) / (right - left), 0, 1) * (run.stop - run.start);
  }

  drawAxes(context) {
    const { left, right, top, bottom } = this.plot;
    const values = ticksBetween(...this.range, clamp((bottom - top) / 26, 2, 5));
    const most = clamp((right - left) / 55, 2, 7);
    const times = run.stop > run.start ? ticksBetween(run.start, run.stop, most) : [run.start];
    context.strokeStyle = ink.grid;
    context.lineWidth = 1;
    context.beginPath();
    for (const v of values) {
      context.moveTo(left, Math.round(this.y(v)) + 0.5);
      context.lineTo(right, Math.round(this.y(v)) + 0.5);
    }
    for (const t of times) {
      context.moveTo(Math.round(this.x(t)) + 0.5, top);
      context.lineTo(Math.round(this.x(t)) + 0.5, bottom);
    }
    context.stroke();
    context.font = "11px " + FONT;
    context.fillStyle = ink.muted;
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (const v of values) context.fillText(tickText(v, values), left - 7, this.y(v));
    if (!this.labelsTime) return;
    context.textAlign = "center";
    times.forEach((t, i) => {
      const unit = i === times.length - 1 ? " s" : "";
      context.fillText(tickText(t, times) + unit, this.x(t), bottom + 12);
    });
  }

  drawStill() {
    this.still.width = this.canvas.width;
    this.still.height = this.canvas.height;
    const context = this.still.getContext("2d");
    context.scale(devicePixelRatio || 1, devicePixelRatio || 1);
    this.drawAxes(context);
    const { left, right, top, bottom } = this.plot;
    context.beginPath();
    context.rect(left, top - 2, right - left + 2, bottom - top + 4);
    context.clip();
    this.drawDoubt(context);
    for (const band of this.spec.bands || []) this.drawBand(context, band);
    context.lineJoin = "round";
    for (const line of this.spec.lines) {
      context.strokeStyle = ink[line.colour];
      context.lineWidth = line.thin ? 1.2 : 1.6;
      context.setLineDash(line.dash || []);
      trace(context, 0, frameCount - 1, (i) => [this.x(run.time[i]), this.y(line.values[i])]);
      context.stroke();
    }
    context.setLineDash([]);
    if (this.spec.marks) this.spec.lines.forEach((line, k) => this.drawMarks(context, line, 20 + 13 * k));
    this.stale = false;
  }

  // The marks of arms along their lines, which so differ without colours too.
  drawMarks(context, line, from) {
    const { left, right } = this.plot;
    for (let x = left + from; x < right; x += 84) {
      const y = this.y(mix(line.values, sampleAt(this.timeAt(x))));
      if (Number.isFinite(y)) drawMark(context, line.mark, x, y, 3.4, ink[line.colour]);
    }
  }

  // Ground where the estimate says of itself that it is not as it should be.
  drawDoubt(context) {
    const { top, bottom } = this.plot;
    context.globalAlpha = 0.16;
    for (let first = 0; first < frameCount; first++) {
      const grade = gradeOf(this.spec.told, first);
      let last = first;
      while (last + 1 < frameCount && gradeOf(this.spec.told, last + 1) === grade) last++;
      const from = this.x(run.time[Math.max(first - 1, 0)]);
      context.fillStyle = grade === 1 ? ink.fair : ink.poor;
      if (grade) context.fillRect(from, top, Math.max(this.x(run.time[last]) - from, 1), bottom - top);
      first = last;
    }
    context.globalAlpha = 1;
  }

  // Each stretch without a missing sample is one patch.
  drawBand(context, band) {
    context.fillStyle = ink[band.colour];
    context.globalAlpha = 0.2;
    const edge = (i, k) => this.y(band.value[i] + k * band.std[i]);
    for (let first = 0; first < frameCount; first++) {
      let last = first;
      const follows = (i) => i === first || run.time[i] - run.time[i - 1] <= run.gap;
      while (last < frameCount && Number.isFinite(edge(last, 1)) && follows(last)) last++;
      if (last - first > 1) {
        context.beginPath();
        for (let i = first; i < last; i++) context.lineTo(this.x(run.time[i]), edge(i, 1));
        for (let i = last - 1; i >= first; i--) context.lineTo(this.x(run.time[i]), edge(i, -1));
        context.fill();
      }
      first = Math.max(first, last - 1);
    }
    context.globalAlpha = 1;
  }

  draw(time, sample) {
    const { context, width, height } = fitCanvas(this.canvas);
    if (!width || !height) return;
    const resized = this.still.width !== this.canvas.width || this.still.height !== this.canvas.height;
    if (this.stale || resized) this.drawStill();
    context.drawImage(this.still, 0, 0, width, height);
    const { top, bottom } = this.plot;
    const x = this.x(time);
    context.strokeStyle = ink.accent;
    context.lineWidth = 1.25;
    context.beginPath();
    context.moveTo(x, top);
    context.lineTo(x, bottom);
    context.stroke();
    for (const line of this.spec.lines) {
      const y = this.y(mix(line.values, sample));
      if (!Number.isFinite(y) || line.thin) continue;
      drawMark(context, line.mark || 0, x, y, 3.4, ink[line.colour]);
    }
    if (this.onDraw) this.onDraw(sample);
    for (const line of this.spec.lines) {
      if (line.output) line.output.value = fixed(mix(line.values, sample), this.digits);
    }
  }
}
