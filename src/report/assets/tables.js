// SPDX-License-Identifier: Apache-2.0
// Tables: ten rows at first and the rest on demand, sorted by a click on a heading, filtered by what
// they contain; a table wider than its place becomes a list of rows, so that nothing is cut.
"use strict";
const sarblockTables = (function () {
  const kShown = 10;

  // The number that a cell begins with; not a number where there is none.
  const numberOf = (text) => Number.parseFloat(text.replace(/[\u202f\u2009]/g, "").replace(/^\u2212/, "-"));

  class Table {
    constructor(box) {
      this.box = box;
      this.table = box.querySelector("table");
      this.body = this.table.tBodies[0];
      this.rows = [...this.body.rows];
      this.all = false;
      this.words = "";
      const titles = [...this.table.querySelectorAll("th")];
      this.rows.forEach((row) => [...row.cells].forEach((cell, i) => {
        if (titles[i]) cell.dataset.label = titles[i].textContent;
      }));
      if (this.table.classList.contains("plain")) return;
      if (this.rows.length > 3) titles.forEach((title, i) => this.makeSortable(title, i, titles));
      if (this.rows.length > kShown) this.addBar();
      this.show();
    }
    makeSortable(title, column, titles) {
      title.tabIndex = 0;
      title.classList.add("sortable");
      title.title = "sort";
      const sort = () => {
        const down = title.getAttribute("aria-sort") === "ascending";
        titles.forEach((other) => other.removeAttribute("aria-sort"));
        title.setAttribute("aria-sort", down ? "descending" : "ascending");
        const text = (row) => row.cells[column].textContent;
        const numeric = title.classList.contains("n");
        const sign = down ? -1 : 1;
        this.rows.sort((a, b) => {
          if (!numeric) return sign * text(a).localeCompare(text(b), "en", {numeric: true});
          const x = numberOf(text(a)), y = numberOf(text(b));
          if (Number.isNaN(x) || Number.isNaN(y)) return Number.isNaN(x) - Number.isNaN(y);
          return sign * (x - y);
        });
        this.body.append(...this.rows);
        this.show();
      };
      title.addEventListener("click", sort);
      title.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        sort();
      });
    }
    addBar() {
      const bar = document.createElement("div");
      bar.className = "rows";
      this.button = document.createElement("button");
      this.button.type = "button";
      this.button.addEventListener("click", () => {
        this.all = !this.all;
        this.show();
        fit();
      });
      const filter = document.createElement("input");
      filter.type = "search";
      filter.placeholder = "filter";
      filter.setAttribute("aria-label", "filter the rows");
      filter.addEventListener("input", () => {
        this.words = filter.value.toLowerCase();
        this.show();
      });
      this.count = document.createElement("span");
      bar.append(this.count, this.button, filter);
      this.box.after(bar);
    }
    // Returns how many rows pass the filter.
    show() {
      let found = 0, shown = 0;
      this.rows.forEach((row) => {
        const fits = this.words === "" || row.textContent.toLowerCase().includes(this.words);
        if (fits) ++found;
        row.hidden = !fits || (!this.all && found > kShown);
        if (!row.hidden) ++shown;
      });
      if (!this.button) return found;
      this.count.textContent = `${shown} of ${found} rows`;
      this.button.hidden = found <= kShown;
      this.button.textContent = this.all ? "show ten" : "show all";
      return found;
    }
    // Sets the table as rows of a list where it is wider than its place; true where even that is cut.
    fit() {
      this.box.classList.remove("stack");
      if (this.box.clientWidth === 0) return false;  // folded
      if (this.box.scrollWidth > this.box.clientWidth + 1) this.box.classList.add("stack");
      return this.box.scrollWidth > this.box.clientWidth + 1;
    }
  }

  let tables = [];
  function fit() {
    return tables.filter((table) => table.fit()).length;
  }

  function begin() {
    tables = [...document.querySelectorAll(".scroll")].map((box) => new Table(box));
    let width = window.innerWidth;
    window.addEventListener("resize", () => {
      if (window.innerWidth !== width) fit();
      width = window.innerWidth;
    });
    document.querySelectorAll("details").forEach((d) => d.addEventListener("toggle", fit));
    // What is folded is looked at too.
    const folded = [...document.querySelectorAll("details:not([open])")];
    folded.forEach((d) => { d.open = true; });
    const cut = fit();
    const told = {
      tables: tables.length, cut: cut, stacked: document.querySelectorAll(".stack").length,
      shown: Math.max(0, ...tables.map((t) => (t.button ? t.rows.filter((row) => !row.hidden).length : 0))),
      most: Math.max(0, ...tables.map((t) => t.rows.length)), sorted: trySorting(),
      beyond: document.documentElement.scrollWidth - document.documentElement.clientWidth};
    folded.forEach((d) => { d.open = false; });
    return told;
  }

  // Sorts and filters the longest table and puts it back; what came first, and what was left.
  function trySorting() {
    const table = tables.filter((t) => t.button).sort((a, b) => b.rows.length - a.rows.length)[0];
    if (!table) return null;
    const before = [...table.rows];
    const title = [...table.table.querySelectorAll("th.n")].pop();
    if (!title) return null;
    const column = title.cellIndex;
    const ends = () => [table.rows[0], table.rows[table.rows.length - 1]].map((row) => row.cells[column].textContent);
    title.click();
    const up = ends();
    title.click();
    const down = ends();
    title.removeAttribute("aria-sort");
    table.rows = before;
    table.body.append(...before);
    table.words = before[0].textContent.toLowerCase();
    const left = table.show();
    table.words = "";
    table.show();
    return {up: up, down: down, left: left, of: before.length};
  }

  return {begin: begin, fit: fit};
})();
