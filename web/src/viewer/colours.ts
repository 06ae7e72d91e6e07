// Colours of mechanisms, distinguishable also for colour-blind readers (after Okabe and Ito), on a dark and a light
// background.

export interface Theme {
  readonly dark: boolean;
  readonly ground: string;
  readonly ink: string;
  readonly grid: string;
  readonly mechanisms: readonly string[];
}

const light: Theme = {
  dark: false,
  ground: "#f7f8fa",
  ink: "#1d2530",
  grid: "#d4d9e0",
  mechanisms: ["#1f6fb5", "#d5560a", "#12805c", "#a0408a", "#8a6d00", "#0f8fa8", "#b3263e", "#5b5fc7"],
};

const dark: Theme = {
  dark: true,
  ground: "#12161c",
  ink: "#e6eaf0",
  grid: "#2b333e",
  mechanisms: ["#58a6f0", "#ff9248", "#3fc796", "#e089c8", "#e3c04a", "#4fd0e6", "#ff7388", "#a3a6ff"],
};

export const themeOf = (isDark: boolean): Theme => (isDark ? dark : light);

/** The colour of a mechanism, or of a series in a plot. */
export const mechanismColour = (theme: Theme, mechanism: number) => theme.mechanisms[mechanism % theme.mechanisms.length];

/** Colour names that scenarios may use in addition to "#rrggbb" (docs/scenario.md), as in CSS. */
const named: ReadonlyMap<string, string> = new Map(
  Object.entries({
    black: "#000000",
    white: "#ffffff",
    gray: "#808080",
    grey: "#808080",
    silver: "#c0c0c0",
    red: "#ff0000",
    maroon: "#800000",
    orange: "#ffa500",
    gold: "#ffd700",
    yellow: "#ffff00",
    olive: "#808000",
    green: "#008000",
    lime: "#00ff00",
    teal: "#008080",
    cyan: "#00ffff",
    blue: "#0000ff",
    navy: "#000080",
    purple: "#800080",
    magenta: "#ff00ff",
    pink: "#ffc0cb",
    brown: "#a52a2a",
    tan: "#d2b48c",
    steelblue: "#4682b4",
  }),
);

/** A shape's colour as "#rrggbb"; null if it is not a colour: the mechanism's is used. */
export const hexOf = (colour: string): string | null =>
  /^#[0-9a-f]{6}$/i.test(colour) ? colour.toLowerCase() : (named.get(colour) ?? null);

/** A colour between two, both as "#rrggbb"; share 0: the first. */
export function mixed(a: string, b: string, share: number): string {
  const parts = [1, 3, 5].map((at) => {
    const from = parseInt(a.slice(at, at + 2), 16);
    const to = parseInt(b.slice(at, at + 2), 16);
    return Math.round(from + share * (to - from))
      .toString(16)
      .padStart(2, "0");
  });
  return `#${parts.join("")}`;
}

/** The relative luminance of a colour "#rrggbb", as in WCAG 2. */
const luminance = (colour: string) =>
  [0.2126, 0.7152, 0.0722].reduce((sum, weight, k) => {
    const x = parseInt(colour.slice(1 + 2 * k, 3 + 2 * k), 16) / 255;
    return sum + weight * (x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
  }, 0);

/** Least contrast of a shape with a dark ground: below that its shaded sides can't be seen. */
const leastContrast = 3.5;

/** A shape's own colour; on a dark ground a dark one is brighter. */
export function shapeColour(colour: string, { dark: isDark, ground, ink }: Theme): string {
  const faint = (shown: string) => (luminance(shown) + 0.05) / (luminance(ground) + 0.05) < leastContrast;
  if (!isDark) return colour;
  for (let share = 0; share < 1; share += 0.05) {
    const shown = mixed(colour, ink, share);
    if (!faint(shown)) return shown;
  }
  return ink;
}

/** Calls back immediately and whenever the reader's choice between dark and light changes. */
export function onThemeChange(listener: (theme: Theme) => void) {
  const query = window.matchMedia("(prefers-color-scheme: dark)");
  const notify = () => {
    const forced = document.documentElement.dataset.theme;
    listener(themeOf(forced ? forced === "dark" : query.matches));
  };
  query.addEventListener("change", notify);
  document.addEventListener("themechange", notify);
  notify();
}
