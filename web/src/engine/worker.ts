// The worker: hands messages between the page and a session of the engine on, and tells it the time.
import { Engine, EngineFailure, type Session } from "../../../wasm/host.mjs";
import { messageFrom, type FromWorker, type PostedMessage, type ToWorker } from "./messages";

const scope = self as unknown as { onmessage: (event: MessageEvent<ToWorker>) => void; postMessage(message: FromWorker): void };
let session: Session<ToWorker> | null = null;
let module: WebAssembly.Module | null = null;
let last = performance.now();

const post = (message: FromWorker) => scope.postMessage(message);

async function begin() {
  try {
    const engine = await Engine.of(module!);
    session = engine.session((message: PostedMessage, bytes) => post(messageFrom(message, bytes)));
    post({ type: "ready" });
  } catch (error) {
    post({ type: "failed", message: `The engine can't start: ${String(error)}` });
  }
}

/**
 * After an unexpected error of the engine, the world is lost but the page is not: a new instance replaces the old one.
 */
function guarded(work: () => void) {
  try {
    work();
  } catch (error) {
    session = null;
    const text = error instanceof EngineFailure ? error.message : `the engine stopped: ${String(error)}`;
    post({ type: "failed", message: text });
    void begin();
  }
}

scope.onmessage = ({ data }) => {
  if (data.type === "module")
    WebAssembly.compile(data.bytes).then(
      (compiled) => {
        module = compiled;
        return begin();
      },
      (error) => post({ type: "failed", message: `The engine can't start: ${String(error)}` }),
    );
  else guarded(() => session?.send(data));
};

setInterval(() => {
  const now = performance.now();
  const seconds = (now - last) / 1000;
  last = now;
  guarded(() => session?.tick(seconds));
}, 1000 / 60);
