// Writes a content policy into a built page: it allows the page's own script and style, by their hashes, and loads
// nothing else.
import { createHash } from "node:crypto";
import type { Plugin } from "vite";

const hash = (text: string) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

/** The text between the tags of each such element of the page; only scripts that run are included. */
function contents(html: string, tag: string): string[] {
  const found = [...html.matchAll(new RegExp(`<${tag}([^>]*)>([\\s\\S]*?)</${tag}>`, "g"))];
  return found.filter((match) => !/type="(application|text)\/json"/.test(match[1])).map((match) => match[2]);
}

/** Further sources that a page needs. */
interface Extra {
  readonly script?: string;
  readonly connect?: string;
}

export function policyOf(html: string, { script = "", connect }: Extra = {}): string {
  const scripts = contents(html, "script").map(hash).join(" ");
  const styles = contents(html, "style").map(hash).join(" ");
  return [
    "default-src 'none'",
    `script-src ${scripts || "'none'"}${script}`,
    `style-src ${styles || "'none'"}`,
    "img-src data: blob:",
    ...(connect ? [`connect-src ${connect}`] : []),
    "base-uri 'none'",
    "form-action 'none'",
  ].join("; ");
}

/** Replaces `<meta name="content-policy">` of the page by the policy. */
export function contentPolicy(extra: Extra = {}): Plugin {
  return {
    name: "content-policy",
    enforce: "post",
    generateBundle: {
      order: "post",
      handler(_options, bundle) {
        for (const file of Object.values(bundle)) {
          if (file.type !== "asset" || !file.fileName.endsWith(".html")) continue;
          const html = String(file.source);
          const tag = `<meta http-equiv="Content-Security-Policy" content="${policyOf(html, extra)}" />`;
          file.source = html.replace('<meta name="content-policy" />', () => tag);
        }
      },
    },
  };
}
