// Colours of drawings, light and dark. Curves: the palette of Okabe and Ito (2008), which people with any of the usual colour
// blindnesses can tell apart, in an order that keeps neighbours far apart on the ground in question. Heat: from dark blue
// through green to light yellow with lightness growing all the way, so that it also reads in grey.
const BLUE = "#0072b2";
const SKY = "#56b4e9";
const GREEN = "#009e73";
const YELLOW = "#f0e442";
const ORANGE = "#e69f00";
const VERMILLION = "#d55e00";
const PURPLE = "#cc79a7";

const LIGHT = {
  ground: "#ffffff",
  ink: "#1b1f24",
  faint: "#59616a",
  line: "#e3e6ea",
  axis: "#9aa2ab",
  alarm: VERMILLION,
  series: [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY],
};
const DARK = {
  ground: "#1c2024",
  ink: "#e4e7ea",
  faint: "#9aa4ae",
  line: "#2d3339",
  axis: "#5d6670",
  alarm: ORANGE,
  series: [SKY, ORANGE, GREEN, PURPLE, YELLOW, VERMILLION],
};

export function palette(theme) {
  return theme === "dark" ? DARK : LIGHT;
}

const HEAT = [
  [38, 32, 92],
  [40, 80, 140],
  [30, 124, 142],
  [48, 165, 126],
  [140, 200, 88],
  [250, 232, 110],
];

// The colour of a share from 0 to 1 as [red, green, blue].
export function heat(share) {
  const place = Math.max(0, Math.min(1, share)) * (HEAT.length - 1);
  const low = Math.min(Math.floor(place), HEAT.length - 2);
  return HEAT[low].map((value, i) => Math.round(value + (place - low) * (HEAT[low + 1][i] - value)));
}

export const heatCss = (share) => `rgb(${heat(share).join(" ")})`;
