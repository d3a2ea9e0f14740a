// Shows what the robot sends. Every text of a robot is put into the page as text.
import { Plane, element, setText } from "/draw.js";
import { Curves } from "/curves.js";
import { Panel } from "/panel.js";

const byId = (id) => document.getElementById(id);
const seconds = (time) => `${time.toFixed(3)} s`;

export class View {
  /** The schema whose values are shown. */
  opened = null;
  by = "";
  silent = 0;
  #controls;
  #rows = new Map();
  #names = "";
  #acting = "";
  #stoppedBy = "";
  #missed = 0;
  #panels = new Set();
  #panel = null;
  #curves = null;
  #floor = new Plane("The robot from above");
  #isFloorSeen = false;

  constructor(controls) {
    this.#controls = controls;
    byId("floor-place").replaceWith(this.#floor.element);
    // What nobody sees is not sent.
    new IntersectionObserver(([seen]) => {
      this.#isFloorSeen = seen.isIntersecting;
      this.look();
    }).observe(byId("floor"));
  }

  welcome({ name, application, host, by, share, replay, floor, panels }) {
    this.by = by;
    this.#panels = new Set(panels);
    byId("floor").hidden = !floor;
    document.title = `${name} · jde`;
    setText(byId("name"), name);
    const what = replay ? "a recording of " : "";
    setText(byId("about"), `${what}${application} on ${host}. You are ${by}.`);
    byId("me").value = by.startsWith("page@") ? "" : by.split("@")[0];
    byId("share").hidden = !share;
    byId("share-address").value = share ?? "";
    // The rights may have changed.
    this.#names = "";
    byId("lines").replaceChildren();
  }

  state(state) {
    this.silent = state.silent_s ?? 0;
    if (state.missed > this.#missed) this.notice(`${state.missed - this.#missed} lines were lost on the way from the robot.`);
    this.#missed = state.missed;
    const ending = byId("ending");
    ending.hidden = !state.ending && !state.standstill;
    if (state.ending) {
      setText(ending, `${state.ending.word}: ${state.ending.reason}`);
      ending.className = state.ending.severity;
    } else if (state.standstill) {
      setText(ending, `Time stands still: ${state.standstill}`);
      ending.className = "warning";
    }
    this.#stopped(state.stopped);
    this.#acts(state.acting);
    this.#missions(state.missions);
    this.#tree(state.rows);
  }

  #stopped(stopped) {
    const by = stopped?.by ?? "";
    if (by !== this.#stoppedBy) {
      // The question whether it may go on was asked of another stop.
      this.#stoppedBy = by;
      byId("go-on").hidden = false;
      byId("go-on-yes").hidden = byId("go-on-no").hidden = true;
    }
    byId("stopped").hidden = !stopped;
    if (!stopped) return;
    const others = stopped.others.length ? ` ${stopped.others.join(", ")} goes on.` : "";
    setText(byId("stopped-text"), `Everything was stopped by ${stopped.by}.${others}`);
    byId("go-on").disabled = !this.#controls.mayOperate();
  }

  #acts(acting) {
    const key = JSON.stringify(acting);
    if (key === this.#acting) return;
    this.#acting = key;
    byId("acting").replaceChildren(...acting.map((one) => {
      const place = element("div", undefined, "acts");
      const line = element("p");
      line.append(element("b", one.name), one.name === "nobody" ? " acts" : ` acts in ${one.group}`);
      place.append(line);
      const facts = element("dl");
      const add = (term, text) => { if (text) facts.append(element("dt", term), element("dd", text)); };
      add("Because", one.reason);
      add("Since", one.since_s === null ? "" : `${seconds(one.since_s)}, after ${one.before}`);
      add("Case", one.case);
      add("Decided by", one.decided_by);
      add("Cause", one.cause);
      place.append(facts);
      return place;
    }));
    if (!acting.length) byId("acting").append(element("p", "No group has selected yet."));
  }

  #missions(missions) {
    const place = byId("missions");
    while (place.children.length > missions.length) place.lastChild.remove();
    while (place.children.length < missions.length) place.append(element("p"));
    missions.forEach((mission, at) => {
      const line = place.children[at];
      setText(line, `Mission of ${mission.name}: ${mission.word}${mission.text ? `. ${mission.text}` : ""}`);
      line.className = mission.severity;
    });
  }

