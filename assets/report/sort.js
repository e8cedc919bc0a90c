// Columns of a table sort by a click or a key on their heading. Without this script the table is in the paper's order.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  const order = [...body.rows];
  table.querySelectorAll("thead th").forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => {
      const was = heading.getAttribute("aria-sort");
      const now = was === null ? "ascending" : was === "ascending" ? "descending" : null;
      for (const other of table.querySelectorAll("thead th")) other.removeAttribute("aria-sort");
      const rows = [...order];
      if (now !== null) {
        heading.setAttribute("aria-sort", now);
        const key = (row) => row.cells[column].dataset.key ?? row.cells[column].textContent.trim();
        rows.sort((a, b) => key(a).localeCompare(key(b), "en", { numeric: true }));
        if (now === "descending") rows.reverse();
      }
      body.append(...rows);
    });
  });
}
