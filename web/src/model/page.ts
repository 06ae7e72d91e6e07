// Page for posing a model by hand: a slider for each DoF, next to the picture.
import { listenToKeys } from "../panels/keys";
import { count } from "../panels/numbers";
import { h, table } from "../panels/dom";
import { Picture } from "../panels/picture";
import { themeButton } from "../panels/theme_button";
import type { Recording } from "../recording";
import { watchTheme } from "../viewer/colours";
import { Player } from "../viewer/player";
import { posesOf } from "./kinematics";
import { jointSliders } from "./sliders";

/** `run`: the model at its start, with at least one frame; only the first is shown. */
export function showModel(page: HTMLElement, run: Recording) {
  const { model } = run;
  const start = new Map(
    model.joints.map((joint) => [joint.name, run.joint(joint.name, "q").map((column) => column.values[0])]),
  );
  const coordinates = new Map<string, ArrayLike<number>>(start);
  let poses: ArrayLike<number> = posesOf(model, coordinates);
  const posed: Recording = { ...run, frames: 1, time: () => run.time(0), poses: () => poses, events: [], joints: run.joints };

  const title = model.title || "A model";
  document.title = `${title} – momentree`;
  const moving = model.joints.filter((joint) => joint.kind !== "weld");
  const about = [count(model.bodies.length, "body", "bodies"), count(moving.length, "joint that moves", "joints that move")];
  page.append(h("header", {}, h("h1", {}, title), h("p", {}, about.join(" · ")), themeButton()));
  const player = new Player(() => [run.time(0), run.time(0)]);
  const list = h("section", { class: "plots sliders", "aria-label": "Joints" });
  const legends = new Map<string, HTMLElement>();
  const inboard = new Map(model.joints.map((joint) => [joint.child, joint.name]));
  const picture = new Picture(
    posed,
    player,
    (body) => legends.get(inboard.get(body) ?? "")?.scrollIntoView({ block: "nearest" }),
    { still: true, besides: [h("code", {}, "momentree view MODEL --svg FILE"), " draws the model without a browser."] },
  );
  const fill = () => {
    if (!picture.stage) {
      // no joint that sliders could move
      const rows = model.joints.map(({ name, kind, parent }) => [
        name,
        kind,
        parent < 0 ? "ground" : model.bodies[parent].name,
      ]);
      return list.replaceChildren(table("Joints", ["", "kind", "on"], rows));
    }
    list.replaceChildren(
      h("button", { type: "button", onclick: reset }, "Back to the start"),
      ...moving.map((joint) => {
        const element = jointSliders(joint, coordinates.get(joint.name)!, picture.size, (q) => {
          coordinates.set(joint.name, q);
          poses = posesOf(model, coordinates);
          picture.show(player.time);
        });
        legends.set(joint.name, element);
        return element;
      }),
    );
  };
  const reset = () => {
    for (const [name, q] of start) coordinates.set(name, q);
    poses = posesOf(model, coordinates);
    picture.show(player.time);
    fill();
  };
  page.classList.add("model");
  page.append(picture.element, list);
  watchTheme((theme) => picture.setTheme(theme));
  picture.fit();
  fill();
  listenToKeys(posed, player, picture.keys, { step: () => undefined });
}
