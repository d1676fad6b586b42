"use strict";
// Runs before anything is drawn, so that a chosen theme does not flash. Themes: that of the system, light, dark.
const theme = {
  names: ["system", "light", "dark"],
  read() {
    try {
      return localStorage.getItem("theme") || "system";
    } catch {
      return "system";
    }
  },
  set(name) {
    document.documentElement.dataset.theme = name;
    try {
      localStorage.setItem("theme", name);
    } catch {
      // Without storage the choice holds for this page.
    }
    const button = document.getElementById("theme");
    if (button) {
      button.textContent = W.theme[name];
      button.setAttribute("aria-label", W.theme.label(W.theme.names[name]));
    }
    document.dispatchEvent(new Event("themechange"));
  },
  next() {
    const index = theme.names.indexOf(document.documentElement.dataset.theme);
    theme.set(theme.names[(index + 1) % theme.names.length]);
  },
};
document.documentElement.classList.add("js");
theme.set(theme.read());
// Paper is white, whatever the screen is.
let onScreen = null;
addEventListener("beforeprint", () => {
  onScreen = document.documentElement.dataset.theme;
  document.documentElement.dataset.theme = "light";
  document.dispatchEvent(new Event("themechange"));
});
addEventListener("afterprint", () => {
  document.documentElement.dataset.theme = onScreen ?? theme.read();
  document.dispatchEvent(new Event("themechange"));
});
document.addEventListener("DOMContentLoaded", () => {
  theme.set(theme.read());
  document.getElementById("theme").addEventListener("click", theme.next);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => document.dispatchEvent(new Event("themechange")));
