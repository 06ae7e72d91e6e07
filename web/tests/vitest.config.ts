import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

// One browser at a time: it draws by the processor alone, so that on a busy machine a frame may take seconds. A test that fails
// is therefore run once more; the output says so.
export default defineConfig({
  test: {
    slowTestThreshold: 60_000, // short output: on a busy machine nearly every test takes seconds
    testTimeout: 180_000,
    retry: 1,
    hookTimeout: 120_000,
    fileParallelism: false,
    include: ["**/*.test.ts"],
    setupFiles: [fileURLToPath(new URL("clean.ts", import.meta.url))],
  },
});
