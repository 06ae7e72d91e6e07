// The playground's page: the world of a scenario that the reader chooses, writes or gets by a link.
import { h } from "../panels/dom";
import { Toast } from "../panels/toast";
import type { App } from "./app";
import { Editor } from "./editor";
import { gallery } from "./gallery";
import { about, sections } from "./help";
import { connections } from "./connections";
import { history, jointControls, sliders, weldControls } from "./panel";
import { fragmentOf, scopeOf } from "./share";
import { showWorldPage } from "./world_page";

export function showPlayground(page: HTMLElement, app: App) {
  /** Whether a scenario starts to move when it is opened. */
  const lively = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;

  const choice = h("select", { "aria-label": "Scenario" });
  for (const { name, title: text } of gallery) choice.append(h("option", { value: name }, text));
  const ownChoice = h("option", { value: "" }, "(your own)");
  choice.append(ownChoice);
  choice.addEventListener("change", () => {
    const example = gallery.find(({ name }) => name === choice.value);
    if (!example) return;
    forgetLink();
    start(example.text);
  });
  const toast = new Toast();
  const share = h("button", { type: "button", title: "Copy a link that contains this scenario" }, "Share");
  share.addEventListener("click", async () => {
    location.hash = await fragmentOf(editor.text, app.floor);
    const scope = scopeOf(location);
    let message = "Link copied";
    try {
      await navigator.clipboard.writeText(location.href);
    } catch {
      message = "The link is in the address bar";
    }
    toast.show(scope ? `${message}; ${scope}` : message);
  });

  const editor = new Editor(
    (text) => start(text, { floor: app.floor }),
    (text) => app.check(text),
  );
  const restart = h(
    "button",
    { type: "button", title: "From the start (R)", onclick: () => start(app.text || editor.text, { floor: app.floor }) },
    "⟲",
  );
  const floor = h(
    "button",
    {
      type: "button",
      title: "A floor below the mechanisms, on which all bodies land; starts again (D)",
      onclick: () => start(app.text || editor.text, { floor: !app.floor }),
    },
    "Floor",
  );
  app.listen(() => floor.setAttribute("aria-pressed", String(app.floor)));
  const world = showWorldPage(page, app, {
    name: "momentree",
    namesWorld: true,
    header: [choice, share],
    about,
    help: sections,
    controls: [history(app), jointControls(app), weldControls(app), connections(app), sliders(app)],
    tabs: [{ name: "Scenario", content: editor.element }],
    restart,
    tool: { button: floor, key: "d" },
  });
  page.append(toast.element);
  let source = "";
  /** Whether the page was opened by a link that contains no scenario. */
  let unreadable = false;
  /** The page has another scenario than that of an unreadable link: it also has it after a reload. */
  const forgetLink = () => {
    if (unreadable) window.history.replaceState(null, "", location.pathname + location.search);
    unreadable = false;
  };
  /** `from`: description of the text, as the beginning of a sentence. `floor`: with the floor of this page. */
  const start = (text: string, { from = "The scenario", floor = false } = {}) => {
    source = from;
    unreadable = false;
    app.play(false);
    if (editor.text !== text) editor.text = text;
    choice.value = gallery.find((example) => example.text === text)?.name ?? "";
    app.load(text, lively, floor);
  };
  /** There is no scenario to show: gives the reason, and shows no other scenario instead. */
  const showProblem = (reason: string, other: string) => {
    if (app.run) return app.showNotice(`${reason} This is still “${app.run.model.title}”.`);
    const title = gallery.find(({ text }) => text === other)?.title ?? "the scenario of this page";
    choice.selectedIndex = -1;
    unreadable = true;
    world.placeholder.show("No scenario", reason, {
      label: `Open “${title}” instead`,
      run: () => {
        forgetLink();
        start(other);
      },
    });
  };
  app.onChecked = (diagnostics) => editor.mark(diagnostics);
  app.onDiagnostics = (diagnostics) => {
    editor.show(diagnostics);
    if (!diagnostics.some(({ severity }) => severity === "error")) return;
    world.openTab("scenario");
    const remedy = "Correct them and press “Run this”, or choose another scenario from the list at the top.";
    world.placeholder.show(`${source} has errors`, `They are listed with their lines below the text. ${remedy}`);
  };

  app.listen((changed) => {
    if (changed !== "world" || !app.run) return;
    ownChoice.textContent = choice.value === "" && app.run.model.title ? `${app.run.model.title} (your own)` : "(your own)";
  });

  return { start, showProblem, frameRate: world.frameRate, placeOf: world.placeOf };
}
