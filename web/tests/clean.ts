// After every file of tests: removes the folders that it made.
import { afterAll } from "vitest";
import { removeTemporary } from "./browser";

afterAll(removeTemporary);
