// A click on a column's head sorts the rows by it, a second click the other way round.
for (const button of document.querySelectorAll("th button")) {
  button.addEventListener("click", () => {
    const head = button.closest("th");
    const body = head.closest("table").tBodies[0];
    const falling = head.ariaSort === "ascending" || (!head.ariaSort && "falling" in button.dataset);
    const key = (row) => row.cells[head.cellIndex].dataset.key ?? row.cells[head.cellIndex].textContent;
    const rows = [...body.rows].map((row) => [key(row), row]);
    rows.sort(([a], [b]) => (falling ? -1 : 1) * a.localeCompare(b, undefined, { numeric: true }));
    for (const other of head.parentElement.cells) other.ariaSort = null;
    head.ariaSort = falling ? "descending" : "ascending";
    body.append(...rows.map(([, row]) => row));
  });
}
