// The page's connection and what its buttons order. The authority is the socket's: the page shows the token on it once, and
// sends it in no request of its own.
import { View } from "/view.js";
import { Pad } from "/pad.js";

const ALIVE_MS = 3000;
const SILENT_MS = 1500;
const DEAD_MS = 4000;
const ANSWER_MS = 1000;
/** A stop that nobody has acknowledged is asked for again after this time. */
const ASK_AGAIN_MS = 2000;
/** By then the state shows that the robot is stopped, unless somebody let it go on. */
const STOPPED_MS = 2000;
const byId = (id) => document.getElementById(id);

let socket = null;
let right = null;
let lastState = 0;
let lastMessage = 0;
/** Why the robot sent this page away, until the next connection. */
let refusal = "";
/** Whether the robot has shown the stop that this page ordered last. */
let stoppedAt = -Infinity;
let isStopSeen = false;
let retry = 0;
let nextId = 1;
const waiting = new Map();
/** The stop that is not acknowledged yet: {id, since, isSent, failure, askAt}. It is asked again until it is. */
let stop = null;

// Taken from the address at once, so that no history, no picture of the screen and no other page has it. It stays in this
// tab, for when the page is loaded again.
const memory = (() => {
  try { return window.sessionStorage; } catch { return null; }
})();
function takeToken() {
  const token = location.hash.slice(1);
  if (token) {
    history.replaceState(null, "", location.pathname);
    memory?.setItem("jde-token", token);
  }
  return token || memory?.getItem("jde-token") || "";
}
let token = takeToken();
// Another address opened in the same tab changes only what is behind the `#`.
addEventListener("hashchange", () => {
  token = takeToken();
  leave();
  connect();
});

const view = new View({ order: send, act, mayOperate: () => right === "operate" });
const pad = new Pad(byId("pad"), byId("knob"), (order) => send(order), (text) => { byId("drive-text").textContent = text; });

function send(message) {
  if (socket?.readyState !== WebSocket.OPEN || right === null) return false;
  socket.send(JSON.stringify(message));
  return true;
}

/** Orders something, and shows the answer. */
function act(message, show) {
  const id = nextId++;
  if (send({ ...message, id })) waiting.set(id, show);
  else show(false, "no connection to the robot");
}

function setConnection(kind, text) {
  document.body.dataset.connection = kind;
  const place = byId("connection");
  if (place.textContent !== text) place.textContent = text;
}

/** Leaves the socket without waiting for its end, which a network that is gone never tells. */
function leave() {
  const old = socket;
  socket = null;
  old?.close();
  forget();
}

function connect() {
  if (!token) {
    setConnection("none", "Not connected");
    byId("enter").hidden = false;
    return;
  }
  const own = new WebSocket(`${location.origin.replace(/^http/, "ws")}/socket`);
  socket = own;
  lastMessage = performance.now();
  const isFirst = !lastState;
  setConnection(isFirst ? "none" : "lost", isFirst ? "Connecting" : "Connecting. What you see is old.");
  own.onopen = () => own.send(JSON.stringify({ do: "enter", token, name: memory?.getItem("jde-name") || "" }));
  own.onmessage = (event) => { if (own === socket) take(JSON.parse(event.data)); };
  own.onclose = () => { if (own === socket) lost(); };
}

/** Forgets what belonged to the socket. */
function forget() {
  right = null;
  pad.release("released: the connection is lost");
  for (const show of waiting.values()) show(false, "the connection is lost: what became of this is not known");
  waiting.clear();
  if (stop) stop.isSent = false;
}

function lost() {
  leave();
  if (!token) return connect();
  setConnection("lost", refusal || "No connection. What you see is old.");
  refusal = "";
  retry = Math.min(4000, retry ? retry * 1.7 : 400);
  // A hidden page enters again when it is seen, unless a stop waits.
  setTimeout(() => { if (!socket && (stop || !document.hidden)) connect(); }, retry);
}

function take(message) {
  lastMessage = performance.now();
  switch (message.t) {
    case "welcome":
      right = message.right;
      retry = 0;
      document.body.dataset.right = right;
      byId("enter").hidden = true;
      view.welcome(message);
      pad.choose(right === "operate" ? message.drive : []);
      setConnection("open", "Connected");
      if (right !== "operate") sayStop(`This page cannot stop the robot: ${message.looks_only}.`, "plain");
      else if (byId("stop-text").textContent.startsWith("This page cannot")) sayStop("", "plain");
      if (stop) sendStop();
      view.look();
      break;
    case "state":
      view.state(message);
      if (message.stopped) isStopSeen = true;
      else if (!stop && (isStopSeen || performance.now() - stoppedAt > STOPPED_MS)) {
        isStopSeen = false;
        if (byId("stop-text").textContent.startsWith("Stopped at")) sayStop("", "plain");
      }
      pad.setDrivers(message.driving, view.by);
      pad.setLimits(message.limits);
      lastState = performance.now();
      break;
    case "tick":
      pad.setTick(message.n);
      break;
    case "log":
      view.log(message);
      break;
    case "looks":
      send({ do: "taken" });
      view.looks(message.news);
      break;
    case "answer":
      if (stop?.id === message.id) stopAnswered(message);
      waiting.get(message.id)?.(message.ok, message.text);
      waiting.delete(message.id);
      break;
    case "drive":
      pad.answer(message);
      break;
    case "refused":
      if (right === null && !message.is_token) {
        refusal = message.text;
      } else if (right === null) {
        token = "";
        memory?.removeItem("jde-token");
        byId("enter-text").textContent = message.text;
      } else {
        view.notice(message.text);
      }
      break;
  }
}

