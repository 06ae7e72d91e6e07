declare module "*?packed" {
  /** The file, deflated, in base64. */
  const packed: string;
  export default packed;
}
