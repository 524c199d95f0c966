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

// An SVG element as the text of a file.
export function svgText(svg) {
  return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(svg)}\n`;
}

export function figureSvgText(figure, options) {
  return svgText(figureSvg(figure, options));
}

// A PNG Blob of twice the size in CSS pixels, {width, height}, of what paint(context) paints.
export function canvasPng({ width, height }, paintOn) {
  const canvas = document.createElement("canvas");
  canvas.width = PNG_SCALE * width;
  canvas.height = PNG_SCALE * height;
  const context = canvas.getContext("2d");
  context.scale(PNG_SCALE, PNG_SCALE);
  paintOn(context);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

// The figure as a PNG Blob of twice the size.
export function figurePng(figure, { size = SIZE, ...options } = {}) {
  return canvasPng(size, (context) => paint(canvasPainter(context), figure, size, options));
}

// An SVG element that stands alone, with width and height, as a PNG Blob of twice the size.
export async function svgPng(svg) {
  const image = new Image();
  const url = URL.createObjectURL(new Blob([svgText(svg)], { type: "image/svg+xml" }));
  try {
    image.src = url;
    await image.decode();
    const size = { width: Number(svg.getAttribute("width")), height: Number(svg.getAttribute("height")) };
    return await canvasPng(size, (context) => context.drawImage(image, 0, 0, size.width, size.height));
  } finally {
    URL.revokeObjectURL(url);
  }
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
