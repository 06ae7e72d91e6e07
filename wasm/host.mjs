// JavaScript interface of the module for browsers, workers and Node. Types and units are in host.d.mts.

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
        post: (at, length, frame, bytes) =>
          engine.receive(JSON.parse(text(at, length)), bytes > 0 ? memory().buffer.slice(frame, frame + bytes) : undefined),
      },
    });
    engine.exports = instance.exports;
    engine.exports._initialize();
    return engine;
  }

  world() {
    return new World(this, this.exports.mt_open());
  }
  session(post) {
    return new Session(this, this.exports.mt_open(), post);
  }

  get bytes() {
    return this.exports.memory.buffer.byteLength;
  }

  /** Gets what the module posts during a call. */
  receive() {}

  /** Sends a message through `call`; `receive` gets what is posted. */
  send(call, handle, message, receive) {
    this.receive = receive;
    const bytes = new TextEncoder().encode(JSON.stringify(message));
    const at = this.exports.mt_allocate(bytes.length);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
    call(handle, at, bytes.length);
    this.exports.mt_release(at);
  }
}

/** A world that plays in real time, with the messages of web/src/engine/messages.ts. */
export class Session {
  constructor(engine, handle, post) {
    this.engine = engine;
    this.handle = handle;
    this.post = post;
  }
  send(message) {
    this.engine.send(this.engine.exports.mt_send, this.handle, message, this.post);
  }
  tick(seconds) {
    this.engine.receive = this.post;
    this.engine.exports.mt_tick(this.handle, seconds);
  }
}

/** The totals by name. */
export function totalsOf(numbers) {
  const [time, kinetic, potential, ...rest] = numbers;
  const [initial, final, dissipated, work, lost, released, error, projection] = rest.slice(6);
  const balance = {
    initial,
    final,
    dissipated,
    work,
    lost,
    released,
    error,
    projection,
  };
  return {
    time,
    kinetic,
    potential,
    linear: rest.slice(0, 3),
    angular: rest.slice(3, 6),
    balance,
  };
}

/** As the module numbers them. */
const kinds = ["state", "motions", "joints", "reactions", "totals", "contacts", "pose", "posed"];

export class World {
  constructor(engine, handle, loaded = null) {
    this.engine = engine;
    this.handle = handle;
    this.loaded = loaded;
  }

  /** The messages that answer one; `bytes`: of the frame in it. */
  ask(message) {
    const posted = [];
    this.engine.send(this.engine.exports.mt_ask, this.handle, message, (text, bytes) => posted.push({ ...text, bytes }));
    return posted;
  }
  /** Of a message to which there is an answer only if it was not carried out. */
  outcome(message) {
    const [answer] = this.ask(message);
    return {
      status: status[answer?.type] ?? status.ok,
      message: answer?.message ?? "",
    };
  }
  numbers(kind) {
    const { memory, mt_numbers } = this.engine.exports;
    const found = mt_numbers(this.handle, kinds.indexOf(kind));
    const [at, count] = new Uint32Array(memory.buffer, found, 2);
    return new Float64Array(memory.buffer, at, count);
  }

  load(scenario, { floor = false } = {}) {
    const [{ world, diagnostics }] = this.ask({
      type: "load",
      text: scenario,
      floor,
    });
    this.loaded = world ?? this.loaded;
    return { scenario: world?.scenario ?? null, diagnostics };
  }
  model() {
    return this.loaded.model;
  }
  kinds() {
    return this.loaded.kinds;
  }
  topology() {
    return this.ask({ type: "topology" })[0].topology;
  }
  events(first = 0) {
    return this.ask({ type: "events", first })[0].events;
  }
  get time() {
    return this.numbers("state")[0];
  }
  get revision() {
    return this.numbers("state")[1];
  }
  get eventCount() {
    return this.numbers("state")[2];
  }
  get bodies() {
    return this.numbers("state")[3];
  }
  get jointRows() {
    return this.numbers("state")[4];
  }

  run(time, budget = Infinity) {
    return this.outcome({ type: "run", time, budget: Math.min(budget, 1e6) });
  }
  motions() {
    return this.numbers("motions");
  }
  motionsAt(q) {
    const { message } = this.outcome({ type: "pose", q });
    if (message) throw new Error(message);
    return this.numbers("pose");
  }
  posed() {
    return Array.from(this.numbers("posed"));
  }
  coordinates(row) {
    const all = this.joints();
    return Array.from(all.subarray(jointSize * row + 2, jointSize * row + 2 + all[jointSize * row]));
  }
  joints(withReactions = false) {
    return this.numbers(withReactions ? "reactions" : "joints");
  }
  contacts() {
    return this.numbers("contacts");
  }
  totals() {
    return totalsOf(this.numbers("totals"));
  }

  act(action) {
    return this.outcome({ type: "act", action });
  }
  setGravity(value) {
    return this.outcome({ type: "gravity", value });
  }

  grab(body, point, strength = 1) {
    return this.outcome({ type: "grab", body, point, strength });
  }
  pull(target) {
    this.outcome({ type: "pull", target });
  }
  releaseGrip() {
    this.outcome({ type: "release" });
  }

  snapshot() {
    return this.ask({ type: "snapshot" })[0].snapshot;
  }
  restore(snapshot) {
    return this.outcome({ type: "restore", snapshot });
  }
  drop(snapshot) {
    this.outcome({ type: "drop", snapshot });
  }
  undo(event, again = false) {
    return this.outcome({ type: "undo", event, again });
  }
  branch() {
    return new World(this.engine, this.engine.exports.mt_branch(this.handle), this.loaded);
  }
  destroy() {
    this.engine.exports.mt_close(this.handle);
    this.handle = 0;
  }
}
