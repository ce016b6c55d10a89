/** A landmark file that cannot be read; its message is one plain sentence. */
export class UnreadableLandmarks extends Error {}
