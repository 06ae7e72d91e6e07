// Dark or light: the system's setting, until the reader chooses.
import { h } from "./dom";

export function themeButton(): HTMLButtonElement {
  const button = h("button", { type: "button", title: "Dark or light", "aria-label": "Dark or light" }, "◐");
  button.addEventListener("click", () => {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : window.matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    document.dispatchEvent(new Event("themechange"));
  });
  return button;
}
