"use strict";
// The page is complete without this script. The script adds a search in the table of switches, and the
// selection of a time span in the bands.
(() => {
  const rows = [...document.querySelectorAll("#switches tbody tr")];
  const tools = document.querySelector("#switches .tools");
  const figure = document.querySelector("#bands");
  if (!tools) return;
  tools.hidden = false;
  const searchBox = tools.querySelector("input");
  const output = tools.querySelector("output");
  const reset = tools.querySelector("button");
  const texts = rows.map((row) => row.textContent.toLowerCase());
  let span = null;
  const filter = () => {
    const words = searchBox.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    rows.forEach((row, number) => {
      const time = Number(row.dataset.s);
      const matches = words.every((word) => texts[number].includes(word)) && (!span || (time >= span[0] && time <= span[1]));
      row.hidden = !matches;
      shown += matches;
    });
    const narrowed = words.length > 0 || span !== null;
    const fold = document.querySelector("#switches details");
    if (fold && narrowed) fold.open = true;
    reset.hidden = !narrowed;
    output.textContent = narrowed
      ? `${shown} of ${rows.length}` + (span ? `, from ${span[0].toFixed(2)} s to ${span[1].toFixed(2)} s` : "")
      : "";
  };
  searchBox.addEventListener("input", filter);
  const addElement = (name) => {
    const element = document.createElement(name === "output" ? "output" : "div");
    if (name !== "output") element.className = name;
    element.hidden = true;
    figure.append(element);
    return element;
  };
  const marks = figure && { span: addElement("span"), at: addElement("at"), time: addElement("output") };
  reset.addEventListener("click", () => {
    span = null;
    searchBox.value = "";
    if (marks) marks.span.hidden = true;
    filter();
  });
  if (!marks) return;
  const { from, to, left, right } = Object.fromEntries(Object.entries(figure.dataset).map(([key, value]) => [key, Number(value)]));
  const share = (time) => left + ((time - from) / (to - from)) * (right - left);
  const time = (event) => {
    const edge = figure.getBoundingClientRect();
    const place = ((event.clientX - edge.left) / edge.width - left) / (right - left);
    return from + Math.min(1, Math.max(0, place)) * (to - from);
  };
  const percent = (number) => `${(number * 100).toFixed(3)}%`;
  let dragStart = null;
  figure.addEventListener("pointerdown", (event) => {
    dragStart = time(event);
    figure.setPointerCapture(event.pointerId);
  });
  figure.addEventListener("pointermove", (event) => {
    const now = time(event);
    marks.at.hidden = marks.time.hidden = false;
    marks.at.style.left = marks.time.style.left = percent(share(now));
    marks.time.textContent = `${now.toFixed(2)} s`;
    if (dragStart === null) return;
    span = [Math.min(dragStart, now), Math.max(dragStart, now)];
    marks.span.hidden = false;
    marks.span.style.left = percent(share(span[0]));
    marks.span.style.width = percent(share(span[1]) - share(span[0]));
    filter();
  });
  const end = () => {
    if (span && span[1] - span[0] < (to - from) / 500) {
      span = null;
      marks.span.hidden = true;
      filter();
    }
    dragStart = null;
  };
  figure.addEventListener("pointerup", end);
  figure.addEventListener("pointercancel", end);
  figure.addEventListener("pointerleave", () => {
    marks.at.hidden = marks.time.hidden = true;
  });
})();
