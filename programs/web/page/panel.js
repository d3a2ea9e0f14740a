// A schema's panel: a list of widgets that the schema declares. Each text of it is put into the page as text. Widgets stay as
// they are while the list has the same ones, so that a finger on a slider is not interrupted.
import { Plane, button, element, plot, setText } from "/draw.js";

const rounded = (value) => String(Number(value.toPrecision(4)));
const WORDS = { plain: "", heading: "heading", faint: "faint", good: "good", warning: "warning", error: "bad", code: "code" };

/** Gestures that wait while one is under way. */
const MOST_WAITING = 8;

export class Panel {
  #structure = "";
  #updates = [];
  #touch;
  #mayOperate;
  #isWaiting = false;
  #next = [];

  /** `touch(gesture, done)` passes a gesture on, and calls `done` with its outcome. */
  constructor(label, touch, mayOperate) {
    this.element = element("div", undefined, "panel");
    this.element.setAttribute("role", "group");
    this.element.setAttribute("aria-label", label);
    this.answer = element("p", "", "bad");
    this.answer.setAttribute("role", "status");
    this.#touch = touch;
    this.#mayOperate = mayOperate;
  }

  show({ items, error }) {
    const shown = error ? [{ text: { text: error, words: "warning" } }] : items;
    const structure = JSON.stringify(shown.map(form));
    if (structure !== this.#structure) {
      this.#structure = structure;
      this.#updates = [];
      this.element.replaceChildren(...shown.map((item) => this.#make(item)), this.answer);
    }
    shown.flatMap(flat).forEach((item, at) => this.#updates[at](Object.values(item)[0]));
  }

  /** Passes a gesture on. Of a movement the newest place counts; a press and the end of a drag are not left out. */
  #send(widget, touch) {
    if (this.#isWaiting) {
      const last = this.#next.at(-1);
      if (last?.[0] === widget && (last[1].moved !== undefined || last[1].dragged?.ended === false)) this.#next.pop();
      if (this.#next.length < MOST_WAITING) this.#next.push([widget, touch]);
      return;
    }
    this.#isWaiting = true;
    this.#touch({ widget, touch }, (ok, text) => {
      setText(this.answer, ok ? "" : `Refused: ${text}`);
      if (!ok) this.#next.length = 0;
      // No faster than the robot takes messages of a page.
      setTimeout(() => {
        this.#isWaiting = false;
        const next = this.#next.shift();
        if (next) this.#send(...next);
      }, 40);
    });
  }

  #make(item) {
    const [[kind, first]] = Object.entries(item);
    const send = (touch) => this.#send(first.id, touch);
    // The place of the widget comes before those inside it.
    const at = this.#updates.push(() => {}) - 1;
    const updates = (update) => { this.#updates[at] = update; };
    const isOff = !this.#mayOperate();
    switch (kind) {
      case "text": {
        const place = element(first.words === "heading" ? "h3" : "p", "", WORDS[first.words]);
        updates(({ text }) => setText(place, text));
        return place;
      }
      case "value": {
        const [place, number] = [element("p", `${first.label}: `), element("b")];
        place.append(number);
        updates(({ value, unit }) => setText(number, `${rounded(value)} ${unit}`));
        return place;
      }
      case "button": {
        const place = button(first.label, () => send("pressed"));
        updates(({ label, enabled }) => {
          setText(place, label);
          place.disabled = isOff || !enabled;
        });
        return place;
      }
      case "toggle": {
        const place = button(first.label, () => send({ toggled: place.getAttribute("aria-pressed") !== "true" }));
        place.disabled = isOff;
        updates(({ on }) => place.setAttribute("aria-pressed", String(on)));
        return place;
      }
      case "slider": {
        const [place, number, input] = [element("label", `${first.label} `), element("output"), element("input")];
        input.type = "range";
        input.disabled = isOff;
        let touched = -Infinity;
        input.addEventListener("input", () => {
          touched = performance.now();
          setText(number, `${rounded(Number(input.value))} ${first.unit}`);
          send({ moved: Number(input.value) });
        });
        place.append(number, input);
        updates(({ value, least, greatest, unit }) => {
          [input.min, input.max, input.step] = [least, greatest, (greatest - least) / 200 || 1];
          // Until the schema has taken it, the number is that of the finger.
          if (performance.now() - touched < 1000) return;
          input.value = value;
          setText(number, `${rounded(value)} ${unit}`);
        });
        return place;
      }
      case "choice": {
        const [place, input] = [element("label", `${first.label} `), element("select")];
        input.disabled = isOff;
        input.append(...first.options.map((option, at) => new Option(option, at)));
        input.addEventListener("change", () => send({ chose: Number(input.value) }));
        place.append(input);
        updates(({ chosen }) => { if (document.activeElement !== input) input.value = chosen; });
        return place;
      }
      case "image": {
        const [place, shown] = [element("figure"), element("canvas")];
        shown.setAttribute("role", "img");
        shown.setAttribute("aria-label", `Picture ${first.id}`);
        let size = [1, 1];
        shown.addEventListener("click", (event) => {
          const area = shown.getBoundingClientRect();
          const at = [event.clientX - area.left, event.clientY - area.top];
          if (first.wants.clicks && !isOff) send({ clicked: { at: [(at[0] / area.width) * size[0], (at[1] / area.height) * size[1], 0], button: "primary" } });
        });
        place.append(shown);
        updates((image) => {
          size = image.size;
          drawImage(shown, image);
        });
        return place;
      }
      case "plot": {
        const [place, shown] = [element("figure"), element("canvas", undefined, "plot")];
        shown.setAttribute("role", "img");
        shown.setAttribute("aria-label", `Curves: ${first.label}`);
        place.append(element("figcaption", first.label), shown);
        updates(({ traces, across, up }) => plot(shown, traces, [across, up]));
        return place;
      }
      case "table": {
        const place = element("table");
        updates(({ columns, rows }) => {
          const line = (kind, cells) => {
            const made = element("tr");
            made.append(...cells.map((cell) => element(kind, cell)));
            return made;
          };
          place.replaceChildren(line("th", columns), ...rows.map((cells) => line("td", cells)));
        });
        return place;
      }
      case "row": {
        const place = element("div", undefined, "line");
        place.append(...first.items.map((inner) => this.#make(inner)));
        return place;
      }
      case "group": {
        const place = element("details");
        place.open = first.open;
        const title = element("summary", first.label);
        place.append(title, ...first.items.map((inner) => this.#make(inner)));
        updates(({ label }) => setText(title, label));
        return place;
      }
      case "canvas": {
        const plane = new Plane(`Plane ${first.id}`, (touch) => { if (!isOff) send(touch); });
        updates((content) => plane.show(content));
        return plane.element;
      }
      default:
        return element("p", "The windows of jde view show what this panel draws in space.", "faint");
    }
  }
}

/** What makes a widget another one: its kind, its name, and what is inside. */
function form(item) {
  const [[kind, about]] = Object.entries(item);
  const more = { text: about.words, value: about.label, choice: about.options, row: about.items?.map(form), group: about.items?.map(form), canvas: about.wants };
  return [kind, about.id, more[kind]];
}

/** A widget and those inside it, in the order in which they are made. */
function flat(item) {
  const [about] = Object.values(item);
  return [item, ...(about.items ?? []).flatMap(flat)];
}

function drawImage(place, { width, height, channels, pixels }) {
  if (!width || !height) return;
  const bytes = atob(pixels);
  const shown = new ImageData(width, height);
  for (let at = 0; at < width * height; at++) {
    const part = (channel) => bytes.charCodeAt(at * channels + (channels === 1 ? 0 : channel));
    shown.data.set([part(0), part(1), part(2), channels === 4 ? part(3) : 255], at * 4);
  }
  if (place.width !== width || place.height !== height) [place.width, place.height] = [width, height];
  place.getContext("2d").putImageData(shown, 0, 0);
}
