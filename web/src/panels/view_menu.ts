// The buttons that change what the picture shows: on phones, where the picture needs the room, they are behind the button View.
import { h } from "./dom";

export interface ViewMenu {
  readonly element: HTMLElement;
  /** How far the button View reaches into the picture from above (px); 0 where the others are beside it. */
  readonly room: () => number;
}

export function viewMenu(...buttons: (HTMLElement | false)[]): ViewMenu {
  const more = h(
    "button",
    { type: "button", class: "more", "aria-expanded": "false", title: "What the picture shows" },
    "View",
  );
  const element = h("div", { class: "tools view-tools" }, more, ...buttons);
  const open = (on: boolean) => {
    element.classList.toggle("open", on);
    more.setAttribute("aria-expanded", String(on));
  };
  more.addEventListener("click", () => open(!element.classList.contains("open")));
  // It closes after a picture was saved, by Escape and by a press elsewhere; not while a video is recorded, which is ended in it.
  const close = () => element.querySelector(".recording") || open(false);
  element.addEventListener("click", (event) => (event.target as HTMLElement).closest(".save .menu") && close());
  element.addEventListener("keydown", (event) => event.key === "Escape" && close());
  document.addEventListener("pointerdown", (event) => element.contains(event.target as Node) || close());
  const room = () => {
    const box = more.getBoundingClientRect();
    const picture = element.closest(".stage")?.getBoundingClientRect();
    return picture && box.height > 0 ? Math.max(box.bottom - picture.top, 0) : 0;
  };
  return { element, room };
}
