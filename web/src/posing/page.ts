// Page for posing a model: a slider for each DoF, next to the picture. The engine computes the poses.
import { motionSize, type Engine } from "../../../wasm/host.mjs";
import { LiveRecording } from "../engine/live";
import { frameOf } from "../engine/messages";
import type { Meshes } from "../meshes";
import { h, table } from "../panels/dom";
import { helpButton, viewRows } from "../panels/help";
import { listenToKeys } from "../panels/keys";
import { count } from "../panels/numbers";
import { Picture } from "../panels/picture";
import { themeButton } from "../panels/theme_button";
import { modelOf, type ModelFile } from "../result_files";
import { onThemeChange } from "../viewer/colours";
import { Player } from "../viewer/player";
import { jointSliders } from "./sliders";

const help = () =>
  helpButton("A model without a motion: a slider for each degree of freedom of its joints poses it; loops stay closed.", [
    {
      title: "Pose",
      rows: [
        ["slider", "move a joint; rotations about three axes where it can rotate about all"],
        ["click a body", "show the sliders of its joint"],
        ["pointer on a body", "its name, mass and joint, and its frame"],
      ],
    },
    {
      title: "View",
      rows: [
        ...viewRows,
        ["F", "show the whole model"],
        ["P", "save the picture"],
        ["O", "bodies in their own colours, or in those of their mechanisms"],
      ],
    },
  ]);

/** Per body x, y, z, qw, qx, qy, qz. */
const posesOf = (motions: Float64Array) => Float32Array.from(motions.filter((_number, i) => i % motionSize < 7));

/** `scenario`: the model as the text of a scenario; `meshes`: those that it names. Throws if it has errors. */
export function showModel(page: HTMLElement, engine: Engine, scenario: string, meshes?: Meshes) {
  const world = engine.world();
  const { diagnostics, scenario: loaded } = world.load(scenario);
  if (!loaded) throw new Error(diagnostics.find(({ severity }) => severity === "error")?.what ?? "the model has errors");
  const kinds = world.kinds();
  const model = modelOf(world.model() as ModelFile, undefined, meshes);
  const first = frameOf(world);
  const run = new LiveRecording(model, world.topology(), first);
  const joints = run.topology.joints.map((joint) => ({
    ...joint,
    units: kinds[joint.kind].q,
    q: world.coordinates(joint.row),
  }));
  const tree = joints.filter(({ loop }) => !loop);
  const moving = tree.filter(({ units }) => units.length > 0);
  const loops = joints.length - tree.length;
  let q = tree.map((joint) => joint.q);
  const pose = (changed?: number) => {
    run.addFrame({ ...first, poses: posesOf(world.motionsAt(q.flat())) });
    if (loops > 0) {
      // Closing them moves other joints, too.
      const all = world.posed();
      q = q.map((each) => all.splice(0, each.length));
      q.forEach((each, j) => j !== changed && shown.get(j)?.set(each));
    }
    picture.show(player.time);
  };

  const title = model.title || "A model";
  document.title = `${title} – momentree`;
  const about = [count(model.bodies.length, "body", "bodies"), count(moving.length, "joint that moves", "joints that move")];
  if (loops > 0) about.push(count(loops, "loop, which stays closed", "loops, which stay closed"));
  page.append(h("header", {}, h("h1", {}, title), h("p", {}, about.join(" · ")), help(), themeButton()));
  const player = new Player(() => [first.time, first.time]);
  const list = h("section", { class: "plots sliders", "aria-label": "Joints" });
  const sections = new Map<number, HTMLElement>();
  const shown = new Map<number, ReturnType<typeof jointSliders>>();
  const picture = new Picture(run, player, (body) => sections.get(body)?.scrollIntoView({ block: "nearest" }), {
    static: true,
    alternatives: [h("code", {}, "momentree view MODEL --svg FILE"), " draws the model without a browser."],
  });
  const fill = () => {
    if (!picture.stage) {
      // Sliders would have nothing to move.
      const rows = joints.map(({ name, kind, parent }) => [name, kind, parent < 0 ? "ground" : model.bodies[parent].name]);
      return list.replaceChildren(table("Joints", ["", "kind", "on"], rows));
    }
    list.replaceChildren(h("button", { type: "button", onclick: reset }, "Back to the start"));
    for (const joint of moving) {
      const number = tree.indexOf(joint);
      const sliders = jointSliders(joint, joint.q, picture.size, (changed) => {
        q[number] = changed;
        pose(number);
      });
      shown.set(number, sliders);
      sections.set(joint.child, sliders.element);
      list.append(sliders.element);
    }
  };
  const reset = () => {
    q = tree.map((joint) => joint.q);
    pose();
    if (picture.stage?.following) picture.fit();
    fill();
  };
  page.classList.add("model");
  page.append(picture.element, list);
  onThemeChange((theme) => picture.setTheme(theme));
  picture.fit();
  if (picture.stage) picture.stage.following = true; // sliders move bodies out of the first picture
  fill();
  listenToKeys(run, player, picture.keys, { step: () => undefined });
}
