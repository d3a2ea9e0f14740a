// Drawing: a plane in metres and curves over an axis, on a canvas. Colours are those of the page, by their meaning.
const INKS = { plain: "--text", faint: "--faint", accent: "--accent", good: "--good", warn: "--warning", bad: "--bad", goal: "--goal", seen: "--seen" };
const MAX_PIXELS = 2;

export function element(name, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}
export function setText(place, text) {
  if (place.textContent !== text) place.textContent = text;
}
export function button(label, press) {
  const made = element("button", label);
  made.type = "button";
  made.addEventListener("click", press);
  return made;
}
const theme = matchMedia("(prefers-color-scheme: dark)");
let style = null;
/** What draws each plane again, for as long as it is on the page. */
const planes = new WeakMap();
theme.addEventListener("change", () => {
  style = null;
  for (const canvas of document.querySelectorAll(".plane canvas")) planes.get(canvas)?.();
});
const ink = (name) => (style ??= getComputedStyle(document.documentElement)).getPropertyValue(INKS[name] ?? "--text");
const colorOf = (color) => (color.exact ? `rgb(${color.exact.slice(0, 3).join(" ")} / ${color.exact[3] / 255})` : ink(color.ink));

/** Makes the canvas as sharp as the screen, and empties it. Returns null while it is not shown. */
function begin(canvas) {
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!width || !height) return null;
  const pixels = Math.min(MAX_PIXELS, devicePixelRatio || 1);
  const [across, down] = [Math.round(width * pixels), Math.round(height * pixels)];
  if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
  const pen = canvas.getContext("2d");
  pen.setTransform(pixels, 0, 0, pixels, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.lineJoin = "round";
  pen.font = "12px system-ui, sans-serif";
  return { pen, width, height };
}

/** The points that a shape covers. */
function corners(kind, shape) {
  switch (kind) {
    case "circle": return [-1, 1].map((side) => shape.center.map((at) => at + side * shape.radius));
    case "arrow": return [shape.from, shape.to];
    case "label": return [shape.at];
    case "robot": return [-0.3, 0.3].map((side) => [shape.pose[0] + side, shape.pose[1] + side]);
    default: return shape.points;
  }
}

/** A plane with pan and zoom: two fingers, a mouse, or its buttons. One finger scrolls the page. */
export class Plane {
  #canvas = element("canvas");
  #content = null;
  #zoom = 1;
  #moved = [0, 0];
  #fingers = new Map();
  #place = null;
  #drag = null;
  /** How far the pointer went since it went down, pixels. */
  #travel = 0;

  /** `touch` is called with gestures in metres, and only if the plane wants them. */
  constructor(label, touch) {
    this.element = element("div", undefined, "plane");
    this.#canvas.setAttribute("role", "img");
    this.#canvas.setAttribute("aria-label", label);
    this.touch = touch;
    const tools = element("div", undefined, "line tools");
    for (const [text, name, factor] of [["+", "Closer", 1.4], ["−", "Farther", 1 / 1.4], ["Fit", "Show everything", 0]]) {
      const made = button(text, () => this.#scale(factor));
      made.setAttribute("aria-label", name);
      tools.append(made);
    }
    this.element.append(this.#canvas, tools);
    this.#canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.#scale(event.deltaY < 0 ? 1.1 : 1 / 1.1);
    }, { passive: false });
    this.#canvas.addEventListener("pointerdown", (event) => this.#down(event));
    this.#canvas.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) this.#canvas.addEventListener(end, (event) => this.#up(event, end === "pointerup"));
    this.#canvas.addEventListener("click", (event) => {
      // What ends a pan or a drag is no click.
      if (this.#travel <= 6 && this.#content?.wants.clicks) this.touch({ clicked: { at: this.#at(event), button: "primary" } });
    });
    new ResizeObserver(() => this.#draw()).observe(this.#canvas);
    planes.set(this.#canvas, () => this.#draw());
  }

  /** Shows a canvas of a panel. */
  show(content, label) {
    this.#content = content;
    if (label) this.#canvas.setAttribute("aria-label", label);
    this.#canvas.classList.toggle("drags", content.wants.drags);
    this.#draw();
  }

  #scale(factor) {
    if (!factor) [this.#zoom, this.#moved] = [1, [0, 0]];
    else this.#zoom = Math.max(0.1, Math.min(50, this.#zoom * factor));
    this.#draw();
  }

  #at(event) {
    const area = this.#canvas.getBoundingClientRect();
    return this.#place ? [...this.#place.metres(event.clientX - area.left, event.clientY - area.top), 0] : [0, 0, 0];
  }