// The stop. It works at the touch, and not when the finger leaves; a key and a screen reader click.
function sayStop(text, severity) {
  const place = byId("stop-text");
  if (place.textContent !== text) place.textContent = text;
  place.dataset.severity = severity;
}

function sendStop() {
  stop.sentAt = performance.now();
  stop.isSent = send({ do: "stop-all", id: stop.id });
}

function pressStop() {
  pad.release("released: everything is stopped");
  isStopSeen = false;
  if (!stop) stop = { id: nextId++, since: performance.now(), sentAt: -Infinity, isSent: false, failure: "", askAt: 0 };
  // Pressing again while the robot answers asks again, but not faster than it takes orders.
  if (!stop.isSent || performance.now() - stop.sentAt > 300) sendStop();
  if (!socket) connect();
  showStop();
}

function showStop() {
  if (!stop) return;
  const isDue = !stop.isSent || performance.now() - stop.sentAt > ASK_AGAIN_MS;
  if (isDue && right !== null && performance.now() >= stop.askAt) sendStop();
  const waited = (performance.now() - stop.since) / 1000;
  if (stop.failure) sayStop(`NOT stopped: ${stop.failure}. It is asked again. Use the switch of the robot.`, "bad");
  else if (stop.isSent && waited * 1000 < ANSWER_MS) sayStop("Stopping", "plain");
  else if (stop.isSent) sayStop(`Stopping: no answer for ${waited.toFixed(0)} s. Use the switch of the robot.`, "bad");
  else sayStop(`NOT stopped: no connection for ${waited.toFixed(0)} s. It is sent as soon as there is one. Use the switch of the robot.`, "bad");
}

function stopAnswered({ ok, text }) {
  if (ok) {
    stoppedAt = performance.now();
    sayStop(`Stopped at ${new Date().toLocaleTimeString()}`, "plain");
    stop = null;
  } else {
    [stop.failure, stop.isSent, stop.askAt] = [text, false, performance.now() + 1000];
    showStop();
  }
}

const stopButton = byId("stop");
let touched = -Infinity;
stopButton.addEventListener("pointerdown", (event) => {
  event.preventDefault();
  touched = performance.now();
  pressStop();
});
// The click that follows a touch orders nothing more.
stopButton.addEventListener("click", () => { if (performance.now() - touched > 1000) pressStop(); });
addEventListener("keydown", (event) => {
  if (event.code === "Space" && event.ctrlKey && !event.repeat && right !== "read") {
    event.preventDefault();
    pressStop();
  }
}, { capture: true });

// Where a person has zoomed in, or a keyboard covers the page, the bar follows to the part that is on the screen.
function followZoom() {
  const seen = window.visualViewport;
  const bar = byId("stop-bar");
  const isColumn = matchMedia("(orientation: landscape) and (max-height: 520px)").matches;
  const left = seen ? seen.offsetLeft + (isColumn ? seen.width - innerWidth : 0) : 0;
  const up = seen ? seen.offsetTop + seen.height - innerHeight : 0;
  const isWhole = !seen || (Math.abs(seen.scale - 1) < 0.02 && Math.abs(left) < 2 && Math.abs(up) < 2);
  bar.style.transform = isWhole ? "" : `translate(${left}px, ${up}px) scale(${1 / seen.scale})`;
}
window.visualViewport?.addEventListener("resize", followZoom);
window.visualViewport?.addEventListener("scroll", followZoom);

byId("enter-form").addEventListener("submit", (event) => {
  event.preventDefault();
  token = byId("token").value.trim().replace(/^.*#/, "");
  if (token) memory?.setItem("jde-token", token);
  memory?.setItem("jde-name", byId("person").value.trim());
  if (!socket) connect();
});

// The name belongs to the socket, so a new one takes it.
byId("me").addEventListener("change", (event) => {
  memory?.setItem("jde-name", event.target.value.trim());
  leave();
  connect();
});

const goOn = (asks) => {
  byId("go-on").hidden = asks;
  byId("go-on-yes").hidden = byId("go-on-no").hidden = !asks;
  (asks ? byId("go-on-no") : byId("go-on")).focus();
};
byId("go-on").addEventListener("click", () => goOn(true));
byId("go-on-no").addEventListener("click", () => goOn(false));
byId("go-on-yes").addEventListener("click", () => {
  goOn(false);
  act({ do: "release-all" }, (ok, text) => sayStop(ok ? "" : `It does not go on: ${text}`, ok ? "plain" : "bad"));
});

setInterval(() => {
  showStop();
  if (socket && performance.now() - lastMessage > DEAD_MS) return lost();
  if (document.body.dataset.connection !== "open" && document.body.dataset.connection !== "silent") return;
  const age = performance.now() - lastState;
  if (age > SILENT_MS) setConnection("silent", `Nothing new for ${(age / 1000).toFixed(0)} s`);
  else if (view.silent) setConnection("silent", `The application is silent for ${view.silent.toFixed(0)} s`);
  else setConnection("open", "Connected");
}, 250);
setInterval(() => { if (!document.hidden) send({ do: "alive" }); }, ALIVE_MS);
document.addEventListener("visibilitychange", () => {
  if (document.hidden) return;
  if (socket) send({ do: "alive" });
  else connect();
});
addEventListener("pageshow", (event) => { if (event.persisted && !socket) connect(); });

stopButton.disabled = false;
sayStop("", "plain");
connect();
