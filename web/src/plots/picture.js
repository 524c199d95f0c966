// A figure as a picture that leaves the page: SVG and PNG with title, legend, axes and units, on a light ground.
import { canvasPainter, svgPainter } from "./painters.js";
import { draw, drawHead, layout } from "./draw.js";
import { palette } from "./palette.js";

const SIZE = { width: 800, height: 460 };
const PNG_SCALE = 2;

function paint(painter, figure, size, options) {
  const colours = palette("light");
  const head = drawHead(painter, figure, size.width, colours, { ...options, measureOnly: true });
  const frame = layout(figure, size, { ...options, head });
  draw(painter, figure, frame, colours, options);
  drawHead(painter, figure, size.width, colours, options);
}

// The figure as an SVG element. options: {hidden, zoom, size}
export function figureSvg(figure, { size = SIZE, ...options } = {}) {
  const { painter, svg } = svgPainter(size.width, size.height);
  paint(painter, figure, size, options);
  return svg;
}

export function figureSvgText(figure, options) {
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(figureSvg(figure, options))}\n`;
}

// The figure as a PNG Blob of twice the size.
export function figurePng(figure, { size = SIZE, ...options } = {}) {
  const canvas = document.createElement("canvas");
  canvas.width = PNG_SCALE * size.width;
  canvas.height = PNG_SCALE * size.height;
  const context = canvas.getContext("2d");
  context.scale(PNG_SCALE, PNG_SCALE);
  paint(canvasPainter(context), figure, size, options);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

// Hands a file to the browser's downloads.
export function download(name, content, type) {
  const blob = content instanceof Blob ? content : new Blob([content], { type });
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

// A name for a file from what people wrote: letters, digits and hyphens.
export function fileName(...parts) {
  return parts
    .join("-")
    .normalize("NFKD")
    .replaceAll(/[^A-Za-z0-9]+/g, "-")
    .replaceAll(/^-+|-+$/g, "")
    .slice(0, 100);
}
