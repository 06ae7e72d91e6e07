// The project's scenarios; for the breaking chain, the variant that conserves energy. Scenarios with model files are
// included as `momentree convert` writes them (tools/make_gallery).
const written = import.meta.glob<string>("../../../scenarios/*.toml", { query: "?raw", import: "default", eager: true });
const converted = import.meta.glob<string>("../../gallery/*.toml", { query: "?raw", import: "default", eager: true });

export interface Example {
  readonly name: string;
  readonly title: string;
  readonly text: string;
}

const first = [
  ...[
    "excavator_pin",
    "humanoid_loses_a_forearm",
    "capture",
    "crane",
    "panda_lets_go",
    "hanging_boxes_fall",
    "four_bar",
    "breaking_chain_accurate",
  ],
  ...["blade_loss", "trapeze_catch", "debris_tug", "hexapod", "climbing_robot", "solar_array_jam"],
  ...["chain_to_ring", "knee_ligament", "line_cascade", "hand_over"],
  ...["falling_chimney", "quadruped_knee", "modular_robot", "tree_of_joints"],
];
const order = (name: string) => (first.includes(name) ? first.indexOf(name) : first.length);

export const gallery: readonly Example[] = Object.entries({ ...written, ...converted })
  .map(([path, text]) => {
    const name = path.replace(/^.*\/|\.toml$/g, "");
    return { name, title: /^title\s*=\s*"([^"]*)"/m.exec(text)?.[1] ?? name, text };
  })
  .filter(({ name, text }) => !/^\s*(model|state)\s*=\s*"/m.test(text) && name !== "breaking_chain")
  .sort((a, b) => order(a.name) - order(b.name) || a.name.localeCompare(b.name));
