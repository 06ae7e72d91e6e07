// What the reader looks at: one picked world, and a set of marked worlds. All parts of the page follow it.
import type { Column, Sweep } from "./document";

export type Change = "picked" | "marked" | "axes";

export class Explorer {
  /** The number of a world; null if none is picked. */
  picked: number | null = null;
  /** By row, whether it is marked; null if no set is marked. */
  marked: Uint8Array | null = null;
  /** What is marked, in words. */
  markedAs = "";
  /** Columns of the scatter plot. */
  x: Column | null = null;
  y: Column | null = null;
  private readonly rows: ReadonlyMap<number, number>;
  private readonly listeners: ((change: Change) => void)[] = [];

  constructor(readonly sweep: Sweep) {
    this.rows = new Map(Array.from(sweep.world, (world, row) => [world, row]));
  }

  listen(listener: (change: Change) => void) {
    this.listeners.push(listener);
  }

  /** The row of a world; -1 if the page has only a sample without it. */
  rowOf(world: number): number {
    return this.rows.get(world) ?? -1;
  }

  column(name: string): Column | undefined {
    return this.sweep.columns.find((column) => column.name === name);
  }

  pick(world: number | null) {
    this.picked = world;
    this.tell("picked");
  }

  /** Marks the rows for which `holds`; `as`: these worlds in words. */
  mark(as: string, holds: (row: number) => boolean) {
    this.marked = Uint8Array.from(this.sweep.world, (_world, row) => Number(holds(row)));
    this.markedAs = as;
    this.tell("marked");
  }

  clearMarks() {
    if (!this.marked) return;
    this.marked = null;
    this.markedAs = "";
    this.tell("marked");
  }

  /** Number of marked worlds. */
  get markedCount(): number {
    return this.marked?.reduce((sum, one) => sum + one, 0) ?? 0;
  }

  plot(x: Column, y: Column) {
    this.x = x;
    this.y = y;
    this.tell("axes");
  }

  private tell(change: Change) {
    for (const listener of this.listeners) listener(change);
  }
}
