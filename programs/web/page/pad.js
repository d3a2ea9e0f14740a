// The pad: it drives while a finger, a mouse button or a key holds it, and at no other time. Whatever interrupts the person
// lets go: the finger leaves or is taken by the system, the page is hidden, loses the focus or stood still, the phone is
// turned, the pad is no longer on the screen, the connection ends. Letting go is the absence of orders; the robot's end
// notices it by itself.
const BEAT_MS = 80;
const STOOD_STILL_MS = 350;
const OLD_MS = 700;
const DEAD_ZONE = 0.06;
const KEYS = {
  ArrowUp: [0, 1], KeyW: [0, 1], ArrowDown: [0, -1], KeyS: [0, -1],
  ArrowLeft: [-1, 0], KeyA: [-1, 0], ArrowRight: [1, 0], KeyD: [1, 0], Space: [0, 0],
};
const byId = (id) => document.getElementById(id);
const axis = (push) => (Math.abs(push) < DEAD_ZONE ? 0 : Math.max(-1, Math.min(1, push)));

export class Pad {
  /** The newest tick of the server, and when it came: how old the picture is. */
  #tick = 0;
  #tickAt = -Infinity;
  #since = 0;
  #place; #knob; #order; #say;
  #isOn = false;
  #pointer = null;
  #push = null;
  #keys = new Set();
  #last = 0;
  #beat = null;
  #robots = [];

