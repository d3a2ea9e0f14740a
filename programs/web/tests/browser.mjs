// The page in a real browser: what no test of the server sees. `node browser.mjs ADDRESS FOLDER` needs the packages
// playwright-core and axe-core below the working folder, and Chromium; it writes pictures into the folder.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { strict as assert } from "node:assert";

const [address, folder] = process.argv.slice(2);
const require = createRequire(`${process.cwd()}/`);
const { chromium } = require("playwright-core");
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
const SIZES = [[390, 844], [844, 390], [1280, 800]];

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM || "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"],
});

async function open(options, where = address) {
  const context = await browser.newContext({ hasTouch: true, ...options });
  const page = await context.newPage();
  const faults = [];
  const elsewhere = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("console", (message) => { if (message.type() === "error") faults.push(message.text()); });
  page.on("request", (request) => { if (new URL(request.url()).origin !== new URL(address).origin) elsewhere.push(request.url()); });
  await page.goto(where);
  await page.waitForFunction(() => document.body.dataset.connection === "open" && document.querySelectorAll(".row").length > 3);
  return { context, page, faults, elsewhere };
}

/** Whether the middle of the button is the button: nothing is above it, and it is on the screen. */
const isReachable = (page) => page.evaluate(() => {
  const area = document.getElementById("stop").getBoundingClientRect();
  const top = document.elementFromPoint(area.left + area.width / 2, area.top + area.height / 2);
  return area.height >= 44 && area.bottom <= innerHeight && area.right <= innerWidth && top?.closest("#stop") !== null;
});
const state = (page, schema) => page.evaluate((schema) => {
  const rows = [...document.querySelectorAll(".row")].filter((row) => row.querySelector(".name")?.textContent === schema);
  return rows[0]?.querySelector(".state").textContent;
}, schema);
const until = (page, schema, wanted) => page.waitForFunction(([schema, wanted]) => {
  const rows = [...document.querySelectorAll(".row")].filter((row) => row.querySelector(".name")?.textContent === schema);
  return (rows[0]?.querySelector(".state").textContent === "WINNER") === wanted;
}, [schema, wanted]);

/** Whether a canvas has something on it. */
const isDrawn = (place) => {
  const canvas = document.querySelector(place);
  return canvas?.width > 0 && canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some((part) => part > 0);
};
const openRow = (page, schema) => page.locator(".row > button", { has: page.locator(".name", { hasText: schema }) }).first().click();

for (const colorScheme of ["light", "dark"]) {
  for (const [width, height] of SIZES) {
    const { context, page, faults, elsewhere } = await open({ viewport: { width, height }, colorScheme });
    assert(!page.url().includes("#"), "the token stays in the address");
    await page.click("#drive-on");
    await openRow(page, "example");
    await page.waitForSelector(".details .panel canvas");
    await page.locator(".details .curve").first().click();
    await page.waitForSelector(".details figure canvas.plot");
    await page.locator("#floor").scrollIntoViewIfNeeded();
    await page.waitForFunction(() => document.getElementById("floor-text").textContent.includes("heading"));
    await page.waitForFunction(isDrawn, "#floor canvas");
    assert(await isReachable(page), `the stop is not reachable at ${width}x${height}`);
    const isWide = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth || document.querySelector("main").scrollWidth > document.querySelector("main").clientWidth);
    assert(!isWide, `the page is wider than ${width}`);
    await page.screenshot({ path: `${folder}/${colorScheme}-${width}x${height}.png` });
    for (const place of ["#floor", ".details .panel", ".details figure"]) {
      await page.locator(place).last().scrollIntoViewIfNeeded();
      await page.waitForFunction(isDrawn, `${place} canvas`);
      await page.screenshot({ path: `${folder}/${colorScheme}-${width}x${height}-${place.replace(/\W+/g, "")}.png` });
    }
    await page.evaluate(() => { const main = document.querySelector("main"); main.scrollTop = main.scrollHeight; });
    assert(await isReachable(page), "the stop scrolls away");
    await page.screenshot({ path: `${folder}/${colorScheme}-${width}x${height}-end.png` });
    // The page admits no script but its own, so axe runs outside of its policy.
    const session = await context.newCDPSession(page);
    await session.send("Page.setBypassCSP", { enabled: true });
    await session.send("Runtime.evaluate", { expression: axe });
    const found = await session.send("Runtime.evaluate", {
      expression: "axe.run({ resultTypes: ['violations'] }).then((all) => JSON.stringify(all.violations.map((one) => [one.id, one.nodes.map((node) => node.html.slice(0, 120))])))",
      awaitPromise: true, returnByValue: true,
    });
    assert.equal(found.result.value, "[]", `axe at ${width}x${height} ${colorScheme}`);
    assert.deepEqual([faults, elsewhere], [[], []]);
    await context.close();
  }
}

