import type { Problem } from "./bodies.js";
import { REMEDIES } from "./generated.js";

/** Anything that this package throws about the service. */
export class RevprioError extends Error {
  override name = "RevprioError";
  /** Whether a later call may succeed: the service cannot be reached, is late, or has no time. */
  readonly isSilence: boolean = false;
}

/** The service cannot be reached, or the connection broke. */
export class NoAnswerError extends RevprioError {
  override name = "NoAnswerError";
  override readonly isSilence = true;

  constructor(readonly url: string, cause: unknown) {
    super(`no answer from ${url}: ${reason(cause)}; is the service running there?`, { cause });
  }
}

/** The service did not answer in time. */
export class LateAnswerError extends NoAnswerError {
  override name = "LateAnswerError";
}

/** Something answered, but not as a revprio service does. */
export class ForeignAnswerError extends RevprioError {
  override name = "ForeignAnswerError";
  override readonly isSilence: boolean;

  constructor(readonly url: string, readonly status: number) {
    super(`${url} answered with status ${status}, but not as a revprio service does`);
    this.isSilence = status >= 500;
  }
}

/** The service refused a request and says why (RFC 9457, `application/problem+json`). */
export class ProblemError extends RevprioError {
  override name = "ProblemError";
  /** Stable identifier of the kind of problem. */
  readonly type: string;
  /** HTTP status. */
  readonly status: number;
  /** What is wrong, in words. */
  readonly detail: string;
  /** JSON pointer of the offending field, if there is one. */
  readonly pointer: string | undefined;
  /** What to do about it. */
  readonly remedy: string;
  override readonly isSilence: boolean;

  constructor(readonly problem: Problem, /** What `Retry-After` asks for, s. */ readonly retryAfterS?: number) {
    const remedy = REMEDIES[problem.type] ?? problem.title;
    const place = problem.pointer ? ` at ${problem.pointer}` : "";
    super(`${problem.detail} (${problem.status} ${problem.type}${place}). ${remedy}`);
    ({ type: this.type, status: this.status, detail: this.detail } = problem);
    this.pointer = problem.pointer ?? undefined;
    this.remedy = remedy;
    this.isSilence = problem.status >= 500 || problem.status === 408 || problem.status === 429;
  }
}

/** Whether something is a problem of the service. */
export function isProblem(body: unknown): body is Problem {
  return typeof body === "object" && body !== null && "status" in body && "detail" in body && "type" in body;
}

function reason(cause: unknown): string {
  if (!(cause instanceof Error)) return String(cause);
  return cause.cause instanceof Error ? cause.cause.message : cause.message;
}
