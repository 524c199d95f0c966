// Two ways to paint the same drawing: on a canvas, and as SVG elements. A drawing (draw.js) knows only this interface:
//   path(build, style)      build(target) gets something with moveTo, lineTo, closePath, arc and rect;
//                           style: {stroke, width, dash, fill, opacity}
//   text(x, y, string, style)   style: {fill, size, weight, anchor: start|middle|end, turn: degrees}; y is the baseline
//   clip(x, y, w, h, paint)     paint() is cut to the rectangle
//   title(string)           the text alternative, where there is one
import { pathRound } from "d3-path";

export const FONT = 'system-ui, "Segoe UI", "Noto Sans", sans-serif';

export function canvasPainter(context) {
  return {
    title() {},
    path(build, { stroke, width = 1, dash = [], fill, opacity = 1 }) {
      context.globalAlpha = opacity;
      context.beginPath();
      build(context);
      if (fill) {
        context.fillStyle = fill;
        context.fill();
      }
      if (stroke) {
        context.strokeStyle = stroke;
        context.lineWidth = width;
        context.lineJoin = "round";
        context.setLineDash(dash);
        context.stroke();
      }
      context.globalAlpha = 1;
    },
    text(x, y, string, { fill, size = 11, weight = 400, anchor = "start", turn = 0 }) {
      context.save();
      context.translate(x, y);
      context.rotate((turn * Math.PI) / 180);
      context.font = `${weight} ${size}px ${FONT}`;
      context.fillStyle = fill;
      context.textAlign = { start: "left", middle: "center", end: "right" }[anchor];
      context.fillText(string, 0, 0);
      context.restore();
    },
    clip(x, y, w, h, paint) {
      context.save();
      context.beginPath();
      context.rect(x, y, w, h);
      context.clip();
      paint();
      context.restore();
    },
  };
}

const SVG = "http://www.w3.org/2000/svg";

export function svgElement(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== undefined) made.setAttribute(key, value);
  return made;
}

let clips = 0;

// {painter, svg, graft}: what is painted ends up in the element svg of the given size, and so does an element given to graft.
export function svgPainter(width, height) {
  const svg = svgElement("svg", { xmlns: SVG, width, height, viewBox: `0 0 ${width} ${height}`, role: "img" });
  svg.setAttribute("font-family", FONT);
  let parent = svg;
  const add = (name, attributes) => parent.appendChild(svgElement(name, attributes));
  const painter = {
    title(string) {
      add("title", {}).textContent = string;
    },
    path(build, { stroke, width: lineWidth = 1, dash = [], fill, opacity }) {
      const target = pathRound(2);
      build(target);
      const d = target.toString();
      if (!d) return;
      add("path", {
        d,
        fill: fill || "none",
        stroke,
        "stroke-width": stroke && lineWidth,
        "stroke-dasharray": dash.length ? dash.join(" ") : undefined,
        "stroke-linejoin": stroke && "round",
        opacity,
      });
    },
    text(x, y, string, { fill, size = 11, weight, anchor = "start", turn = 0 }) {
      const turned = turn ? `rotate(${turn} ${x.toFixed(2)} ${y.toFixed(2)})` : undefined;
      add("text", {
        x: x.toFixed(2),
        y: y.toFixed(2),
        fill,
        "font-size": size,
        "font-weight": weight,
        "text-anchor": anchor,
        transform: turned,
      }).textContent = string;
    },
    clip(x, y, w, h, paint) {
      const id = `clip-${++clips}`;
      add("clipPath", { id }).append(svgElement("rect", { x, y, width: w, height: h }));
      const outer = parent;
      parent = add("g", { "clip-path": `url(#${id})` });
      paint();
      parent = outer;
    },
  };
  return { painter, svg, graft: (element) => parent.append(element) };
}
