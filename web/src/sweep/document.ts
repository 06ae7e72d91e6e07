// The document that `momentree sweep --report` writes into the page. Numbers that are absent are null; only `format`,
// `columns` and `values` are always there.

export interface SweepDocument {
  readonly format: 1;
  readonly program?: { readonly name?: string; readonly version?: string };
  readonly title?: string;
  /** File names: of the sweep, and of the scenario that it varies. */
  readonly sweep?: string;
  readonly scenario?: string;
  readonly seed?: number;
  /** By what some worlds were computed before changes of the sweep were accepted. */
  readonly accepted_changes?: readonly { readonly version: string; readonly hash: string }[];
  /** Numbers of worlds: planned, finished, failed, and in `values`, which is a random sample of the worlds if these are many. */
  readonly worlds?: number;
  readonly done?: number;
  readonly failed?: number;
  readonly shown?: number;
  readonly columns: readonly ColumnDocument[];
  readonly sensitivities?: readonly Sensitivity[];
  /** By column, and the numbers of the worlds as `world`. */
  readonly values: Readonly<Record<string, readonly (number | boolean | string | null)[]>>;
  readonly failures?: readonly Failure[];
  /** Number of `failures`, the first of all failed worlds. */
  readonly failures_listed?: number;
  readonly worst?: readonly Worst[];
}

export type Role = "vary" | "measure";
export type Kind = "number" | "flag" | "text";

/** A column with its statistics, which are of all worlds, also of those that are not in `values`. */
export interface ColumnDocument {
  readonly name: string;
  readonly role?: Role;
  readonly kind?: Kind;
  /** What it is: a distribution, or the measured quantity. */
  readonly about?: string;
  readonly unit?: string;
  readonly count?: number;
  readonly missing?: number;
  readonly mean?: number | null;
  readonly deviation?: number | null;
  readonly least?: number | null;
  readonly greatest?: number | null;
  readonly least_world?: number | null;
  readonly greatest_world?: number | null;
  /** By probability. */
  readonly quantiles?: Readonly<Record<string, number | null>>;
  readonly histogram?: Histogram | null;
  /** Of flags: the share of worlds where it is true, with its 95 % confidence interval. */
  readonly share?: number | null;
  readonly interval?: readonly [number, number] | null;
}

/** Numbers of values in bins of equal width. */
export interface Histogram {
  readonly from: number;
  readonly to: number;
  readonly counts: readonly number[];
}

export interface Sensitivity {
  readonly measure: string;
  readonly vary: string;
  /** Rank correlation. */
  readonly correlation: number | null;
  /** First-order Sobol index. */
  readonly first_order: number | null;
  /** Worlds that have both values; null if unknown. */
  readonly pairs?: number | null;
  /** Why the numbers have a limited meaning. */
  readonly conditional?: boolean;
  readonly correlated?: boolean;
}

export interface Failure {
  readonly world: number;
  readonly why: string;
  readonly replay: string;
}

export interface WorstWorld {
  readonly world: number;
  readonly value: number | null;
  readonly replay: string;
  /** Of the world's own report, relative to the page. */
  readonly animation: string | null;
}

export interface Worst {
  readonly measure: string;
  readonly end: "greatest" | "least";
  readonly worlds: readonly WorstWorld[];
}

/** A column as the page uses it: what the document leaves out is computed from its values. */
export interface Column {
  readonly name: string;
  readonly role: Role;
  readonly kind: Kind;
  readonly about: string;
  readonly unit: string;
  /** By row; NaN if missing. Flags are 0 and 1, texts are indices into `labels`. */
  readonly values: Float64Array;
  readonly labels: readonly string[];
  readonly count: number;
  readonly missing: number;
  /** NaN without values, and for texts. */
  readonly mean: number;
  readonly deviation: number;
  readonly least: number;
  readonly greatest: number;
  readonly leastWorld: number | null;
  readonly greatestWorld: number | null;
  readonly quantiles: ReadonlyMap<number, number>;
  readonly histogram: Histogram | null;
  readonly share: number;
  readonly interval: readonly [number, number] | null;
}

export interface Sweep {
  readonly title: string;
  readonly version: string;
  readonly file: string;
  readonly scenario: string;
  readonly seed: number | null;
  /** The versions of momentree that computed worlds before changes were accepted. */
  readonly accepted: readonly string[];
  readonly worlds: number;
  readonly done: number;
  readonly failed: number;
  /** Numbers of the worlds, by row. */
  readonly world: Float64Array;
  readonly columns: readonly Column[];
  readonly sensitivities: readonly Sensitivity[];
  readonly failures: readonly Failure[];
  readonly worst: readonly Worst[];
}
