// The page's SVG drawings as pictures that leave it. On the screen their looks come from the style sheets; a file has none. So a
// copy of a drawing stands for a moment, unseen and in light colours, where the drawing stands, its computed styles are written
// into attributes that every program reads, and the copies are set on a light ground with title, captions and legend.
// No `vector-effect`, `color-mix` or class is left: not every program knows them.
import { svgElement, svgPainter } from "../plots/painters.js";
import { palette } from "../plots/palette.js";

const MARGIN = 14;
const LINE = 18; // px from one line of text to the next
const SWATCH = 22;
const LETTER = 6.2; // px, about the width of one at 11 px

// What is written into attributes, with the values that need not be.
const INITIAL = {
  "fill-rule": "nonzero",
  "stroke-linejoin": "miter",
  "paint-order": "normal",
  "font-weight": "400",
  "text-anchor": "start",
  opacity: "1",
};

// A computed colour as "#rrggbb" and its opacity; null when there is none.
export function plainColour(computed) {
  if (computed === "none") return null;
  const [red, green, blue, opacity = 1] = computed.match(/[\d.]+(?:e-?\d+)?/g).map(Number);
  const unit = computed.startsWith("color(") ? 255 : 1;
  const hex = [red, green, blue].map((one) => Math.round(one * unit).toString(16).padStart(2, "0"));
  return { colour: `#${hex.join("")}`, opacity };
}

const scaled = (lengths, factor) =>
  lengths
    .split(/[\s,]+/)
    .map((one) => Number((parseFloat(one) * factor).toPrecision(4)))
    .join(" ");

// The attributes that give an element its looks; `factor` makes lengths of strokes out of what the style sheet says.
function looks(element, factor) {
  const style = getComputedStyle(element);
  const found = {};
  for (const [name, initial] of Object.entries(INITIAL)) {
    const value = style.getPropertyValue(name);
    if (value !== initial) found[name] = value;
  }
  const [fill, stroke] = [plainColour(style.fill), plainColour(style.stroke)];
  found.fill = fill ? fill.colour : "none";
  if (fill && fill.opacity !== 1) found["fill-opacity"] = fill.opacity;
  if (element.localName === "text") found["font-size"] = scaled(style.fontSize, 1);
  if (!stroke) return found;
  found.stroke = stroke.colour;
  if (stroke.opacity !== 1) found["stroke-opacity"] = stroke.opacity;
  found["stroke-width"] = scaled(style.strokeWidth, factor);
  if (style.strokeDasharray !== "none") found["stroke-dasharray"] = scaled(style.strokeDasharray, factor);
  return found;
}

// A group with what an SVG element of the page shows, in that element's units, and the looks of the first element that each
// selector finds. scale: pixels of the picture per unit; strokes that do not scale on the screen do not scale here.
function plainCopy(svg, { scale, selectors }) {
  const copy = svg.cloneNode(true);
  Object.assign(copy.style, { colorScheme: "light", position: "absolute", visibility: "hidden" });
  copy.querySelectorAll(".cursor").forEach((one) => one.remove());
  svg.parentNode.append(copy);
  const shapes = [...copy.querySelectorAll("path, line, circle, text")].map((shape) => {
    const isFixed = getComputedStyle(shape).vectorEffect === "non-scaling-stroke";
    return [shape, looks(shape, isFixed ? 1 / scale : 1)];
  });
  const samples = selectors.map((selector) => looks(copy.querySelector(selector), 1));
  copy.remove();
  for (const [shape, attributes] of shapes)
    for (const [name, value] of Object.entries(attributes)) shape.setAttribute(name, value);
  copy.querySelectorAll("*").forEach((one) => ["class", "data-pair"].forEach((name) => one.removeAttribute(name)));
  const group = svgElement("g", {});
  group.append(...copy.childNodes);
  return { group, samples };
}

// The legend's lines from y on; answers where the next line would stand, and paints only when asked to.
function legend(picture, { keys, samples, width, y, isPainted }) {
  let x = MARGIN;
  keys.forEach(({ name, isArea }, i) => {
    const length = SWATCH + 26 + name.length * LETTER;
    if (x > MARGIN && x + length > width) [x, y] = [MARGIN, y + LINE];
    if (isPainted) {
      const d = isArea ? `M${x},${y - 9}h${SWATCH}v10h${-SWATCH}Z` : `M${x},${y - 4}h${SWATCH}`;
      picture.graft(svgElement("path", { ...samples[i], d }));
      picture.painter.text(x + SWATCH + 6, y, name, { fill: palette("light").ink });
    }
    x += length;
  });
  return keys.length ? y + LINE : y;
}

// One picture of drawings side by side, as an SVG element.
//   title, note     lines above; note may be empty
//   parts           [{svg, caption}]: elements of the page, each with a viewBox; caption may be left out
//   partWidth       px that each gets
//   keys            the legend: [{name, selector, isArea}], the looks being those of what the selector finds in the first part
export function drawingSvg({ title, note, parts, partWidth, keys }) {
  const { ink, faint, ground } = palette("light");
  const boxes = parts.map(({ svg }) => svg.viewBox.baseVal);
  const hasCaptions = parts.some(({ caption }) => caption);
  const width = MARGIN + parts.length * (partWidth + MARGIN);
  const belowNote = 22 + (note ? LINE : 0) + LINE;
  const top = legend(null, { keys, width, y: belowNote, isPainted: false }) - 8 + (hasCaptions ? LINE : 0);
  const height = top + MARGIN + Math.max(...boxes.map((box) => (partWidth * box.height) / box.width));
  const picture = svgPainter(width, Math.ceil(height));
  const { painter } = picture;
  painter.title(title);
  painter.path((p) => p.rect(0, 0, width, Math.ceil(height)), { fill: ground });
  painter.text(MARGIN, 22, title, { fill: ink, size: 13, weight: 600 });
  if (note) painter.text(MARGIN, 22 + LINE, note, { fill: faint });
  parts.forEach(({ svg, caption }, i) => {
    const box = boxes[i];
    const scale = partWidth / box.width;
    const x = MARGIN + i * (partWidth + MARGIN);
    const { group, samples } = plainCopy(svg, { scale, selectors: i === 0 ? keys.map(({ selector }) => selector) : [] });
    group.setAttribute("transform", `translate(${x} ${top}) scale(${scale}) translate(${-box.x} ${-box.y})`);
    painter.clip(x, top, partWidth, scale * box.height, () => picture.graft(group));
    if (caption) painter.text(x, top - 6, caption, { fill: ink, weight: 600 });
    if (i === 0) legend(picture, { keys, samples, width, y: belowNote, isPainted: true });
  });
  return picture.svg;
}
