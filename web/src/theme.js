// Light or dark: as the system says, or as the switch says, kept in localStorage. CSS follows color-scheme by light-dark();
// drawings, which know no CSS, follow the store.
import { createStore } from "./store.js";

const KEY = "quietgear.theme";
const system = matchMedia("(prefers-color-scheme: dark)");

function stored() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // storage forbidden
  }
}

function resolve() {
  const wanted = stored();
  return wanted === "light" || wanted === "dark" ? wanted : system.matches ? "dark" : "light";
}

// "light" or "dark"
export const theme = createStore(resolve());

function apply() {
  theme.set(resolve());
  document.documentElement.style.colorScheme = theme.get();
}

export function switchTheme() {
  try {
    localStorage.setItem(KEY, theme.get() === "dark" ? "light" : "dark");
  } catch {
    // storage forbidden: the system's wish stays
  }
  apply();
}

system.addEventListener("change", apply);
apply();
