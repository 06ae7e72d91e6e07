declare module "*.wasm?packed" {
  /** The module, deflated, in base64. */
  const packed: string;
  export default packed;
}
