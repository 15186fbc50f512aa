"use strict";
// Sorts a table by the column whose heading is pressed, and shows the suites and kinds that are asked for.

for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => sort(table, heads, column)));
  heads[0].setAttribute("aria-sort", "ascending");
}

function sort(table, heads, column) {
  const head = heads[column], was = head.getAttribute("aria-sort");
  const order = was === "ascending" ? "descending" : was === "descending" ? "ascending" : head.dataset.first;
  for (const other of heads) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", order);
  const rows = [...table.tBodies[0].rows];
  rows.sort((a, b) => compare(a.cells[column].dataset.value, b.cells[column].dataset.value, order));
  table.tBodies[0].append(...rows);
}

function compare(a, b, order) {
  if (a === "" || b === "") return (a === "") - (b === "");
  const numbers = !isNaN(a) && !isNaN(b);
  const sign = numbers ? a - b : a.localeCompare(b, "en");
  return order === "ascending" ? sign : -sign;
}

const filters = document.querySelector("#filters");

function filter() {
  const suite = filters.elements.suite.value, kind = filters.elements.kind.value;
  let left = 0;
  for (const section of document.querySelectorAll(".suite")) {
    section.hidden = suite !== "" && section.dataset.suite !== suite;
    for (const row of section.querySelectorAll("tr[data-kind]")) {
      row.hidden = kind !== "" && row.dataset.kind !== kind;
      left += !section.hidden && !row.hidden;
    }
  }
  filters.querySelector("output").value = left === 1 ? "1 entry" : left + " entries";
}

filters.addEventListener("input", filter);
filters.addEventListener("submit", (event) => event.preventDefault());
filter();