  #tree(rows) {
    const names = JSON.stringify(rows.map((row) => [row.kind, row.name, row.depth]));
    if (names !== this.#names) {
      this.#names = names;
      this.#rows.clear();
      byId("rows").replaceChildren(...rows.map((row) => this.#row(row)));
      if (this.opened) this.#open(this.opened, true);
    }
    for (const row of rows) if (row.kind === "schema") this.#rows.get(row.name)?.update(row);
  }

  #row({ kind, name, depth, detail }) {
    const item = element("li", undefined, `row d${Math.min(depth, 8)}`);
    if (kind !== "schema") {
      const line = element("div", undefined, "head");
      line.append(element("span", name));
      item.append(line);
      return item;
    }
    const button = element("button");
    button.type = "button";
    button.setAttribute("aria-expanded", "false");
    const [title, state, held, more] = [element("span", name, "name"), element("span", "", "state"), element("span", "", "held warning"), element("span", "", "more")];
    button.append(title, state, held, more);
    button.addEventListener("click", () => this.#open(this.opened === name ? null : name));
    item.append(button);
    this.#rows.set(name, {
      item, button, detail,
      update: (row) => {
        item.dataset.stopped = String(row.stopped);
        setText(state, row.state);
        state.dataset.state = row.state;
        setText(held, row.held ?? "");
        const health = row.health === "ok" ? "" : row.health + (row.health_reason ? `: ${row.health_reason}` : "");
        setText(more, health);
        more.className = `more ${row.severity}`;
        const load = item.querySelector(".load");
        if (load) setText(load, `Load ${(100 * row.load).toFixed(1)} %${row.authority ? "; its commands take effect" : ""}`);
        for (const one of item.querySelectorAll("[data-do]")) one.disabled = !this.#controls.mayOperate();
      },
    });
    return item;
  }

  #open(name, again) {
    const before = this.#rows.get(this.opened);
    before?.item.querySelector(".details")?.remove();
    before?.button.setAttribute("aria-expanded", "false");
    this.opened = name;
    const row = this.#rows.get(name);
    [this.#panel, this.#curves] = [null, null];
    if (row) {
      row.button.setAttribute("aria-expanded", "true");
      row.item.append(this.#details(name, row.detail));
    }
    if (!again || row) this.look();
  }

  /** Says what this page shows beside the state. */
  look() {
    const at = this.#isFloorSeen && !byId("floor").hidden ? [{ what: "floor" }] : [];
    if (this.#rows.has(this.opened)) at.push({ what: "values", of: this.opened });
    if (this.#panel) at.push({ what: "panel", of: this.opened });
    this.#controls.order({ do: "look", at });
  }

  looks(news) {
    for (const { topic, parts } of news) {
      if (topic.what === "floor") this.#above(parts[0]);
      else if (topic.of !== this.opened) continue;
      else if (topic.what === "panel") this.#panel?.show(parts[0]);
      else this.#values(parts);
    }
  }

  #above({ items, text, error }) {
    setText(byId("floor-text"), error ?? text);
    if (items) this.#floor.show(items[0].canvas, `The robot from above: ${text}`);
  }

  #details(name, type) {
    const place = element("div", undefined, "details");
    place.append(element("p", `Type ${type}`), element("p", "", "load"));
    const answer = element("p", "", "answer");
    answer.setAttribute("role", "status");
    if (this.#controls.mayOperate()) {
      const line = element("div", undefined, "line");
      for (const [what, label] of [["play", "Play"], ["stop", "Stop"], ["release", "Release"]]) {
        const button = element("button", label);
        button.type = "button";
        button.dataset.do = what;
        button.setAttribute("aria-label", `${label} ${name}`);
        button.addEventListener("click", (event) => {
          // What lets a stopped schema move is asked once, and a double click does not answer.
          const isStopped = place.closest("li")?.dataset.stopped === "true";
          if (what !== "stop" && isStopped && !button.dataset.asked) {
            button.dataset.asked = "1";
            setText(button, `${label}: the robot may move at once`);
            return;
          }
          if (button.dataset.asked && event.detail > 1) return;
          delete button.dataset.asked;
          setText(button, label);
          setText(answer, "...");
          this.#controls.act({ do: what, schema: name }, (ok, text) => {
            setText(answer, ok ? text : `Refused: ${text}`);
            answer.className = ok ? "answer warning" : "answer bad";
          });
        });
        line.append(button);
      }
      place.append(line, answer);
    }
    if (this.#panels.has(name)) {
      const touch = (gesture, done) => this.#controls.act({ do: "touch", schema: name, gesture }, done);
      this.#panel = new Panel(`Panel of ${name}`, touch, this.#controls.mayOperate);
      place.append(this.#panel.element);
    }
    this.#curves = new Curves();
    const table = element("table");
    const caption = element("caption", "");
    caption.hidden = true;
    const body = element("tbody");
    table.setAttribute("aria-label", `Values of ${name}`);
    table.append(body);
    place.append(table, this.#curves.element);
    return place;
  }

  #values(values) {
    const body = this.#rows.get(this.opened)?.item.querySelector("tbody");
    if (!body) return;
    for (const value of values) {
      if (value.error) {
        this.notice(value.error);
        continue;
      }
      let row = [...body.children].find((known) => known.dataset.name === value.name);
      if (!row) {
        row = element("tr");
        row.dataset.name = value.name;
        const head = element("th", value.name);
        head.scope = "row";
        head.title = `${value.access}. ${value.doc}`;
        const cell = element("td");
        cell.append(element("span"), element("span", undefined, "line"));
        row.append(head, cell);
        body.append(row);
      }
      const [cell] = row.getElementsByTagName("td");
      setText(cell.firstChild, value.text);
      this.#curves?.add(value, cell.lastChild);
    }
  }

  log({ lines, missed }) {
    const place = byId("lines");
    if (missed && place.children.length) place.prepend(element("li", `${missed} lines were left out: this page read too slowly.`, "warning"));
    for (const line of lines) {
      const item = element("li");
      item.append(element("time", seconds(line.time_s)), element("span", line.text, line.severity === "good" ? "" : line.severity));
      if (line.because) item.append(element("small", line.because));
      place.prepend(item);
    }
    while (place.children.length > 300) place.lastChild.remove();
  }

  notice(text) {
    byId("lines").prepend(element("li", text, "bad"));
  }
}