// The pad: held by a mouse, it drives; whatever takes the person away lets go.
{
  const { context, page, faults } = await open({ viewport: { width: 390, height: 844 } });
  await page.click("#drive-on");
  const press = async () => {
    // The picture above it may have grown.
    await page.locator("#pad").evaluate((pad) => pad.scrollIntoView({ block: "center" }));
    const pad = await page.locator("#pad").boundingBox();
    await page.mouse.move(pad.x + pad.width / 2, pad.y + pad.height / 2);
    await page.mouse.down();
    await page.mouse.move(pad.x + pad.width / 2, pad.y + 30);
    await until(page, "teleop", true);
  };
  const lets = {
    "a finger that leaves": () => page.mouse.up(),
    "a lost pointer": () => page.evaluate(() => { const pad = document.getElementById("pad"); for (let id = 0; id < 20; id++) if (pad.hasPointerCapture(id)) pad.releasePointerCapture(id); }),
    "a turned phone": () => page.setViewportSize({ width: 844, height: 390 }).then(() => page.setViewportSize({ width: 390, height: 844 })),
    "an element that is gone": () => page.evaluate(() => { document.getElementById("drive-pad").hidden = true; }),
    "another window": () => page.evaluate(() => dispatchEvent(new Event("blur"))),
    "a page that stands still": () => page.evaluate(() => { const end = performance.now() + 1500; while (performance.now() < end); }),
    "a message of the browser": async () => {
      page.once("dialog", (dialog) => until(other.page, "teleop", false).then(() => dialog.accept()));
      await page.evaluate(() => window["al" + "ert"]("wait"));
    },
  };
  const other = await open({ viewport: { width: 390, height: 844 } });
  for (const [what, let_go] of Object.entries(lets)) {
    await press();
    await let_go();
    await until(other.page, "teleop", false).catch((error) => { throw new Error(`${what}: ${error}`); });
    await page.mouse.up();
    await page.evaluate(() => { document.getElementById("drive-pad").hidden = false; });
    await until(page, "teleop", false);
  }
  await page.focus("#pad");
  await page.keyboard.down("ArrowUp");
  await until(page, "teleop", true);
  await page.keyboard.up("ArrowUp");
  await until(page, "teleop", false);
  // With a modifier, some systems say no longer that a key is let go.
  await page.keyboard.down("ArrowUp");
  await until(page, "teleop", true);
  await page.keyboard.down("Meta");
  await until(other.page, "teleop", false);
  await page.keyboard.up("Meta");
  await page.keyboard.up("ArrowUp");
  // A page that vanishes.
  await press();
  await context.close();
  await until(other.page, "teleop", false);
  // The stop works at the touch, and shows who did it.
  const area = await other.page.locator("#stop").boundingBox();
  const begin = performance.now();
  await other.page.touchscreen.tap(area.x + area.width / 2, area.y + area.height / 2);
  await other.page.waitForFunction(() => document.getElementById("stop-text").textContent.startsWith("Stopped at"));
  console.log(`the stop was acknowledged after ${(performance.now() - begin).toFixed(0)} ms`);
  await other.page.waitForSelector("#stopped:not([hidden])");
  await other.page.screenshot({ path: `${folder}/stopped.png` });
  assert(await isReachable(other.page));
  assert.equal(await state(other.page, "goon"), "SLEPT");
  await other.page.click("#go-on");
  await other.page.click("#go-on-yes");
  await other.page.waitForSelector("#stopped", { state: "hidden" });
  // A touch on a panel is an operator's, and whoever only looks has none.
  await openRow(other.page, "example");
  const target = other.page.locator(".panel .plane canvas").first();
  await target.scrollIntoViewIfNeeded();
  await other.page.waitForFunction(isDrawn, ".panel .plane canvas");
  await target.tap();
  await other.page.waitForFunction(() => [...document.querySelectorAll("#lines li")].some((line) => line.textContent.includes("clicked")));
  // A page that looks.
  const share = await other.page.inputValue("#share-address");
  const looking = await open({ viewport: { width: 390, height: 844 } }, share);
  assert(!(await looking.page.isVisible("#stop")) && !(await looking.page.isVisible("#drive")));
  await looking.page.screenshot({ path: `${folder}/looks.png` });
  assert.deepEqual([faults, other.faults, looking.faults], [[], [], []]);
}
await browser.close();
console.log("the page works in Chromium");
