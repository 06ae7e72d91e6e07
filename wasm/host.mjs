// JavaScript interface of the module for browsers, workers and Node. Types are in host.d.mts; engine.h documents the
// functions with their units and array layouts.

export const motionSize = 13;
export const jointSize = 29;
export const contactSize = 15;
export const status = { ok: 0, diverged: 1, interrupted: 2, refused: 3 };

/** An unexpected error of the engine. The instance that threw it must not be used again. */
export class EngineFailure extends Error {
  name = "EngineFailure";
}

const wasiOk = 0;
const wasiBadFile = 8;

/** System functions that the C library needs: a clock, and output for error messages; there are no files. */
function system(memory, log) {
  const view = () => new DataView(memory().buffer);
  return {
    clock_time_get: (_clock, _precision, to) => {
      view().setBigUint64(to, BigInt(Math.round(performance.now() * 1e6)), true);
      return wasiOk;
    },
    fd_write: (_file, pieces, count, written) => {
      let text = "";
      let bytes = 0;
      for (let i = 0; i < count; i++) {
        const at = view().getUint32(pieces + 8 * i, true);
        const length = view().getUint32(pieces + 8 * i + 4, true);
        text += new TextDecoder().decode(new Uint8Array(memory().buffer, at, length));
        bytes += length;
      }
      log(text);
      view().setUint32(written, bytes, true);
      return wasiOk;
    },
    fd_close: () => wasiBadFile,
    fd_seek: () => wasiBadFile,
    fd_read: () => wasiBadFile,
    fd_fdstat_get: () => wasiBadFile,
    fd_prestat_get: () => wasiBadFile,
    fd_prestat_dir_name: () => wasiBadFile,
    environ_sizes_get: (count, bytes) => {
      view().setUint32(count, 0, true);
      view().setUint32(bytes, 0, true);
      return wasiOk;
    },
    environ_get: () => wasiOk,
    proc_exit: (code) => {
      throw new EngineFailure(`the engine stopped (${code})`);
    },
  };
}

export class Engine {
  static async of(source, log = (text) => console.error(text)) {
    const module = source instanceof WebAssembly.Module ? source : await WebAssembly.compile(source);
    const engine = new Engine();
    const memory = () => engine.exports.memory;
    const text = (at, length) => new TextDecoder().decode(new Uint8Array(memory().buffer, at, length));
    const instance = await WebAssembly.instantiate(module, {
      wasi_snapshot_preview1: system(memory, log),
      momentree: {
        fail: (at, length) => {
          throw new EngineFailure(text(at, length));
        },
      },
    });
    engine.exports = instance.exports;
    engine.exports._initialize();
    return engine;
  }

  world() {
    return new World(this, this.exports.mt_create());
  }

  get bytes() {
    return this.exports.memory.buffer.byteLength;
  }

  /** Calls `use` with a text in the module's memory. */
  withText(text, use) {
    const bytes = new TextEncoder().encode(text);
    const at = this.exports.mt_allocate(bytes.length || 1);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
    const result = use(at, bytes.length);
    this.exports.mt_release(at);
    return result;
  }

  /** Numbers in the module's memory: valid until the module runs again. */
  numbers(at, count) {
    return new Float64Array(this.exports.memory.buffer, at, count);
  }
}

/** The numbers of mt_totals by name. */
export function totalsOf(numbers) {
  const [time, kinetic, potential, ...rest] = numbers;
  const [initial, final, dissipated, work, lost, released, error, projection] = rest.slice(6);
  const balance = { initial, final, dissipated, work, lost, released, error, projection };
  return {
    time,
    kinetic,
    potential,
    linear: rest.slice(0, 3),
    angular: rest.slice(3, 6),
    balance,
  };
}

export class World {
  constructor(engine, handle) {
    this.engine = engine;
    this.handle = handle;
    this.calls = engine.exports;
  }

  text() {
    const at = this.calls.mt_text(this.handle);
    const bytes = new Uint8Array(this.calls.memory.buffer, at, this.calls.mt_text_length(this.handle));
    return new TextDecoder().decode(bytes);
  }
  done(code) {
    return code === status.ok || code === status.interrupted
      ? { status: code, message: "" }
      : { status: code, message: this.text() };
  }

