// A table of many rows: sorted by any column, and only the rows in sight are in the document, so that ten thousand stay smooth.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { fixed } from "../format.js";

const ROW_PX = 26;
const SPARE_ROWS = 8; // above and below those in sight

function compare(a, b) {
  if (a === b) return 0;
  if (a === null || a === undefined) return 1; // what has no value comes last
  if (b === null || b === undefined) return -1;
  return a < b ? -1 : 1;
}

// A column of numbers. value: of a row; digits: behind the point
export const numberColumn = (key, head, value, digits) => ({
  key,
  head,
  value,
  isNumber: true,
  text: (row) => fixed(value(row), digits),
});

// The rows in the order of a column; equal ones keep theirs. order: {key, down}
export function sortRows(rows, columns, order) {
  const column = columns.find(({ key }) => key === order.key);
  if (!column) return rows;
  const sorted = [...rows].sort((a, b) => compare(column.value(a), column.value(b)));
  if (!order.down) return sorted;
  const without = sorted.findIndex((row) => column.value(row) === null || column.value(row) === undefined);
  const end = without < 0 ? sorted.length : without;
  return [...sorted.slice(0, end).reverse(), ...sorted.slice(end)];
}

function HeadCell({ column, order, onOrder }) {
  const isSorted = order.key === column.key;
  const direction = order.down ? "descending" : "ascending";
  return (
    <th scope="col" class={column.isNumber ? "number" : ""} aria-sort={isSorted ? direction : "none"}>
      <button
        type="button"
        class="quiet"
        onClick={() => onOrder({ key: column.key, down: isSorted ? !order.down : false })}
      >
        {column.head}
        <span aria-hidden="true">{isSorted ? (order.down ? " ↓" : " ↑") : ""}</span>
      </button>
    </th>
  );
}

// A row that stands for `count` others out of sight.
function Filler({ count, columns }) {
  const cell = useRef(null);
  useEffect(() => {
    cell.current.style.height = `${count * ROW_PX}px`;
  });
  return (
    <tr class="filler" aria-hidden="true" hidden={count === 0}>
      <td ref={cell} colSpan={columns} />
    </tr>
  );
}

// columns: [{key, head, value(row), text(row), isNumber}]; rowKey(row); marked(row): is drawn highlighted.
export function LongTable({ caption, columns, rows, rowKey, marked, first, height = 380 }) {
  const [order, setOrder] = useState(first || { key: null, down: false });
  const [top, setTop] = useState(0);
  const sorted = useMemo(() => sortRows(rows, columns, order), [rows, columns, order]);
  const inSight = Math.ceil(height / ROW_PX);
  const from = Math.max(0, Math.min(Math.floor(top / ROW_PX) - SPARE_ROWS, sorted.length - inSight));
  const to = Math.min(sorted.length, from + inSight + 2 * SPARE_ROWS);
  const area = useRef(null);
  useEffect(() => {
    area.current.style.maxHeight = `${height}px`;
  }, [height]);
  return (
    <div
      class="scroll long"
      ref={area}
      onScroll={(event) => setTop(event.target.scrollTop)}
      tabIndex={0}
      role="region"
      aria-label={caption}
    >
      <table aria-rowcount={sorted.length + 1}>
        <caption class="unseen">{caption}</caption>
        <thead>
          <tr aria-rowindex={1}>
            {columns.map((column) => (
              <HeadCell key={column.key} column={column} order={order} onOrder={setOrder} />
            ))}
          </tr>
        </thead>
        <tbody>
          <Filler count={from} columns={columns.length} />
          {sorted.slice(from, to).map((row, i) => (
            <tr key={rowKey(row)} aria-rowindex={from + i + 2} class={marked?.(row) ? "selected" : ""}>
              {columns.map((column) => (
                <td key={column.key} class={column.isNumber ? "number" : ""}>
                  {column.text(row)}
                </td>
              ))}
            </tr>
          ))}
          <Filler count={sorted.length - to} columns={columns.length} />
        </tbody>
      </table>
    </div>
  );
}
