/** The part of a WebSocket that a stream uses; browsers, Node 22 and the package `ws` provide it. */
export interface WebSocketLike {
  send(data: string): void;
  close(): void;
  addEventListener(type: "open" | "close", listener: () => void): void;
  addEventListener(type: "error", listener: (event: object) => void): void;
  addEventListener(type: "message", listener: (event: { data: unknown }) => void): void;
}

/** Opens a WebSocket. `headers` contains the tokens, which the WebSocket of browsers cannot send. */
export type WebSocketFactory = (url: string, protocol: string, headers: Record<string, string>) => WebSocketLike;
