// The 3D picture in its place in the page, or a message that gives the reason for its absence.
import type { Model } from "../recording";
import { Stage } from "../viewer/stage";
import { h } from "./dom";

/** Tooltip of the button that switches between body colours and mechanism colours. */
export const ownColoursTitle =
  "Show bodies in their own colours, outlined in their mechanism's colour, or all in their mechanism's colour";

const message = (...children: (Node | string)[]) => h("div", { class: "placeholder", role: "alert" }, ...children);

/** null if the browser can't draw it: a message then gives the reason, and `alternatives` names what works without it. */
export function mountStage(host: HTMLElement, model: Model, alternatives: readonly (Node | string)[]): Stage | null {
  const disable = (tools: boolean) => {
    for (const each of host.querySelectorAll<HTMLElement>(".tools")) each.inert = tools;
  };
  disable(false);
  let stage: Stage | null = null;
  let reason = "";
  try {
    stage = new Stage(host, model);
  } catch (error) {
    reason = error instanceof Error ? error.message : String(error);
  }
  if (!stage) {
    host.append(
      message(
        h("h2", {}, "No 3D picture"),
        h("p", {}, `This browser can't draw it: ${reason}.`),
        h("p", {}, "Switch on hardware acceleration in its settings, or open this page in another browser."),
        h("p", {}, ...alternatives),
      ),
    );
    return null;
  }
  let shown: HTMLElement | null = null;
  stage.onContextChange((lost) => {
    disable(lost);
    shown?.remove();
    shown = null;
    if (!lost) return;
    const reload = h("button", { type: "button", onclick: () => location.reload() }, "Reload");
    shown = message(
      h("h2", {}, "The 3D picture was lost"),
      h("p", {}, "The browser lost its graphics context, as after a reset of the graphics driver."),
      h("p", {}, "It is restored as soon as the browser provides a new one. Otherwise, reload the page. ", reload),
    );
    host.append(shown);
  });
  return stage;
}
