// SPDX-License-Identifier: Apache-2.0
// Draws the charts that the page's data block describes, sets the tables, and writes into #selfcheck
// what was drawn and which errors occurred.
"use strict";
(function () {
  const check = {charts: [], errors: []};
  const note = () => {
    document.getElementById("selfcheck").textContent = JSON.stringify(check);
  };
  window.addEventListener("error", (event) => {
    check.errors.push(String(event.message));
    note();
  });

  try {
    check.tables = sarblockTables.begin();
  } catch (error) {
    check.errors.push(`tables: ${error.message}`);
  }
  JSON.parse(document.getElementById("data").textContent).charts.forEach((spec) => {
    try {
      const canvas = document.getElementById(spec.id);
      const drawn = spec.type === "map" ? sarblockMap.draw(canvas, spec) : sarblock.drawXy(canvas, spec);
      check.charts.push({id: spec.id, type: spec.type, ...drawn});
    } catch (error) {
      check.errors.push(`${spec.id}: ${error.message}`);
    }
  });
  note();

  // On paper: everything open, the charts drawn anew and the tables set at the width of the sheet.
  const folded = [];
  const resize = () => {
    Object.values(Chart.instances).forEach((chart) => chart.resize());
    sarblockTables.fit();
  };
  window.addEventListener("beforeprint", () => {
    document.querySelectorAll("main details:not([open])").forEach((d) => {
      d.open = true;
      folded.push(d);
    });
    document.documentElement.classList.add("paper");
    resize();
  });
  window.addEventListener("afterprint", () => {
    folded.splice(0).forEach((d) => { d.open = false; });
    document.documentElement.classList.remove("paper");
    resize();
  });
})();
