// Curves of numbers over time, of the schema that is open: as long as a minute, from when a person asks for one.
import { button, element, plot } from "/draw.js";

const MOST_S = 60;
const MOST_POINTS = 600;
const COLORS = ["accent", "goal", "bad", "good"];

export class Curves {
  #canvas = element("canvas", undefined, "plot");
  /** By name: the points, oldest first. */
  #shown = new Map();
  #buttons = new Map();
  #now = 0;

  constructor() {
    this.element = element("figure");
    this.element.hidden = true;
    this.#canvas.setAttribute("role", "img");
    this.element.append(element("figcaption", "Over the last minute"), this.#canvas);
  }

  /** Takes a value, and offers a button for each of its numbers. */
  add(value, place) {
    this.#now = Math.max(this.#now, value.time_s);
    // What was taken back has no curve.
    const present = new Set(value.numbers.map(([field]) => (field ? `${value.name}.${field}` : value.name)));
    for (const [name, points] of this.#shown) {
      if ((name === value.name || name.startsWith(`${value.name}.`)) && !present.has(name)) points.length = 0;
    }
    for (const [field, number] of value.numbers) {
      const name = field ? `${value.name}.${field}` : value.name;
      if (!this.#buttons.has(name)) this.#offer(name, field, place);
      this.#shown.get(name)?.push([value.time_s, number]);
    }
    this.#draw();
  }

  #offer(name, field, place) {
    const made = button(field ? `∿ ${field}` : "∿", () => {
      if (!this.#shown.delete(name) && this.#shown.size < COLORS.length) this.#shown.set(name, []);
      made.setAttribute("aria-pressed", String(this.#shown.has(name)));
      this.#draw();
    });
    made.className = "curve";
    made.setAttribute("aria-label", `Curve of ${name}`);
    made.setAttribute("aria-pressed", "false");
    this.#buttons.set(name, made);
    place.append(made);
  }

  #draw() {
    this.element.hidden = !this.#shown.size;
    const traces = [...this.#shown].map(([name, points], at) => {
      while (points.length > MOST_POINTS || points[0]?.[0] < this.#now - MOST_S) points.shift();
      const last = points.at(-1);
      // A value that stays is not sent again.
      return { name, color: { ink: COLORS[at] }, points: last ? [...points, [this.#now, last[1]]] : [] };
    });
    this.#canvas.setAttribute("aria-label", `Curves: ${[...this.#shown].map(([name, points]) => `${name} ${points.at(-1)?.[1] ?? "has no value yet"}`).join(", ")}`);
    plot(this.#canvas, traces, ["time, s", this.#shown.size === 1 ? [...this.#shown.keys()][0] : ""]);
  }
}