  load(scenario, { floor = false } = {}) {
    const load = floor ? this.calls.mt_load_on_floor : this.calls.mt_load;
    this.engine.withText(scenario, (at, length) => load(this.handle, at, length));
    const answer = JSON.parse(this.text());
    return {
      scenario: answer.scenario ?? null,
      diagnostics: answer.diagnostics,
    };
  }
  model() {
    this.calls.mt_model(this.handle);
    return JSON.parse(this.text());
  }
  kinds() {
    this.calls.mt_kinds(this.handle);
    return JSON.parse(this.text());
  }
  topology() {
    this.calls.mt_topology(this.handle);
    return JSON.parse(this.text());
  }
  events(first = 0) {
    this.calls.mt_events(this.handle, first);
    return JSON.parse(this.text());
  }
  get revision() {
    return this.calls.mt_revision(this.handle);
  }
  get eventCount() {
    return this.calls.mt_event_count(this.handle);
  }
  get time() {
    return this.calls.mt_time(this.handle);
  }
  get bodies() {
    return this.calls.mt_bodies(this.handle);
  }

  run(time, budget = Infinity) {
    return this.done(this.calls.mt_run(this.handle, time, Math.min(budget, 1e6)));
  }
  motions() {
    return this.engine.numbers(this.calls.mt_motions(this.handle), this.bodies * motionSize);
  }
  get jointRows() {
    return this.calls.mt_joint_rows(this.handle);
  }
  /** `q`: the coordinates of all joints of the tree. */
  motionsAt(q) {
    const at = this.calls.mt_allocate(8 * q.length || 1);
    this.engine.numbers(at, q.length).set(q);
    const motions = this.calls.mt_motions_at(this.handle, at);
    this.calls.mt_release(at);
    return this.engine.numbers(motions, this.bodies * motionSize);
  }
  /** The coordinates of the last motionsAt(). */
  posed(count) {
    return Array.from(this.engine.numbers(this.calls.mt_posed(this.handle), count));
  }
  coordinates(row) {
    const numbers = this.joints().subarray(jointSize * row);
    return Array.from(numbers.subarray(2, 2 + numbers[0]));
  }
  joints(withReactions = false) {
    return this.engine.numbers(this.calls.mt_joints(this.handle, withReactions ? 1 : 0), this.jointRows * jointSize);
  }
  contacts() {
    const count = this.calls.mt_contacts(this.handle);
    return this.engine.numbers(this.calls.mt_contact_numbers(this.handle), count * contactSize);
  }
  totals() {
    return totalsOf(this.engine.numbers(this.calls.mt_totals(this.handle), 17));
  }

  break(joint) {
    return this.done(this.calls.mt_break(this.handle, joint));
  }
  free(joint) {
    return this.done(this.calls.mt_free(this.handle, joint));
  }
  lock(joint) {
    return this.done(this.calls.mt_lock(this.handle, joint));
  }
  unlock(joint) {
    return this.done(this.calls.mt_unlock(this.handle, joint));
  }
  weld(body, to) {
    return this.done(this.calls.mt_weld(this.handle, body, to));
  }
  attach(body, to, kind, axis) {
    return this.done(this.engine.withText(kind, (at, n) => this.calls.mt_attach(this.handle, body, to, at, n, ...axis)));
  }
  change(joint, kind) {
    return this.done(this.engine.withText(kind, (at, n) => this.calls.mt_change(this.handle, joint, at, n)));
  }
  impulse(body, force, point) {
    return this.done(this.calls.mt_impulse(this.handle, body, ...force, ...point));
  }
  set(joint, { damping = NaN, stiffness = NaN, force = NaN, torque = NaN }) {
    return this.done(this.calls.mt_set(this.handle, joint, damping, stiffness, force, torque));
  }
  setDamping(factor, offset) {
    return this.done(this.calls.mt_set_damping(this.handle, factor, offset));
  }
  limitStrength(force) {
    return this.done(this.calls.mt_limit_strength(this.handle, force));
  }
  setGravity(gravity) {
    return this.done(this.calls.mt_set_gravity(this.handle, ...gravity));
  }

  grab(body, point, strength = 1) {
    return this.done(this.calls.mt_grab(this.handle, body, ...point, strength));
  }
  pull(target) {
    this.calls.mt_pull(this.handle, ...target);
  }
  releaseGrip() {
    this.calls.mt_release_grip(this.handle);
  }

  snapshot() {
    return this.calls.mt_snapshot(this.handle);
  }
  restore(snapshot) {
    return this.done(this.calls.mt_restore(this.handle, snapshot));
  }
  drop(snapshot) {
    this.calls.mt_drop(this.handle, snapshot);
  }
  undo(event, again = false) {
    return this.done(this.calls.mt_undo(this.handle, event, again ? 1 : 0));
  }
  branch() {
    return new World(this.engine, this.calls.mt_branch(this.handle));
  }
  destroy() {
    this.calls.mt_destroy(this.handle);
    this.handle = 0;
  }
}
