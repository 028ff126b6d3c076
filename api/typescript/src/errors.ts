import type { Problem } from "./bodies.js";
import { REMEDIES } from "./generated.js";

/** Base class of all errors that concern the service. */
export class RevprioError extends Error {
  override name = "RevprioError";
  /** Whether a later call may succeed: the service cannot be reached, is late, or is overloaded. */
  readonly isSilence: boolean = false;
}

/** The service cannot be reached, or the connection was lost. */
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

/** The answer is not one of a revprio service. */
export class ForeignAnswerError extends RevprioError {
  override name = "ForeignAnswerError";
  override readonly isSilence: boolean;

  constructor(readonly url: string, readonly status: number) {
    super(`the answer of ${url} (status ${status}) is not from a revprio service`);
    this.isSilence = status >= 500;
  }
}

/** The service refused a request; the fields give the reason (RFC 9457, `application/problem+json`). */
export class ProblemError extends RevprioError {
  override name = "ProblemError";
  /** Stable identifier of the kind of problem. */
  readonly type: string;
  /** HTTP status. */
  readonly status: number;
  /** Description of the problem. */
  readonly detail: string;
  /** JSON pointer of the invalid field, if there is one. */
  readonly pointer: string | undefined;
  /** Possible values of that field, best first, if the service can list them: links for `base` and `tip`. */
  readonly candidates: readonly string[];
  /** What to do about the problem. */
  readonly remedy: string;
  override readonly isSilence: boolean;

  constructor(readonly problem: Problem, /** Value of the header `Retry-After`, s. */ readonly retryAfterS?: number) {
    const remedy = REMEDIES[problem.type] ?? problem.title;
    const place = problem.pointer ? ` at ${problem.pointer}` : "";
    super(`${problem.detail} (${problem.status} ${problem.type}${place}). ${remedy}`);
    ({ type: this.type, status: this.status, detail: this.detail } = problem);
    this.pointer = problem.pointer ?? undefined;
    this.candidates = problem.candidates ?? [];
    this.remedy = remedy;
    this.isSilence = problem.status >= 500 || problem.status === 408 || problem.status === 429;
  }
}

/** Returns whether a body is a problem that the service reports. */
export function isProblem(body: unknown): body is Problem {
  return typeof body === "object" && body !== null && "status" in body && "detail" in body && "type" in body;
}

function reason(cause: unknown): string {
  if (!(cause instanceof Error)) return String(cause);
  return cause.cause instanceof Error ? cause.cause.message : cause.message;
}