  #down(event) {
    if (event.isPrimary) this.#travel = 0;
    this.#fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (event.pointerType === "mouse" || this.#content?.wants.drags) this.#canvas.setPointerCapture(event.pointerId);
    if (this.#content?.wants.drags && this.#fingers.size === 1) this.#drag = this.#at(event);
  }

  #move(event) {
    const before = this.#fingers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    this.#travel += Math.hypot(now[0] - before[0], now[1] - before[1]);
    const others = [...this.#fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    this.#fingers.set(event.pointerId, now);
    if (this.#drag && !others.length) return this.#dragged(event, false);
    if (others.length === 1) {
      const far = (at) => Math.hypot(at[0] - others[0][0], at[1] - others[0][1]);
      if (far(before) > 10) this.#scale(far(now) / far(before));
    }
    this.#moved = this.#moved.map((sum, axis) => sum + (now[axis] - before[axis]) / (others.length + 1));
    this.#draw();
  }

  #up(event, isWhole) {
    this.#fingers.delete(event.pointerId);
    if (this.#drag && isWhole) this.#dragged(event, true);
    this.#drag = null;
  }

  #dragged(event, ended) {
    this.touch({ dragged: { from: this.#drag, to: this.#at(event), button: "primary", ended } });
  }

  #area() {
    const { area, shapes } = this.#content;
    if (area) return [area.least, area.greatest];
    const [least, greatest] = [[Infinity, Infinity], [-Infinity, -Infinity]];
    for (const shape of shapes) {
      const [[kind, about]] = Object.entries(shape);
      for (const point of corners(kind, about)) {
        for (const axis of [0, 1]) {
          least[axis] = Math.min(least[axis], point[axis]);
          greatest[axis] = Math.max(greatest[axis], point[axis]);
        }
      }
    }
    return least[0] > greatest[0] ? [[-1, -1], [1, 1]] : [least.map((at) => at - 0.3), greatest.map((at) => at + 0.3)];
  }

  #draw() {
    const sheet = this.#content && begin(this.#canvas);
    if (!sheet) return;
    const { pen, width, height } = sheet;
    const [least, greatest] = this.#area();
    const isTurned = this.#content.forward_up;
    const size = [0, 1].map((axis) => Math.max(0.1, greatest[axis] - least[axis]));
    const scale = this.#zoom * (isTurned ? Math.min(width / size[1], height / size[0]) : Math.min(width / size[0], height / size[1]));
    const middle = [0, 1].map((axis) => (least[axis] + greatest[axis]) / 2);
    const center = [width / 2 + this.#moved[0], height / 2 + this.#moved[1]];
    const screen = ([x, y]) => (isTurned
      ? [center[0] - (y - middle[1]) * scale, center[1] - (x - middle[0]) * scale]
      : [center[0] + (x - middle[0]) * scale, center[1] - (y - middle[1]) * scale]);
    const metres = (across, down) => {
      const [right, up] = [(across - center[0]) / scale, (center[1] - down) / scale];
      return isTurned ? [middle[0] + up, middle[1] - right] : [middle[0] + right, middle[1] + up];
    };
    this.#place = { metres };
    for (const shape of this.#content.shapes) {
      const [[kind, about]] = Object.entries(shape);
      drawShape(pen, kind, about, screen, scale);
    }
    drawScale(pen, height, scale);
  }
}

function trace(pen, points, screen) {
  pen.beginPath();
  for (const point of points) pen.lineTo(...screen(point));
}

function drawShape(pen, kind, shape, screen, scale) {
  pen.strokeStyle = pen.fillStyle = colorOf(shape.stroke?.color ?? shape.color ?? { ink: "plain" });
  pen.lineWidth = shape.stroke?.width ?? 1.5;
  switch (kind) {
    case "line":
      trace(pen, shape.points, screen);
      if (shape.closed) pen.closePath();
      pen.stroke();
      break;
    case "points":
      for (const point of shape.points) {
        const [x, y] = screen(point);
        pen.fillRect(x - pen.lineWidth / 2, y - pen.lineWidth / 2, pen.lineWidth, pen.lineWidth);
      }
      break;
    case "circle":
      pen.beginPath();
      pen.arc(...screen(shape.center), shape.radius * scale, 0, 2 * Math.PI);
      if (shape.filled) pen.fill();
      else pen.stroke();
      break;
    case "polygon":
      trace(pen, shape.points, screen);
      pen.fill();
      break;
    case "arrow": {
      const [from, to] = [screen(shape.from), screen(shape.to)];
      const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
      pen.beginPath();
      pen.moveTo(...from);
      pen.lineTo(...to);
      for (const side of [-2.6, 2.6]) {
        pen.moveTo(...to);
        pen.lineTo(to[0] + 8 * Math.cos(angle + side), to[1] + 8 * Math.sin(angle + side));
      }
      pen.stroke();
      break;
    }
    case "label":
      pen.fillText(shape.text, ...screen(shape.at));
      break;
    case "robot": {
      const [x, y, heading] = shape.pose;
      pen.beginPath();
      pen.arc(...screen([x, y]), 0.2 * scale, 0, 2 * Math.PI);
      pen.moveTo(...screen([x, y]));
      pen.lineTo(...screen([x + 0.3 * Math.cos(heading), y + 0.3 * Math.sin(heading)]));
      pen.stroke();
      break;
    }
  }
}

/** A length of one, two or five metres by which distances are read. */
function drawScale(pen, height, scale) {
  const wanted = 60 / scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [1, 2, 5, 10].map((step) => step * power).find((step) => step >= wanted) ?? wanted;
  pen.strokeStyle = pen.fillStyle = ink("faint");
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(8, height - 8);
  pen.lineTo(8 + length * scale, height - 8);
  pen.stroke();
  pen.fillText(length < 1 ? `${Number((length * 100).toPrecision(2))} cm` : `${length} m`, 10, height - 13);
}

const short = (number) => String(Number(number.toPrecision(3)));

/** Draws curves: [{name, color, points: [[across, up], ...]}]. */
export function plot(canvas, traces, [across, up]) {
  const sheet = begin(canvas);
  if (!sheet) return;
  const { pen, width, height } = sheet;
  const points = traces.flatMap((one) => one.points);
  if (!points.length) return;
  const [left, bottom, top] = [52, 32, 10];
  const range = (axis) => {
    let [least, greatest] = points.reduce(([least, greatest], point) => [Math.min(least, point[axis]), Math.max(greatest, point[axis])], [Infinity, -Infinity]);
    if (greatest - least < 1e-9) [least, greatest] = [least - 0.5, greatest + 0.5];
    return [least, greatest];
  };
  const ranges = [range(0), range(1)];
  const place = ([x, y]) => [
    left + ((x - ranges[0][0]) / (ranges[0][1] - ranges[0][0])) * (width - left - 8),
    height - bottom - ((y - ranges[1][0]) / (ranges[1][1] - ranges[1][0])) * (height - bottom - top),
  ];
  pen.strokeStyle = ink("faint");
  pen.fillStyle = ink("faint");
  pen.lineWidth = 1;
  pen.strokeRect(left, top, width - left - 8, height - bottom - top);
  pen.textAlign = "right";
  for (const value of ranges[1]) pen.fillText(short(value), left - 4, place([ranges[0][0], value])[1] + 4);
  pen.textAlign = "left";
  pen.fillText(short(ranges[0][0]), left, height - bottom + 14);
  pen.textAlign = "center";
  pen.fillText([across, up].filter(Boolean).join("; "), (left + width) / 2, height - 4);
  pen.textAlign = "right";
  pen.fillText(short(ranges[0][1]), width - 8, height - bottom + 14);
  pen.lineWidth = 1.5;
  traces.forEach((one, at) => {
    pen.strokeStyle = pen.fillStyle = colorOf(one.color);
    trace(pen, one.points, place);
    pen.stroke();
    if (traces.length > 1) pen.fillText(one.name, width - 14, top + 14 * (at + 1));
  });
  pen.textAlign = "left";
}
