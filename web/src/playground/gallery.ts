// The project's scenarios that need no other file.
const files = import.meta.glob<string>("../../../scenarios/*.toml", { query: "?raw", import: "default", eager: true });

export interface Example {
  readonly name: string;
  readonly title: string;
  readonly text: string;
}

const first = ["breaking_chain", "capture", "crane", "falling_chimney", "modular_robot", "tree_of_joints"];
const order = (name: string) => (first.includes(name) ? first.indexOf(name) : first.length);

export const gallery: readonly Example[] = Object.entries(files)
  .map(([path, text]) => {
    const name = path.replace(/^.*\/|\.toml$/g, "");
    return { name, title: /^title\s*=\s*"([^"]*)"/m.exec(text)?.[1] ?? name, text };
  })
  .filter(({ name, text }) => !/^\s*(model|state)\s*=\s*"/m.test(text) && !name.endsWith("_accurate"))
  .sort((a, b) => order(a.name) - order(b.name) || a.name.localeCompare(b.name));
