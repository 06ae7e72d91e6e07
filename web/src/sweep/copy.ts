// A command with a button that copies it.
import { h } from "../panels/dom";

async function copied(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return false; // pages from disk may not, in some browsers
  }
}

/** `what`: for screen readers, as "the command for world 3". */
export function copyButton(text: string, what: string): HTMLButtonElement {
  const button = h("button", { type: "button", class: "copy", "aria-label": `Copy ${what}`, title: text }, "Copy");
  button.addEventListener("click", async (event) => {
    event.stopPropagation();
    const done = await copied(text);
    button.textContent = done ? "Copied" : "Not allowed";
    setTimeout(() => (button.textContent = "Copy"), 1500);
  });
  return button;
}

/** The command itself, which can be selected, and the button. */
export const command = (text: string, what: string): HTMLElement =>
  h("span", { class: "command" }, h("code", {}, text), copyButton(text, what));
