import { defineConfig } from "vitest/config";

// One browser at a time: it draws by the processor alone.
export default defineConfig({
  test: { testTimeout: 60_000, hookTimeout: 120_000, fileParallelism: false, include: ["**/*.test.ts"] },
});