  constructor(place, knob, order, say) {
    [this.#place, this.#knob, this.#order, this.#say] = [place, knob, order, say];
    place.addEventListener("pointerdown", (event) => this.#down(event));
    place.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      place.addEventListener(end, (event) => { if (event.pointerId === this.#pointer) this.release("released"); });
    }
    place.addEventListener("contextmenu", (event) => { event.preventDefault(); this.release("released"); });
    place.addEventListener("keydown", (event) => this.#key(event, true));
    place.addEventListener("keyup", (event) => this.#key(event, false));
    place.addEventListener("blur", () => { if (this.#pointer === null) this.release("released"); });
    const release = (why) => () => this.release(why);
    addEventListener("blur", release("released: another window has the focus"));
    addEventListener("pagehide", release("released"));
    addEventListener("resize", release("released: the screen has changed"));
    addEventListener("beforeprint", release("released"));
    screen.orientation?.addEventListener("change", release("released: the phone was turned"));
    document.addEventListener("visibilitychange", release("released: the page was hidden"));
    document.addEventListener("freeze", release("released"));
    byId("drive-on").addEventListener("click", () => this.#toggle(!this.#isOn));
    byId("drive-schema").addEventListener("change", () => { this.release("released"); this.#limit(); });
    byId("speed").addEventListener("input", () => this.#showSpeed());
  }

  /** Sets what can be driven: [{schema}]. Nothing is driven until its limit is known. */
  choose(robots) {
    this.#robots = robots;
    byId("drive").hidden = !robots.length;
    byId("drive-choice").hidden = robots.length < 2;
    const chosen = byId("drive-schema").value;
    byId("drive-schema").replaceChildren(...robots.map(({ schema }) => new Option(schema, schema)));
    if (robots.some(({ schema }) => schema === chosen)) byId("drive-schema").value = chosen;
    this.#limit();
    if (!robots.length) this.#toggle(false);
  }

  /** Sets the greatest speeds: [[schema, m/s or null]]. They may change while one drives. */
  setLimits(limits) {
    const known = new Map(limits);
    const changed = this.#robots.filter((robot) => (known.get(robot.schema) ?? 0) !== (robot.fast ?? 0));
    for (const robot of changed) robot.fast = known.get(robot.schema) ?? 0;
    if (changed.length) this.#limit();
  }

  setTick(tick) {
    [this.#tick, this.#tickAt] = [tick, performance.now()];
  }

  /** Shows who else drives. */
  setDrivers(driving, by) {
    const schema = byId("drive-schema").value;
    const other = driving.find((one) => one.schema === schema && !one.by.startsWith(`${by} (`));
    if (this.#push) return;
    if (other) this.#say(`${other.by} drives now.`);
    else if (byId("drive-text").textContent.endsWith("drives now.")) this.#say("Hold the pad to drive.");
  }

  answer({ held, text }) {
    if (!this.#push) return;
    if (held) this.#say("Driving. Let go to stop.");
    // The answer to letting go may come when the pad is held again.
    else if (text !== "released" || performance.now() - this.#since > 1000) this.release(text || "released");
  }

  release(why) {
    const wasHeld = this.#push !== null;
    [this.#pointer, this.#push] = [null, null];
    this.#keys.clear();
    clearInterval(this.#beat);
    delete this.#place.dataset.held;
    this.#knob.style.transform = "";
    if (wasHeld) {
      this.#order({ do: "let-go" });
      this.#say(`${why[0].toUpperCase()}${why.slice(1)}. Hold the pad to drive.`);
    }
  }

  #toggle(isOn) {
    this.release("released");
    this.#isOn = isOn;
    byId("drive-on").setAttribute("aria-pressed", String(isOn));
    byId("drive-pad").hidden = !isOn;
    if (isOn) this.#say("Hold the pad to drive.");
  }

  #limit() {
    const robot = this.#robots.find(({ schema }) => schema === byId("drive-schema").value);
    const fast = robot?.fast ?? 0;
    const speed = byId("speed");
    byId("drive-on").disabled = speed.disabled = !fast;
    if (!fast) {
      if (this.#isOn) this.#toggle(false);
      byId("speed-text").textContent = robot ? `the limit ${robot.schema}.fast is 0 or not known` : "";
      return;
    }
    const before = Number(speed.dataset.chosen ?? 0.3);
    speed.max = fast;
    speed.step = fast / 20;
    speed.min = fast / 20;
    speed.value = Math.min(before, fast);
    this.#showSpeed();
  }

  #showSpeed() {
    const speed = byId("speed");
    speed.dataset.chosen = speed.value;
    byId("speed-text").textContent = `${Number(speed.value).toFixed(2)} m/s`;
  }

  #down(event) {
    // A second finger neither drives nor takes over.
    if (!this.#isOn || this.#pointer !== null || event.button !== 0) return;
    event.preventDefault();
    this.#place.focus({ preventScroll: true });
    this.#place.setPointerCapture(event.pointerId);
    this.#pointer = event.pointerId;
    this.#hold(this.#deflection(event));
  }

  #move(event) {
    if (event.pointerId !== this.#pointer) return;
    // A release that was lost, as behind a message of the system.
    if (event.buttons === 0) this.release("released");
    else this.#hold(this.#deflection(event));
  }

  #key(event, isDown) {
    // Some systems say no longer which keys are let go while a modifier is held.
    if (event.ctrlKey || event.altKey || event.metaKey) {
      if (this.#keys.size) this.release("released");
      return;
    }
    if (!(event.code in KEYS) || !this.#isOn) return;
    event.preventDefault();
    if (!isDown) this.#keys.delete(event.code);
    // A key that was held when the pad was released holds nothing again by its repetitions.
    else if (event.repeat && !this.#keys.has(event.code)) return;
    else this.#keys.add(event.code);
    if (this.#pointer !== null) return;
    if (!this.#keys.size) return this.release("released");
    const pushes = [...this.#keys].map((code) => KEYS[code]);
    this.#hold(this.#keys.has("Space") ? [0, 0] : [0, 1].map((at) => axis(pushes.reduce((sum, push) => sum + push[at], 0))));
  }

  #deflection(event) {
    const area = this.#place.getBoundingClientRect();
    const half = area.width / 2;
    let [x, y] = [(event.clientX - area.left - half) / half, -(event.clientY - area.top - half) / half];
    const length = Math.hypot(x, y);
    if (length > 1) [x, y] = [x / length, y / length];
    return [axis(x), axis(y)];
  }

  #hold(push) {
    const isNew = this.#push === null;
    this.#push = push;
    const radius = this.#place.clientWidth / 2 - 36;
    this.#knob.style.transform = `translate(${push[0] * radius}px, ${-push[1] * radius}px)`;
    this.#place.dataset.held = "";
    if (isNew) {
      this.#say("Asking for the robot.");
      this.#last = this.#since = performance.now();
      clearInterval(this.#beat);
      this.#beat = setInterval(() => this.#repeat(), BEAT_MS);
      this.#send();
    }
  }

  #repeat() {
    const now = performance.now();
    const stood = now - this.#last;
    this.#last = now;
    const isShown = this.#place.isConnected && this.#place.getClientRects().length > 0;
    if (stood > STOOD_STILL_MS) this.release("released: the page stood still");
    else if (now - this.#tickAt > OLD_MS) this.release("released: nothing came from the robot");
    else if (!isShown || document.hidden || !document.hasFocus()) this.release("released: the pad is not in use");
    else this.#send();
  }

  #send() {
    const sent = this.#order({
      do: "drive", schema: byId("drive-schema").value, ahead: this.#push[1], left: -this.#push[0],
      speed: Number(byId("speed").value), tick: this.#tick,
    });
    if (!sent) this.release("released: no connection to the robot");
  }
}
