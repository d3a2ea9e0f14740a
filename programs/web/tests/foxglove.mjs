// Foxglove's own client of its protocol against a running application. `node foxglove.mjs ADDRESS` needs the packages
// @foxglove/ws-protocol and ws below the working folder, and an application that publishes two thousand values a second.
import { createRequire } from "node:module";
import { strict as assert } from "node:assert";

const [address] = process.argv.slice(2);
const require = createRequire(`${process.cwd()}/`);
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { WebSocket } = require("ws");
// Whatever does not come at all ends the test.
const watchdog = setTimeout(() => { console.error("nothing more arrives"); process.exit(1); }, 300_000);

const once = (client, event, fits = () => true) => new Promise((done) => {
  const listen = (value) => { if (fits(value)) { client.off(event, listen); done(value); } };
  client.on(event, listen);
});

async function open(protocol) {
  const socket = new WebSocket(address, [protocol]);
  const client = new FoxgloveClient({ ws: socket });
  const faults = [];
  client.on("error", (error) => faults.push(String(error)));
  const first = await Promise.all([once(client, "serverInfo"), once(client, "advertise"), once(client, "advertiseServices")]);
  return { client, socket, faults, info: first[0], channels: first[1], services: first[2] };
}

const call = async ({ client, services }, name, request) => {
  const service = services.find((one) => one.name === name);
  const data = new TextEncoder().encode(JSON.stringify(request));
  const answer = Promise.race([once(client, "serviceCallResponse"), once(client, "serviceCallFailure")]);
  client.sendServiceCallRequest({ serviceId: service.id, callId: 1, encoding: "json", data });
  const got = await answer;
  return got.message ?? JSON.parse(new TextDecoder().decode(got.data)).success;
};

for (const protocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) {
  const { client, socket, info, faults } = await open(protocol);
  assert.equal(socket.protocol, protocol);
  assert.deepEqual(info.capabilities, ["time", "parameters", "parametersSubscribe", "services"]);
  assert.deepEqual(faults, []);
  client.close();
}

// One reads nothing, and the other one everything.
const unread = await open("foxglove.sdk.v1");
unread.subscriptions = new Map(unread.channels.map((channel) => [channel.topic, unread.client.subscribe(channel.id)]));
unread.socket.pause();
// It sends, so it is not taken for gone.
const alive = setInterval(() => unread.socket.ping(), 1000);
const reader = await open("foxglove.websocket.v1");
const topics = new Map(reader.channels.map((channel) => [reader.client.subscribe(channel.id), channel.topic]));
const counts = new Map();
let total = 0;
let newest = 0n;
reader.client.on("time", ({ timestamp }) => { assert(timestamp >= newest, "the time goes back"); newest = timestamp; });
await once(reader.client, "message", ({ subscriptionId }) => {
  const topic = topics.get(subscriptionId);
  counts.set(topic, (counts.get(topic) ?? 0) + 1);
  total += 1;
  return total >= 5000 && (counts.get("/camera/image") ?? 0) >= 100;
});
for (const topic of ["/jde/decisions", "/jde/states", "/jde/log", "/a/count", "/d/count", "/pioneer/robot"]) {
  assert(counts.has(topic), `nothing of ${topic}`);
}

// Then it reads: the newest, and what it missed.
const wanted = newest;
const first = unread.subscriptions.get("/a/count");
let stale = 0;
unread.client.on("message", ({ subscriptionId, timestamp }) => { if (subscriptionId === first && timestamp < wanted) stale += 1; });
const missed = once(unread.client, "status", ({ id }) => id === "left-out");
const caught = once(unread.client, "message", ({ subscriptionId, timestamp }) => subscriptionId === first && timestamp >= wanted);
unread.socket.resume();
console.log((await missed).message);
await caught;
console.log(`${total} messages were read, ${counts.get("/a/count")} of /a/count; the other client got ${stale} old ones of it`);
assert(stale * 2 < counts.get("/a/count"));

// Parameters, services and nonsense.
const set = once(reader.client, "parameterValues", ({ id }) => id === "set");
reader.client.setParameters([{ name: "listener.period", value: 0.05 }], "set");
assert.deepEqual((await set).parameters, [{ name: "listener.period", value: 0.05, type: "float64" }]);
const refused = once(reader.client, "status", ({ level }) => level === 2);
reader.client.setParameters([{ name: "listener.period", value: -1 }], "refused");
assert.match((await refused).message, /listener\.period/);
for (const broken of ["null", "[]", "{}", new Uint8Array(0), new Uint8Array([2, 1]), new Uint8Array([99])]) {
  const status = once(reader.client, "status", ({ level }) => level === 2);
  reader.socket.send(broken);
  await status;
}
assert.equal(await call(reader, "/jde/stop_all", {}), true);
assert.equal(await call(reader, "/jde/release_all", {}), true);
assert.match(await call(reader, "/jde/stop", { schema: "nobody" }), /nobody/);
assert.deepEqual([reader.faults, unread.faults], [[], []]);
clearTimeout(watchdog);
clearInterval(alive);
reader.client.close();
unread.client.close();
console.log("Foxglove's client and the robot understand each other");
