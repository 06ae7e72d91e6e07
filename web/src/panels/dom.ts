// Creates elements in one expression. Text is always inserted as text: names come from files and are never parsed as
// HTML.

type Child = Node | string | null | undefined | false;
type Attributes = Readonly<Record<string, string | number | boolean | ((event: never) => void) | undefined>>;

/**
 * An element; attributes that begin with `on` are listeners, `true` is an attribute without a value, `false` omits it.
 */
export function h<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== undefined) element.setAttribute(name, String(value));
  }
  for (const child of children) if (child) element.append(child);
  return element;
}

/** Whether a dialog covers the page: keys are not for what is behind it. */
export const isCovered = () => document.querySelector("dialog[open]") !== null;

/** A table with a header; cells after the first contain numbers and are right-aligned. */
export function table(caption: string, head: readonly string[], rows: readonly (readonly string[])[]): HTMLTableElement {
  const cell = (text: string, column: number, tag: "th" | "td") =>
    column === 0 ? h("th", { scope: "row" }, text) : h(tag, tag === "th" ? { scope: "col" } : {}, text);
  return h(
    "table",
    {},
    h("caption", {}, caption),
    h("thead", {}, h("tr", {}, ...head.map((text) => (text ? h("th", { scope: "col" }, text) : h("td"))))),
    h("tbody", {}, ...rows.map((row) => h("tr", {}, ...row.map((text, column) => cell(text, column, "td"))))),
  );
}
